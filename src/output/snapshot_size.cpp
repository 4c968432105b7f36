#include "stylet/output/snapshot_size.hpp"

#include "stylet/base/errors.hpp"

namespace stylet {

namespace {

int n_nodes(const Snapshot& snapshot) {
  return static_cast<int>(snapshot.coordinates.size()) / snapshot.dim;
}
int n_cells(const Snapshot& snapshot) {
  return static_cast<int>(snapshot.connectivity.size()) / (snapshot.dim + 1);
}

void check_size(const std::string& name, std::size_t size, Range rows, int components) {
  const auto n_rows = static_cast<std::size_t>(rows.size());
  if (components < 1 || components > 3 || size != n_rows * static_cast<std::size_t>(components)) {
    throw Error(ExitCode::other, "snapshot: field " + name + " has " + std::to_string(size) +
                                     " numbers for " + std::to_string(n_rows) + " rows of " +
                                     std::to_string(components));
  }
}

}  // namespace

void check_sizes(const Snapshot& snapshot, int rank, int n_ranks) {
  const Range nodes = chunk(n_nodes(snapshot), rank, n_ranks);
  const Range cells = chunk(n_cells(snapshot), rank, n_ranks);
  for (const Field& field : snapshot.fields) {
    check_size(field.name, field.values.size(), field.on_cells ? cells : nodes, field.components);
  }
  for (const FlagField& flag : snapshot.flags) {
    check_size(flag.name, flag.values.size(), flag.on_cells ? cells : nodes, 1);
  }
}

std::uint64_t stored_bytes(const Snapshot& snapshot, bool with_mesh) {
  const auto rows = [&](bool on_cells) {
    return static_cast<std::uint64_t>(on_cells ? n_cells(snapshot) : n_nodes(snapshot));
  };
  std::uint64_t n_doubles = with_mesh ? snapshot.coordinates.size() : 0;
  std::uint64_t n_ints = with_mesh ? snapshot.connectivity.size() : 0;
  for (const Field& field : snapshot.fields) {
    n_doubles += rows(field.on_cells) * (field.components == 1 ? 1 : 3);
  }
  for (const FlagField& flag : snapshot.flags) n_ints += rows(flag.on_cells);
  for (const Polyline& line : snapshot.polylines) n_doubles += 3 * line.points.size();
  for (const PointSet& set : snapshot.point_sets) n_doubles += 3 * set.points.size();
  return n_doubles * sizeof(double) + n_ints * sizeof(int);
}

std::uint64_t metadata_bytes(const Snapshot& snapshot, int n_before) {
  constexpr std::uint64_t per_object = 4096;
  constexpr std::uint64_t per_step_before = 256;
  constexpr std::uint64_t n_other_objects = 8;  // groups, mesh
  const std::uint64_t n_objects = snapshot.fields.size() + snapshot.flags.size() +
                                  snapshot.polylines.size() + snapshot.point_sets.size() +
                                  n_other_objects;
  return n_objects * per_object + static_cast<std::uint64_t>(n_before) * per_step_before;
}

}  // namespace stylet
