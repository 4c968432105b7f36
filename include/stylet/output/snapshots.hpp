// Fields on the whole mesh at chosen times: snapshots.h5, and two XDMF files for ParaView.
//
//   /                  program, version, format
//   /mesh_000000       coordinates (n, 2) in m, connectivity (m, 3), in space (n, 3) and (m, 4);
//                      attribute mesh_version
//   /step_000012       attributes time, phase, index and mesh (name of the mesh group);
//                      one array a field, vectors with three components (z = 0)
//   /step_000012/polylines/needle, /step_000012/point_sets/seeds     (n, 2) in m, in
//                      space (n, 3), world frame
//
// Every array has the attribute `unit`. A mesh is stored again only when its version changed, and
// with a link to the same connectivity as long as nodes only moved; flags and points that are those of
// the last snapshot are links to them.
// snapshots.xdmf shows the tissue (apply "Warp By Vector" with u), snapshots_needle.xdmf the
// polylines and point sets, which must not be warped.
#pragma once

#include "stylet/output/chunk.hpp"
#include "stylet/output/snapshot_place.hpp"

#include <mpi.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace stylet {

/// Values of this rank's chunk only, `components` numbers a row. Two components are stored as three.
struct Field {
  std::string name;
  bool on_cells = false;
  int components = 1;  ///< 1, 2 or 3
  std::vector<double> values;
  std::string unit = {};
};

/// Values of this rank's chunk only.
struct FlagField {
  std::string name;
  bool on_cells = false;
  std::vector<int> values;
};

/// m; z is of space only.
using SnapshotPoints = std::vector<std::array<double, 3>>;

/// The same on all ranks. Without points it is left out.
struct Polyline {
  std::string name;
  SnapshotPoints points;
  bool closed = false;
};

/// The same on all ranks. Without points it is left out.
struct PointSet {
  std::string name;
  SnapshotPoints points;
};

struct Snapshot {
  double time = 0;
  std::string phase = {};
  std::span<const double> coordinates;  ///< reference frame, `dim` a node, all nodes
  std::span<const int> connectivity;    ///< dim + 1 a cell, all cells
  std::uint64_t mesh_version = 0;
  std::uint64_t connectivity_version = 0;
  std::vector<Field> fields = {};
  std::vector<FlagField> flags = {};
  std::vector<Polyline> polylines = {};
  std::vector<PointSet> point_sets = {};
  int dim = 2;  ///< 3: tetrahedra
};

/// Everything is collective; rank 0 writes. Whenever a run is killed, its files can be read, and hold all
/// snapshots that were written until then (committed_file.hpp). If there is no room for a snapshot, all
/// ranks throw exit code `io`, the file is closed with the snapshots before, and a further write throws
/// again. A write that fails in spite of the reserved room ends the job with the same code.
class SnapshotWriter {
 public:
  /// Creates the files in an existing folder.
  SnapshotWriter(MPI_Comm comm, const std::string& folder);
  /// Goes on with those in it: later snapshots go, and the XDMF files are written anew. Throws InputError where they have become others, and has changed nothing
  /// then.
  SnapshotWriter(MPI_Comm comm, const std::string& folder, const SnapshotPlace& from);
  SnapshotWriter(const SnapshotWriter&) = delete;
  SnapshotWriter& operator=(const SnapshotWriter&) = delete;
  ~SnapshotWriter();

  void write(const Snapshot& snapshot);
  /// Waits for the disk. Of rank 0.
  [[nodiscard]] SnapshotPlace settle();
  void close();
  [[nodiscard]] int n_written() const;

 private:
  class File;
  std::unique_ptr<File> file_;
};

}  // namespace stylet
