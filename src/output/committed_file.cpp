#include "stylet/output/committed_file.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/output/text_file.hpp"

#include <array>
#include <cerrno>
#include <cstdint>
#include <fcntl.h>
#include <unistd.h>

namespace stylet {

namespace {

// Of the superblock, version 0: little-endian.
constexpr off_t version_at = 8;
constexpr off_t root_at = 64;  ///< address of the root's header, then what is cached of it
constexpr std::size_t address_bytes = 8;
using RootEntry = std::array<unsigned char, address_bytes + 4>;  // 0: nothing is cached

Hdf5Id open_file(const std::string& path, CommittedFile::Open how) {
  check_hdf5(H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr), path);  // errors are ours to report
  const Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, path);
  check_hdf5(H5Pset_libver_bounds(access.get(), H5F_LIBVER_EARLIEST, H5F_LIBVER_LATEST), path);
  check_hdf5(H5Pset_file_locking(access.get(), false, true), path);
  // Arrays are written whole; what describes those of a commit lies together.
  constexpr hsize_t metadata_block = 32768;
  check_hdf5(H5Pset_sieve_buf_size(access.get(), 0), path);
  check_hdf5(H5Pset_meta_block_size(access.get(), metadata_block), path);
  if (how == CommittedFile::Open::go_on) {
    return {H5Fopen(path.c_str(), H5F_ACC_RDWR, access.get()), H5Fclose, path};
  }
  return {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose,
          path + ": cannot be created"};
}

// An object reference is the address of the object's header.
RootEntry entry_of(hid_t group) {
  hobj_ref_t address = 0;
  check_hdf5(H5Rcreate(&address, group, ".", H5R_OBJECT, -1), "root");
  RootEntry entry{};
  for (std::size_t i = 0; i < address_bytes; ++i) {
    entry[i] = static_cast<unsigned char>(address >> (8 * i));
  }
  return entry;
}

}  // namespace

CommittedFile::CommittedFile(std::string path, Open how)
    : path_(std::move(path)),
      file_(open_file(path_, how)),
      root_(H5Gopen2(file_.get(), "/", H5P_DEFAULT), H5Gclose, path_),
      twin_(H5Gcreate_anon(file_.get(), H5P_DEFAULT, H5P_DEFAULT), H5Gclose, path_) {
  if (how == Open::go_on) link_as_root(twin_.get());
  flush();
  descriptor_ = ::open(path_.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor_ < 0) throw_io_error(path_, "cannot be opened");
  unsigned char version = 1;
  RootEntry named{};
  const bool is_read = ::pread(descriptor_, &version, 1, version_at) == 1 &&
                       ::pread(descriptor_, named.data(), address_bytes, root_at) == address_bytes;
  if (!is_read || version != 0 || named != entry_of(root_.get())) {
    throw IoError(path_ + ": HDF5 made a file of another version than 0");
  }
}

CommittedFile::~CommittedFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

hid_t CommittedFile::create_group(const std::string& name) {
  pending_.emplace_back(
      name, Hdf5Id(H5Gcreate_anon(file_.get(), small_group_properties().get(), H5P_DEFAULT),
                   H5Gclose, path_));
  return pending_.back().second.get();
}

void CommittedFile::commit() {
  link_pending(twin_.get());
  flush();
  name_root(twin_.get());
  link_pending(root_.get());
  flush();
  name_root(root_.get());
  pending_.clear();
}

std::vector<std::string> CommittedFile::names() const {
  H5G_info_t info{};
  check_hdf5(H5Gget_info(root_.get(), &info), path_);
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    char name[64] = "";
    check_hdf5(static_cast<herr_t>(H5Lget_name_by_idx(root_.get(), ".", H5_INDEX_NAME, H5_ITER_INC,
                                                      i, name, sizeof name, H5P_DEFAULT)),
               path_);
    names.emplace_back(name);
  }
  return names;
}

Hdf5Id CommittedFile::open(const std::string& path) const {
  return {H5Oopen(root_.get(), path.c_str(), H5P_DEFAULT), H5Oclose, path_ + ": " + path};
}

void CommittedFile::remove(std::span<const std::string> names) {
  unlink(twin_.get(), names);
  flush();
  name_root(twin_.get());
  unlink(root_.get(), names);
  flush();
  name_root(root_.get());
}

void CommittedFile::sync() const {
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != EROFS) {
    throw_io_error(path_, "cannot be written");
  }
}

void CommittedFile::link_as_root(hid_t twin) const {
  for (const std::string& name : names()) {
    check_hdf5(
        H5Lcreate_hard(root_.get(), name.c_str(), twin, name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
        path_);
  }
}

void CommittedFile::unlink(hid_t root, std::span<const std::string> names) const {
  for (const std::string& name : names) {
    check_hdf5(H5Ldelete(root, name.c_str(), H5P_DEFAULT), path_);
  }
}

void CommittedFile::link_pending(hid_t root) {
  for (const auto& [name, group] : pending_) {
    check_hdf5(H5Olink(group.get(), root, name.c_str(), H5P_DEFAULT, H5P_DEFAULT), path_);
  }
}

// HDF5 writes the superblock last.
void CommittedFile::flush() {
  check_hdf5(H5Fflush(file_.get(), H5F_SCOPE_LOCAL), path_);
}

void CommittedFile::name_root(hid_t root) {
  const RootEntry entry = entry_of(root);
  if (::pwrite(descriptor_, entry.data(), entry.size(), root_at) != ssize_t{entry.size()}) {
    throw_io_error(path_, "cannot be written");
  }
}

void CommittedFile::close() {
  pending_.clear();
  check_hdf5(H5Gclose(twin_.release()), path_);
  check_hdf5(H5Gclose(root_.release()), path_);
  check_hdf5(H5Fclose(file_.release()), path_);
}

}  // namespace stylet
