#include "meshes.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace stylet::robustness {

namespace {

enum class Inner { none, ellipse, polygon, two };

NamedMesh grid(int columns,
               int rows,
               Diagonals diagonals,
               double jitter,
               int seed,
               Inner inner = Inner::none,
               double contrast = 1) {
  RectangleMesh r;
  r.width = tissue_width;
  r.height = tissue_height;
  r.columns = columns;
  r.rows = rows;
  r.diagonals = diagonals;
  r.jitter = jitter;
  r.seed = seed;
  NamedMesh mesh;
  mesh.name = std::to_string(columns) + "x" + std::to_string(rows) +
              (diagonals == Diagonals::one_way ? " one-way" : " alternating");
  if (jitter > 0) mesh.name += " jitter " + std::to_string(jitter).substr(0, 4);
  mesh.regions = {"tissue"};
  const Ellipse prostate{{0.035, 0.03}, 0.035, 0.026};
  const std::vector<ReferencePoint> bone{
      {0.012, 0.012}, {0.03, 0.008}, {0.048, 0.02}, {0.04, 0.042}, {0.02, 0.05}};
  if (inner == Inner::ellipse || inner == Inner::two)
    r.inner_regions.push_back({"inner", prostate});
  if (inner == Inner::polygon) r.inner_regions.push_back({"inner", bone});
  if (inner == Inner::two)
    r.inner_regions.push_back({"core", Ellipse{{0.03, 0.031}, 0.012, 0.012}});
  for (const auto& region : r.inner_regions) mesh.regions.push_back(region.name);
  if (inner == Inner::ellipse) mesh.name += " ellipse";
  if (inner == Inner::polygon) mesh.name += " polygon";
  if (inner == Inner::two) mesh.name += " nested";
  if (contrast != 1) mesh.name += " E x" + std::to_string(static_cast<int>(contrast));
  mesh.contrast = contrast;
  mesh.size = std::max(tissue_width / columns, tissue_height / rows);
  mesh.mesh.source = r;
  return mesh;
}

// The script leaves `<name>.msh` and `<name>.regions`: typical edge, then names of regions.
void add_gmsh(const std::string& folder, std::vector<NamedMesh>& meshes) {
  if (folder.empty() || !std::filesystem::is_directory(folder)) return;
  std::vector<std::filesystem::path> lists;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".regions") lists.push_back(entry.path());
  }
  std::ranges::sort(lists);
  for (const auto& list : lists) {
    std::ifstream file(list);
    NamedMesh mesh;
    mesh.name = "gmsh " + list.stem().string();
    mesh.mesh.source = std::filesystem::path(list).replace_extension(".msh").string();
    file >> mesh.size >> mesh.contrast;
    for (std::string region; file >> region;) mesh.regions.push_back(region);
    meshes.push_back(mesh);
  }
}

}  // namespace

std::vector<NamedMesh> all_meshes(const std::string& gmsh_folder) {
  constexpr auto one_way = Diagonals::one_way;
  constexpr auto alternating = Diagonals::alternating;
  std::vector<NamedMesh> meshes{
      grid(15, 10, alternating, 0, 1),
      grid(16, 12, one_way, 0, 1),
      grid(20, 15, alternating, 0.25, 1),
      grid(20, 15, one_way, 0.25, 2),
      grid(24, 18, alternating, 0, 1, Inner::ellipse, 10),
      grid(24, 18, one_way, 0.15, 3, Inner::ellipse),
      grid(32, 24, alternating, 0.25, 4),
      grid(32, 24, one_way, 0.25, 5, Inner::polygon, 20),
      grid(40, 30, one_way, 0, 1),
      grid(40, 30, alternating, 0.2, 6, Inner::ellipse, 10),
      grid(48, 20, alternating, 0.1, 7),
      grid(24, 40, one_way, 0.1, 8),
      grid(50, 38, alternating, 0.25, 9),
      grid(50, 38, one_way, 0.2, 10, Inner::polygon, 5),
      grid(60, 45, one_way, 0.25, 11, Inner::two, 3),
      grid(64, 48, alternating, 0.25, 12),
      grid(80, 60, one_way, 0.25, 13, Inner::ellipse, 10),
      grid(100, 75, alternating, 0.25, 14),
      grid(115, 87, one_way, 0.1, 15),
  };
  add_gmsh(gmsh_folder, meshes);
  return meshes;
}

}  // namespace stylet::robustness
