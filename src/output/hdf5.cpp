#include "stylet/output/hdf5.hpp"

#include "stylet/base/errors.hpp"

#include <algorithm>
#include <array>

namespace stylet {

namespace {

/// The reasons that HDF5 gives, from the place of the failure outwards.
std::string hdf5_message() {
  std::string text;
  const auto append = [](unsigned, const H5E_error2_t* error, void* out) -> herr_t {
    auto& all = *static_cast<std::string*>(out);
    const std::string reason = error->desc != nullptr ? error->desc : "";
    constexpr std::size_t enough = 300;
    if (!reason.empty() && all.size() < enough && all.find(reason) == std::string::npos) {
      all += (all.empty() ? "" : "; ") + reason;
    }
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, append, &text);
  return text.empty() ? "unknown reason" : text;
}

template <class Value>
void set_number(hid_t object, const std::string& name, hid_t type, Value value) {
  const Hdf5Id space(H5Screate(H5S_SCALAR), H5Sclose, name);
  const Hdf5Id attribute(
      H5Acreate2(object, name.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
      name);
  check_hdf5(H5Awrite(attribute.get(), type, &value), name);
}

Hdf5Id simple_space(hsize_t n_rows, hsize_t n_columns) {
  const std::array<hsize_t, 2> extent = {n_rows, n_columns};
  return {H5Screate_simple(n_columns > 1 ? 2 : 1, extent.data(), nullptr), H5Sclose, "array"};
}

PendingArray create(hid_t parent,
                    const std::string& name,
                    const std::string& unit,
                    ArrayShape shape,
                    Range rows,
                    hid_t type,
                    const void* data) {
  const Hdf5Id space = simple_space(shape.n_rows, shape.n_columns);
  const Hdf5Id plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, name);
  check_hdf5(H5Pset_fill_time(plist.get(), H5D_FILL_TIME_NEVER), name);
  Hdf5Id dataset(
      H5Dcreate2(parent, name.c_str(), type, space.get(), H5P_DEFAULT, plist.get(), H5P_DEFAULT),
      H5Dclose, name);
  set_attribute(dataset.get(), "unit", unit);
  return {
      std::move(dataset), type, static_cast<hsize_t>(rows.begin), static_cast<hsize_t>(rows.size()),
      shape.n_columns,    data};
}

}  // namespace

Hdf5Id::Hdf5Id(hid_t id, Closer closer, const std::string& what) : id_(id), closer_(closer) {
  if (id < 0) throw IoError(what + ": " + hdf5_message());
}

Hdf5Id::~Hdf5Id() {
  if (id_ >= 0) closer_(id_);
}

void check_hdf5(herr_t status, const std::string& what) {
  if (status < 0) throw IoError(what + ": " + hdf5_message());
}

Hdf5Id create_hdf5_file(MPI_Comm comm, const std::string& path) {
  check_hdf5(H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr), path);  // errors are ours to report
  const Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, path);
  check_hdf5(H5Pset_fapl_mpio(access.get(), comm, MPI_INFO_NULL), path);
  check_hdf5(H5Pset_coll_metadata_write(access.get(), true), path);
  return {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose,
          path + ": cannot be created"};
}

Hdf5Id create_group(hid_t parent, const std::string& name) {
  return {H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, name};
}

void set_attribute(hid_t object, const std::string& name, const std::string& text) {
  const Hdf5Id space(H5Screate(H5S_SCALAR), H5Sclose, name);
  const Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose, name);
  check_hdf5(H5Tset_size(type.get(), text.size() + 1), name);
  check_hdf5(H5Tset_cset(type.get(), H5T_CSET_UTF8), name);
  const Hdf5Id attribute(
      H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
      name);
  check_hdf5(H5Awrite(attribute.get(), type.get(), text.c_str()), name);
}

void set_attribute(hid_t object, const std::string& name, double value) {
  set_number(object, name, H5T_NATIVE_DOUBLE, value);
}

void set_attribute(hid_t object, const std::string& name, unsigned long long value) {
  set_number(object, name, H5T_NATIVE_ULLONG, value);
}

PendingArray create_array(hid_t parent,
                          const std::string& name,
                          const std::string& unit,
                          ArrayShape shape,
                          Range rows,
                          const double* data) {
  return create(parent, name, unit, shape, rows, H5T_NATIVE_DOUBLE, data);
}

PendingArray create_array(hid_t parent,
                          const std::string& name,
                          const std::string& unit,
                          ArrayShape shape,
                          Range rows,
                          const int* data) {
  return create(parent, name, unit, shape, rows, H5T_NATIVE_INT, data);
}

std::optional<std::string> write_array(const PendingArray& array) {
  try {
    const Hdf5Id transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose, "transfer");
    check_hdf5(H5Pset_dxpl_mpio(transfer.get(), H5FD_MPIO_COLLECTIVE), "transfer");
    // Each rank writes its own contiguous rows: sending them to another rank first costs time.
    check_hdf5(H5Pset_dxpl_mpio_collective_opt(transfer.get(), H5FD_MPIO_INDIVIDUAL_IO),
               "transfer");
    const Hdf5Id memory = simple_space(std::max<hsize_t>(array.n_rows, 1), array.n_columns);
    const Hdf5Id file(H5Dget_space(array.dataset.get()), H5Sclose, "array");
    if (array.n_rows > 0) {
      const std::array<hsize_t, 2> start = {array.first_row, 0};
      const std::array<hsize_t, 2> count = {array.n_rows, array.n_columns};
      check_hdf5(H5Sselect_hyperslab(file.get(), H5S_SELECT_SET, start.data(), nullptr,
                                     count.data(), nullptr),
                 "array");
    } else {
      check_hdf5(H5Sselect_none(file.get()), "array");
      check_hdf5(H5Sselect_none(memory.get()), "array");
    }
    check_hdf5(H5Dwrite(array.dataset.get(), array.memory_type, memory.get(), file.get(),
                        transfer.get(), array.data),
               "cannot be written");
    return std::nullopt;
  } catch (const Error& error) {
    return error.what();
  }
}

}  // namespace stylet
