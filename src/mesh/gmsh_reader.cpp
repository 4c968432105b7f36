#include "stylet/mesh/gmsh_reader.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/mesh/gmsh_file.hpp"
#include "stylet/mesh/gmsh_tokens.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace stylet {

namespace {

using gmsh::Element;
using gmsh::element_word;
using gmsh::entity_word;
using gmsh::File;
using gmsh::gmsh_word;

/// The names in use among the elements of one dimension, in the order of $PhysicalNames.
struct UsedNames {
  std::vector<std::string> names;
  std::map<int, int> index_of_tag;
};

UsedNames used_names(const File& file, int dim) {
  std::map<int, const Element*> used;
  for (const Element& e : file.elements[dim]) {
    if (e.group != 0) used.try_emplace(e.group, &e);
  }
  UsedNames result;
  for (const auto& [name_dim, tag, name] : file.names) {
    if (name_dim != dim || !used.contains(tag)) continue;
    const auto known = std::ranges::find(result.names, name);
    result.index_of_tag[tag] = static_cast<int>(known - result.names.begin());
    if (known == result.names.end()) result.names.push_back(name);
  }
  for (const auto& [tag, element] : used) {
    if (result.index_of_tag.contains(tag)) continue;
    fail_at(file.name, element->line,
            std::string("physical ") + entity_word[dim] + " " + std::to_string(tag) +
                " has no name; name it in the .geo: Physical " + gmsh_word[dim] + "(\"name\")");
  }
  return result;
}

std::string describe(const Element& e, int dim) {
  return std::string(element_word[dim]) + " " + std::to_string(e.number) + " of " +
         entity_word[dim] + " " + std::to_string(e.entity);
}

void add_cells(const File& file, MeshData& mesh) {
  UsedNames used = used_names(file, mesh.dim);
  const Element* previous = nullptr;
  for (const Element& e : file.elements[mesh.dim]) {
    if (e.group == 0) {
      fail_at(file.name, e.line,
              "unnamed region: " + describe(e, mesh.dim) + " has no physical " +
                  entity_word[mesh.dim] + "; add to the .geo: Physical " + gmsh_word[mesh.dim] +
                  "(\"name\") = {" + std::to_string(e.entity) + "}, and save without Mesh.SaveAll");
    }
    if (previous != nullptr && previous->number == e.number && previous->line == e.line) {
      fail_at(file.name, e.line,
              describe(e, mesh.dim) + " has two physical groups; allowed: one region a cell");
    }
    mesh.cells.insert(mesh.cells.end(), e.nodes.begin(), e.nodes.begin() + mesh.dim + 1);
    mesh.cell_region.push_back(used.index_of_tag.at(e.group));
    previous = &e;
  }
  mesh.region_names = std::move(used.names);
}

void add_facets(const File& file, MeshData& mesh) {
  UsedNames used = used_names(file, mesh.dim - 1);
  for (const Element& e : file.elements[mesh.dim - 1]) {
    if (e.group == 0) continue;
    mesh.facets.insert(mesh.facets.end(), e.nodes.begin(), e.nodes.begin() + mesh.dim);
    mesh.facet_curve.push_back(used.index_of_tag.at(e.group));
  }
  mesh.curve_names = std::move(used.names);
}

void require_plane(const File& file, const std::vector<int>& kept) {
  constexpr double tolerance = 1e-9;  // of the extent: rounding of a CAD kernel is far below
  const auto& first = file.points[kept.front()];
  double extent = 0;
  for (int p : kept) {
    for (int k = 0; k < 2; ++k) extent = std::max(extent, std::abs(file.points[p][k] - first[k]));
  }
  for (int p : kept) {
    if (std::abs(file.points[p][2] - first[2]) <= tolerance * extent) continue;
    fail_at(file.name, file.point_line[p],
            "z = " + std::to_string(file.points[p][2]) + " in a mesh of triangles that starts at " +
                "z = " + std::to_string(first[2]) + "; allowed: a plane mesh, z constant");
  }
}

/// Replaces file positions by node numbers that count used nodes only.
void keep_used_nodes(const File& file, double scale, MeshData& mesh) {
  std::vector<int> number(file.points.size(), -1);
  for (int p : mesh.cells) number[p] = 0;
  std::vector<int> kept;
  for (std::size_t p = 0; p < number.size(); ++p) {
    if (number[p] < 0) continue;
    number[p] = static_cast<int>(kept.size());
    kept.push_back(static_cast<int>(p));
  }
  if (mesh.dim == 2) require_plane(file, kept);
  for (int p : kept) {
    for (int k = 0; k < mesh.dim; ++k) mesh.coordinates.push_back(scale * file.points[p][k]);
  }
  for (int& p : mesh.cells) p = number[p];
  for (int& p : mesh.facets) {
    if (number[p] < 0) {
      fail_at(file.name, file.point_line[p],
              "this node is on a named curve but on no cell; named curves must run along cells");
    }
    p = number[p];
  }
}

}  // namespace

MeshData read_gmsh(const std::string& name, const std::string& text, double scale) {
  if (!std::isfinite(scale) || scale <= 0) {
    throw InputError(name + ": scale = " + std::to_string(scale) + "; allowed: above 0");
  }
  const gmsh::File file = gmsh::read(name, text);
  MeshData mesh;
  mesh.source = name;
  mesh.dim = file.elements[3].empty() ? 2 : 3;
  if (file.elements[mesh.dim].empty()) {
    fail_at(file.name, file.last_line, "no triangles or tetrahedra; mesh the surface with gmsh -2");
  }
  add_cells(file, mesh);
  add_facets(file, mesh);
  keep_used_nodes(file, scale, mesh);
  return mesh;
}

}  // namespace stylet
