// Owning HDF5 handles, and arrays in groups. HDF5's own driver: one process writes a file.
#pragma once

#include <hdf5.h>

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace stylet {

/// Closes what it holds.
class Hdf5Id {
 public:
  using Closer = herr_t (*)(hid_t);
  /// Throws an IoError with HDF5's own message if `id` is no handle.
  Hdf5Id(hid_t id, Closer closer, const std::string& what);
  Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, -1)), closer_(other.closer_) {}
  Hdf5Id& operator=(Hdf5Id&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(closer_, other.closer_);
    return *this;
  }
  Hdf5Id(const Hdf5Id&) = delete;
  Hdf5Id& operator=(const Hdf5Id&) = delete;
  ~Hdf5Id();

  [[nodiscard]] hid_t get() const { return id_; }
  hid_t release() { return std::exchange(id_, -1); }

 private:
  hid_t id_;
  Closer closer_;
};

/// Throws an IoError with HDF5's own message if `status` is negative.
void check_hdf5(herr_t status, const std::string& what);

/// How groups of a few arrays are made: their links lie in one piece.
[[nodiscard]] Hdf5Id small_group_properties();
[[nodiscard]] Hdf5Id create_group(hid_t parent, const std::string& name);

void set_attribute(hid_t object, const std::string& name, const std::string& text);
void set_attribute(hid_t object, const std::string& name, double value);
void set_attribute(hid_t object, const std::string& name, unsigned long long value);
/// Of a number of any type.
[[nodiscard]] double number_attribute(hid_t object, const std::string& name);

/// A new array of rows, with the attribute `unit`. columns: 1 if it has one index only.
Hdf5Id write_array(hid_t parent,
                   const std::string& name,
                   const std::string& unit,
                   int columns,
                   std::span<const double> values);
Hdf5Id write_array(hid_t parent,
                   const std::string& name,
                   const std::string& unit,
                   int columns,
                   std::span<const int> values);
/// All numbers of an array.
[[nodiscard]] std::vector<double> read_array(hid_t array);
/// Another name for an array.
void link_array(hid_t array, hid_t parent, const std::string& name);

}  // namespace stylet
