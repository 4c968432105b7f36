// What a snapshot takes in the file, and whether its fields have the sizes they should have.
#pragma once

#include "stylet/output/snapshots.hpp"

#include <cstdint>

namespace stylet {

/// Throws if a field does not have this rank's rows: a mistake of the program.
void check_sizes(const Snapshot& snapshot, int rank, int n_ranks);

/// Bytes of all arrays, of all ranks together.
[[nodiscard]] std::uint64_t stored_bytes(const Snapshot& snapshot, bool with_mesh);

/// An upper bound of what HDF5 takes for its headers and for the list of the steps before, which it
/// copies when that grows.
[[nodiscard]] std::uint64_t metadata_bytes(const Snapshot& snapshot, int n_before);

}  // namespace stylet
