// Displacement fields of runs on different meshes, compared with each other.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/simulation/simulation.hpp"

#include <string>
#include <vector>

namespace stylet {

/// Mesh and displacement at one moment.
struct FieldSample {
  double time = 0;                  ///< s
  std::vector<double> coordinates;  ///< dim a node (m), reference
  std::vector<int> cells;           ///< dim + 1 a cell
  std::vector<double> u;            ///< dim a node (m)
  int dim = 2;
  std::vector<int> quadratic_cells{};  ///< 10 nodes a quadratic tetrahedron, or none
};

void archive(Archive& archive, FieldSample& sample);

/// Collective.
[[nodiscard]] FieldSample field_now(const Simulation& simulation);

/// A binary file (CBOR), whole or absent. Not collective.
void write_fields(const std::string& path, const std::vector<FieldSample>& samples);
/// Throws InputError if the file is not one of write_fields.
[[nodiscard]] std::vector<FieldSample> read_fields(const std::string& path);

/// || u - u_fine || / || u_fine || in L2 over the fine mesh, by a rule that is exact for quadratics
/// on every fine cell: exact where cells are linear and the meshes are nested, and where the needle has moved nodes
/// the coarse field is evaluated where the fine one's points lie.
[[nodiscard]] double relative_distance(const FieldSample& coarse, const FieldSample& fine);

}  // namespace stylet
