// Owning HDF5 handles and arrays that all ranks write together.
#pragma once

#include "stylet/output/chunk.hpp"

#include <hdf5.h>
#include <mpi.h>

#include <optional>
#include <string>
#include <utility>

namespace stylet {

/// Closes what it holds. Closing a file is collective.
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

/// Collective. A new file with the MPI driver; replaces an old one.
[[nodiscard]] Hdf5Id create_hdf5_file(MPI_Comm comm, const std::string& path);
[[nodiscard]] Hdf5Id create_group(hid_t parent, const std::string& name);

void set_attribute(hid_t object, const std::string& name, const std::string& text);
void set_attribute(hid_t object, const std::string& name, double value);
void set_attribute(hid_t object, const std::string& name, unsigned long long value);

/// An array of a file and this rank's rows of it. Created on all ranks first and written after all
/// have agreed that this went well, because a write that only some ranks enter would hang.
struct PendingArray {
  Hdf5Id dataset;
  hid_t memory_type;
  hsize_t first_row;
  hsize_t n_rows;  ///< of this rank, may be 0
  hsize_t n_columns;
  const void* data;  ///< borrowed until written
};

struct ArrayShape {
  hsize_t n_rows;
  hsize_t n_columns;  ///< 1: the array has one index only
};

/// Collective. Raw contiguous rows, without fill values, with the attribute `unit`.
[[nodiscard]] PendingArray create_array(hid_t parent,
                                        const std::string& name,
                                        const std::string& unit,
                                        ArrayShape shape,
                                        Range rows,
                                        const double* data);
[[nodiscard]] PendingArray create_array(hid_t parent,
                                        const std::string& name,
                                        const std::string& unit,
                                        ArrayShape shape,
                                        Range rows,
                                        const int* data);

/// Collective. Returns what went wrong on this rank instead of throwing, so that all ranks enter
/// the next write.
[[nodiscard]] std::optional<std::string> write_array(const PendingArray& array);

}  // namespace stylet
