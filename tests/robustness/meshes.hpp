// The meshes of the robustness runs: 8 x 6 cm tissue, 300 to 20,000 triangles.
#pragma once

#include "stylet/mesh/parameters.hpp"

#include <string>
#include <vector>

namespace stylet::robustness {

struct NamedMesh {
  std::string name;
  MeshParameters mesh;
  std::vector<std::string> regions;
  double contrast = 1;  ///< Young's modulus of the inner regions over that of the outer one
  double size = 0;      ///< typical edge (m)
};

/// gmsh_folder: files that make_gmsh_meshes.py left there are added, and none if it is empty.
[[nodiscard]] std::vector<NamedMesh> all_meshes(const std::string& gmsh_folder);

constexpr double tissue_width = 0.08;
constexpr double tissue_height = 0.06;

}  // namespace stylet::robustness
