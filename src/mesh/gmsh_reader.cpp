#include "stylet/mesh/gmsh_reader.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/base/text.hpp"
#include "stylet/mesh/gmsh_file.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace stylet {

namespace {

using gmsh::Element;
using gmsh::element_word;
using gmsh::entity_word;
using gmsh::File;
using gmsh::gmsh_word;

/// The groups in use among the elements of one dimension, in the order of $PhysicalNames; those
/// without a name, called by their numbers, come last. One name may stand for several groups.
struct UsedNames {
  std::vector<std::string> names;
  std::map<int, int> index_of_tag;
};

UsedNames used_names(const File& file, int dim) {
  std::set<int> used;
  int previous = 0;
  for (const Element& e : file.elements[dim]) {
    if (e.groups == previous) continue;  // neighbours mostly share theirs
    previous = e.groups;
    used.insert(file.groups[e.groups].begin(), file.groups[e.groups].end());
  }
  UsedNames result;
  std::map<std::string, int> index_of_name;
  const auto add = [&](int tag, const std::string& name) {
    const auto [known, is_new] =
        index_of_name.try_emplace(name, static_cast<int>(result.names.size()));
    if (is_new) result.names.push_back(name);
    result.index_of_tag.emplace(tag, known->second);
  };
  for (const auto& [name_dim, tag, name] : file.names) {
    if (name_dim != dim && name_dim != gmsh::any_dim) continue;
    if (!name.empty() && used.contains(tag)) add(tag, name);
  }
  for (const int tag : used) {
    if (result.index_of_tag.contains(tag)) continue;
    const std::string number = std::to_string(tag);
    if (index_of_name.contains(number)) {
      throw InputError(file.name + ": physical " + entity_word[dim] + " " + number +
                       " has no name, and another one is named '" + number + "'; name both");
    }
    add(tag, number);
  }
  return result;
}

std::string describe(const Element& e, int dim) {
  std::string text = std::string(element_word[dim]) + " " + std::to_string(e.number);
  if (e.entity != 0)
    text += std::string(" of ") + entity_word[dim] + " " + std::to_string(e.entity);
  return text;
}

[[noreturn]] void refuse_without_group(const File& file, const Element& e, int dim) {
  std::string remedy;
  if (e.entity != 0) {
    remedy = std::string("; add to the .geo: Physical ") + gmsh_word[dim] + "(\"name\") = {" +
             std::to_string(e.entity) + "}, and save without Mesh.SaveAll";
  }
  file.fail(e.place, "unnamed region: " + describe(e, dim) + " has no physical " +
                         entity_word[dim] + remedy);
}

void add_cells(const File& file, MeshData& mesh) {
  UsedNames used = used_names(file, mesh.dim);
  for (const Element& e : file.elements[mesh.dim]) {
    const auto& groups = file.groups[e.groups];
    if (groups.empty()) refuse_without_group(file, e, mesh.dim);
    const int region = used.index_of_tag.at(groups.front());
    for (const int other : groups) {
      const int also = used.index_of_tag.at(other);
      if (also == region) continue;
      file.fail(e.place, describe(e, mesh.dim) + " has two physical groups, '" +
                             used.names[region] + "' and '" + used.names[also] +
                             "'; allowed: one region a cell");
    }
    mesh.cells.insert(mesh.cells.end(), e.nodes.begin(), e.nodes.begin() + mesh.dim + 1);
    mesh.cell_region.push_back(region);
    mesh.origin.cell_number.push_back(e.number);
    mesh.origin.cell_place.push_back(e.place);
  }
  mesh.region_names = std::move(used.names);
}

void add_facets(const File& file, MeshData& mesh) {
  // More would let a small file grow without bound: every facet is stored once a group.
  constexpr std::size_t most_groups = 64;
  UsedNames used = used_names(file, mesh.dim - 1);
  std::vector<int> curves;
  for (const Element& e : file.elements[mesh.dim - 1]) {
    const auto& groups = file.groups[e.groups];
    if (groups.size() > most_groups) {
      file.fail(e.place, describe(e, mesh.dim - 1) + " is in " + std::to_string(groups.size()) +
                             " physical groups; allowed: " + std::to_string(most_groups));
    }
    curves.clear();
    for (const int tag : groups) curves.push_back(used.index_of_tag.at(tag));
    sort_unique(curves);  // groups of one name
    for (const int curve : curves) {
      mesh.facets.insert(mesh.facets.end(), e.nodes.begin(), e.nodes.begin() + mesh.dim);
      mesh.facet_curve.push_back(curve);
      mesh.origin.facet_number.push_back(e.number);
      mesh.origin.facet_place.push_back(e.place);
    }
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
    file.fail(file.point_place[p],
              "z = " + exact(file.points[p][2]) + " in a mesh of triangles that starts at z = " +
                  exact(first[2]) + "; allowed: a plane mesh, z constant, or tetrahedra (gmsh -3)");
  }
}

/// Curves with a node that no cell uses cannot be told in the mesh's own nodes.
void drop_stray_curves(const File& file, const std::vector<int>& number, MeshData& mesh) {
  std::map<int, std::string> faults;
  for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
    if (number[mesh.facets[i]] >= 0) continue;
    const std::size_t f = i / mesh.dim;
    const int curve = mesh.facet_curve[f];
    if (faults.contains(curve)) continue;
    faults[curve] =
        shown(file.name, {file.binary, mesh.origin.facet_place[f]}) + ": " +
        element_word[mesh.dim - 1] + " " + std::to_string(mesh.origin.facet_number[f]) + " of '" +
        mesh.curve_names[curve] + "' has a node that is on no cell; named " +
        (mesh.dim == 2 ? "curves must run along cells" : "surfaces must consist of faces of cells");
  }
  mesh.make_stray(faults);
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
  mesh.origin.node_number.resize(kept.size());
  for (const auto& [tag, p] : file.by_tag) {
    if (number[p] >= 0) mesh.origin.node_number[number[p]] = tag;
  }
  for (int p : kept) {
    for (int k = 0; k < mesh.dim; ++k) mesh.coordinates.push_back(scale * file.points[p][k]);
  }
  for (int& p : mesh.cells) p = number[p];
  drop_stray_curves(file, number, mesh);
  for (int& p : mesh.facets) p = number[p];
}

}  // namespace

MeshData read_gmsh(const std::string& name, const std::string& text, double scale, int most_dim) {
  if (!std::isfinite(scale) || scale <= 0) {
    throw InputError(name + ": scale = " + exact(scale) + "; allowed: above 0");
  }
  const gmsh::File file = gmsh::read(name, text);
  MeshData mesh;
  mesh.source = name;
  mesh.dim = file.elements[3].empty() ? 2 : 3;
  if (mesh.dim > most_dim) {
    const Element& e = file.elements[3].front();
    file.fail(e.place, describe(e, 3) +
                           "; allowed: a plane mesh of triangles, because the scene has "
                           "tissue.plane (one in space has none)");
  }
  if (file.elements[mesh.dim].empty()) {
    fail_at(file.name, file.end, "no triangles or tetrahedra; mesh the surface with gmsh -2");
  }
  mesh.origin.is_binary = file.binary;
  add_cells(file, mesh);
  add_facets(file, mesh);
  keep_used_nodes(file, scale, mesh);
  return mesh;
}

}  // namespace stylet
