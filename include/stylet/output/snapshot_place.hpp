// How far snapshots.h5 and its XDMF files are, to go on from there whatever was written to them since.
#pragma once

#include "stylet/base/archive.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace stylet {

class CommittedFile;

struct SnapshotPlace {
  int n_written = 0;
  int n_meshes = 0;
  double time = 0;  ///< of the last snapshot (s)
  std::uint64_t mesh_version = 0;
  std::uint64_t connectivity_version = 0;
  std::string tissue_xdmf = {};  ///< XdmfSeries::text
  std::string shape_xdmf = {};
  std::string displacement = {};  ///< fingerprint of that of the last snapshot
};

void archive(Archive& archive, SnapshotPlace& place);

/// step_000012
[[nodiscard]] std::string numbered(const std::string& name, int number);

/// Throws InputError where the file that is to be gone on with is not there.
void require_there(const std::string& path);

/// Of the displacement of a snapshot, which no other run shares.
[[nodiscard]] std::string displacement_of(const CommittedFile& file, int snapshot);

/// Groups that are not of that place but later. Throws InputError where the file, which `path` names, does
/// not have those that are.
[[nodiscard]] std::vector<std::string> later_than(const SnapshotPlace& place,
                                                  const CommittedFile& file,
                                                  const std::string& path);

}  // namespace stylet
