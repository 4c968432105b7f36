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
  std::ranges::replace(text, '\n', ' ');
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

Hdf5Id write(hid_t parent,
             const std::string& name,
             const std::string& unit,
             int columns,
             std::size_t n_values,
             hid_t type,
             const void* data) {
  const std::array<hsize_t, 2> extent = {n_values / static_cast<hsize_t>(columns),
                                         static_cast<hsize_t>(columns)};
  const Hdf5Id space(H5Screate_simple(columns > 1 ? 2 : 1, extent.data(), nullptr), H5Sclose, name);
  // With the default properties nothing is filled in before, and HDF5 copies none.
  Hdf5Id dataset(
      H5Dcreate2(parent, name.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose, name);
  set_attribute(dataset.get(), "unit", unit);
  check_hdf5(H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), name);
  return dataset;
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

Hdf5Id small_group_properties() {
  Hdf5Id plist(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, "group");
  constexpr unsigned most = 32;  // links
  constexpr unsigned length = 12;
  check_hdf5(H5Pset_link_creation_order(plist.get(), H5P_CRT_ORDER_TRACKED), "group");
  check_hdf5(H5Pset_link_phase_change(plist.get(), most, most / 2), "group");
  check_hdf5(H5Pset_est_link_info(plist.get(), most / 2, length), "group");
  return plist;
}

Hdf5Id create_group(hid_t parent, const std::string& name) {
  return {
      H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, small_group_properties().get(), H5P_DEFAULT),
      H5Gclose, name};
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

double number_attribute(hid_t object, const std::string& name) {
  const Hdf5Id attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, name);
  double value = 0;
  check_hdf5(H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &value), name);
  return value;
}

Hdf5Id write_array(hid_t parent,
                   const std::string& name,
                   const std::string& unit,
                   int columns,
                   std::span<const double> values) {
  return write(parent, name, unit, columns, values.size(), H5T_NATIVE_DOUBLE, values.data());
}

Hdf5Id write_array(hid_t parent,
                   const std::string& name,
                   const std::string& unit,
                   int columns,
                   std::span<const int> values) {
  return write(parent, name, unit, columns, values.size(), H5T_NATIVE_INT, values.data());
}

std::vector<double> read_array(hid_t array) {
  const Hdf5Id space(H5Dget_space(array), H5Sclose, "array");
  const hssize_t n = H5Sget_simple_extent_npoints(space.get());
  std::vector<double> values(static_cast<std::size_t>(std::max<hssize_t>(n, 0)));
  check_hdf5(H5Dread(array, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
             "array");
  return values;
}

void link_array(hid_t array, hid_t parent, const std::string& name) {
  check_hdf5(H5Olink(array, parent, name.c_str(), H5P_DEFAULT, H5P_DEFAULT), name);
}

}  // namespace stylet
