#include "stylet/output/checkpoint_file.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/fingerprint.hpp"
#include "stylet/output/hdf5.hpp"
#include "stylet/output/text_file.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

namespace stylet {

namespace {

constexpr std::string_view seal = "\nstylet checkpoint, SHA-256 of all before: ";
constexpr std::size_t digits = 64;
constexpr std::size_t seal_size = seal.size() + digits + 1;

using Column = Archive::Column;

/// Of the same length, as HDF5 stores them best.
struct Texts {
  std::size_t length = 1;
  std::string bytes;
};

Texts packed(const std::vector<std::string>& texts) {
  Texts all;
  for (const auto& text : texts) all.length = std::max(all.length, text.size());
  for (const auto& text : texts) {
    all.bytes += text;
    all.bytes.append(all.length - text.size(), '\0');
  }
  return all;
}

Hdf5Id text_type(std::size_t length) {
  Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose, "text");
  check_hdf5(H5Tset_size(type.get(), length), "text");
  check_hdf5(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), "text");
  check_hdf5(H5Tset_cset(type.get(), H5T_CSET_UTF8), "text");
  return type;
}

// Of the oldest format: in an image of a newer one the checksum of the superblock is not that of its bytes.
Hdf5Id memory_access(std::size_t increment) {
  Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "memory");
  check_hdf5(H5Pset_fapl_core(access.get(), increment, false), "memory");
  return access;
}

void store(hid_t file,
           const std::string& name,
           hid_t type,
           std::size_t n,
           std::size_t width,
           const void* data) {
  const std::array<hsize_t, 2> extent{n / width, width};
  const Hdf5Id space(H5Screate_simple(width > 1 ? 2 : 1, extent.data(), nullptr), H5Sclose, name);
  const Hdf5Id links(H5Pcreate(H5P_LINK_CREATE), H5Pclose, name);
  check_hdf5(H5Pset_create_intermediate_group(links.get(), 1), name);
  const Hdf5Id dataset(
      H5Dcreate2(file, name.c_str(), type, space.get(), links.get(), H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose, name);
  if (n > 0) check_hdf5(H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), name);
}

void store(hid_t file, const std::string& name, const Column& column) {
  if (const auto* reals = std::get_if<std::vector<double>>(&column.values)) {
    store(file, name, H5T_NATIVE_DOUBLE, reals->size(), column.width, reals->data());
  } else if (const auto* numbers = std::get_if<std::vector<std::int64_t>>(&column.values)) {
    store(file, name, H5T_NATIVE_INT64, numbers->size(), column.width, numbers->data());
  } else {
    const auto& texts = std::get<std::vector<std::string>>(column.values);
    const Texts all = packed(texts);
    const Hdf5Id type = text_type(all.length);
    store(file, name, type.get(), texts.size(), 1, all.bytes.data());
  }
}

std::string bytes_of(const Checkpoint& checkpoint) {
  check_hdf5(H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr), "memory");
  constexpr std::size_t increment = std::size_t{1} << 22;
  const Hdf5Id access = memory_access(increment);
  const Hdf5Id file(H5Fcreate("checkpoint", H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose,
                    "memory");
  set_attribute(file.get(), "program", std::string("stylet"));
  set_attribute(file.get(), "version", std::string(STYLET_VERSION));
  set_attribute(file.get(), "format", static_cast<unsigned long long>(checkpoint_format));
  for (const auto& [section, columns] : checkpoint) {
    for (const auto& [name, column] : columns) store(file.get(), section + "/" + name, column);
  }
  check_hdf5(H5Fflush(file.get(), H5F_SCOPE_LOCAL), "memory");
  const ssize_t size = H5Fget_file_image(file.get(), nullptr, 0);
  if (size < 0) throw IoError("a checkpoint cannot be made in memory");
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (H5Fget_file_image(file.get(), bytes.data(), bytes.size()) < 0) {
    throw IoError("a checkpoint cannot be made in memory");
  }
  const std::string sum = fingerprint(bytes);
  bytes.append(seal).append(sum).append("\n");
  return bytes;
}

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw InputError(path + ": " + why);
}

/// HDF5's part of the bytes; empty if they are not whole.
std::string_view checked(std::string_view all, std::string& fault) {
  if (all.size() < seal_size || !all.substr(all.size() - seal_size).starts_with(seal)) {
    fault = "its last bytes are missing";
    return {};
  }
  const auto part = all.substr(0, all.size() - seal_size);
  if (fingerprint(part) == all.substr(all.size() - digits - 1, digits)) return part;
  fault = "its bytes are not those that were written";
  return {};
}

Column load(hid_t dataset, const std::string& name) {
  const Hdf5Id space(H5Dget_space(dataset), H5Sclose, name);
  const Hdf5Id type(H5Dget_type(dataset), H5Tclose, name);
  std::array<hsize_t, 2> extent{0, 1};
  if (H5Sget_simple_extent_ndims(space.get()) > 2) throw IoError(name + ": has too many indices");
  check_hdf5(H5Sget_simple_extent_dims(space.get(), extent.data(), nullptr), name);
  const std::size_t n = extent[0] * extent[1];
  Column column;
  column.width = extent[1];
  const auto read = [&](hid_t as, void* data) {
    if (n > 0) check_hdf5(H5Dread(dataset, as, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), name);
  };
  switch (H5Tget_class(type.get())) {
    case H5T_FLOAT:
      read(H5T_NATIVE_DOUBLE, column.values.emplace<std::vector<double>>(n).data());
      break;
    case H5T_INTEGER:
      read(H5T_NATIVE_INT64, column.values.emplace<std::vector<std::int64_t>>(n).data());
      break;
    default: {
      const std::size_t length = H5Tget_size(type.get());
      std::string bytes(n * length, '\0');
      read(type.get(), bytes.data());
      auto& texts = column.values.emplace<std::vector<std::string>>();
      for (std::size_t i = 0; i < n; ++i) {
        const auto text = bytes.substr(i * length, length);
        texts.push_back(text.substr(0, text.find_last_not_of('\0') + 1));
      }
    }
  }
  return column;
}

Checkpoint checkpoint_of(const std::string& path, std::string_view bytes) {
  check_hdf5(H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr), path);
  const Hdf5Id access = memory_access(1 << 16);
  std::string image(bytes);
  check_hdf5(H5Pset_file_image(access.get(), image.data(), image.size()), path);
  const Hdf5Id file(H5Fopen("checkpoint", H5F_ACC_RDONLY, access.get()), H5Fclose, path);
  const auto format = static_cast<std::int64_t>(number_attribute(file.get(), "format"));
  if (format != checkpoint_format) {
    refuse(path, "is a checkpoint of format " + std::to_string(format) +
                     "; this program reads and writes format " + std::to_string(checkpoint_format) +
                     " only; go on with the program that has written it");
  }
  std::vector<std::string> names;
  const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* all) -> herr_t {
    static_cast<std::vector<std::string>*>(all)->emplace_back(name);
    return 0;
  };
  check_hdf5(H5Lvisit(file.get(), H5_INDEX_NAME, H5_ITER_INC, collect, &names), path);
  Checkpoint checkpoint;
  for (const auto& name : names) {
    const Hdf5Id object(H5Oopen(file.get(), name.c_str(), H5P_DEFAULT), H5Oclose, path);
    const auto slash = name.find('/');
    if (H5Iget_type(object.get()) != H5I_DATASET || slash == std::string::npos) continue;
    checkpoint[name.substr(0, slash)][name.substr(slash + 1)] = load(object.get(), path);
  }
  return checkpoint;
}

}  // namespace

std::size_t write_checkpoint(MPI_Comm comm, const std::string& path, const Checkpoint& checkpoint) {
  unsigned long long size = 0;
  agree_after(comm, [&] {
    if (rank_of(comm) != 0) return;
    const std::string bytes = bytes_of(checkpoint);
    TextFile file(path);
    file.write(bytes);
    file.sync();
    file.close();
    file.appear();
    sync_folder(path);
    size = bytes.size();
  });
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG_LONG, 0, comm);
  return size;
}

std::optional<Checkpoint> read_checkpoint(MPI_Comm comm,
                                          const std::string& path,
                                          std::string& fault) {
  const std::string bytes = read_on_all(comm, path);
  const std::string_view whole = checked(bytes, fault);
  if (whole.empty()) return std::nullopt;
  Checkpoint checkpoint;
  agree_after(comm, [&] { checkpoint = checkpoint_of(path, whole); });
  return checkpoint;
}

}  // namespace stylet
