#include "stylet/mesh/gmsh_file.hpp"

#include "stylet/mesh/gmsh_tokens.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace stylet::gmsh {

namespace {

void read_format(Tokens& in, std::string& version) {
  version = in.word("the format version");
  if (version != "2.2" && version != "4.1") {
    in.fail("Gmsh format " + version + "; allowed: 2.2 and 4.1 (gmsh -format msh41, or msh22)");
  }
  if (in.number<int>("0 for ASCII") != 0) {
    in.fail("binary Gmsh file; only ASCII is read: save it with gmsh -bin 0");
  }
  in.count("the size of a number");
  in.expect("$EndMeshFormat");
}

void read_names(Tokens& in, File& file) {
  const auto n = in.count("the number of physical names");
  for (std::int64_t i = 0; i < n; ++i) {
    const int dim = in.number<int>("a dimension");
    const int tag = in.number<int>("a physical tag");
    file.names.push_back({dim, tag, in.quoted()});
  }
  in.expect("$EndPhysicalNames");
}

void read_entities(Tokens& in, File& file) {
  std::array<std::int64_t, 4> n{};
  for (auto& count : n) count = in.count("a number of entities");
  for (int dim = 0; dim < 4; ++dim) {
    for (std::int64_t i = 0; i < n[dim]; ++i) {
      const int tag = in.number<int>("an entity tag");
      for (int k = 0; k < (dim == 0 ? 3 : 6); ++k) in.number<double>("a bound of an entity");
      auto& groups = file.groups_of_entity[{dim, tag}];
      const auto n_groups = in.count("a number of physical tags");
      for (std::int64_t k = 0; k < n_groups; ++k) {
        groups.push_back(std::abs(in.number<int>("a physical tag")));  // the sign is a direction
      }
      const auto n_bounding = dim == 0 ? 0 : in.count("a number of bounding entities");
      for (std::int64_t k = 0; k < n_bounding; ++k) in.number<int>("a bounding entity");
    }
  }
  in.expect("$EndEntities");
}

void add_point(Tokens& in, File& file, std::int64_t tag) {
  file.by_tag.emplace_back(tag, static_cast<int>(file.points.size()));
  const double x = in.number<double>("a coordinate");
  const double y = in.number<double>("a coordinate");
  const double z = in.number<double>("a coordinate");
  file.points.push_back({x, y, z});
  file.point_line.push_back(in.line());
}

void read_nodes(Tokens& in, File& file, bool version_4) {
  const auto n_blocks = version_4 ? in.count("a number of node blocks") : 1;
  const auto n_nodes = in.count("the number of nodes");
  if (n_nodes > std::numeric_limits<int>::max() / 4) in.fail("too many nodes");
  if (version_4) {
    in.count("the smallest node tag");
    in.count("the largest node tag");
  }
  std::vector<std::int64_t> tags;
  for (std::int64_t block = 0; block < n_blocks; ++block) {
    const int dim = version_4 ? in.number<int>("an entity dimension") : 0;
    if (version_4) in.number<int>("an entity tag");
    const bool parametric = version_4 && in.number<int>("0 or 1 (parametric)") != 0;
    const auto n = version_4 ? in.count("the number of nodes of a block") : n_nodes;
    tags.clear();
    for (std::int64_t i = 0; version_4 && i < n; ++i) tags.push_back(in.count("a node tag"));
    for (std::int64_t i = 0; i < n; ++i) {
      add_point(in, file, version_4 ? tags[i] : in.count("a node tag"));
      for (int k = 0; parametric && k < dim; ++k) in.number<double>("a node parameter");
    }
  }
  in.expect("$EndNodes");
  std::ranges::sort(file.by_tag);
  const auto twice = std::ranges::adjacent_find(
      file.by_tag, [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice != file.by_tag.end()) {
    fail_at(file.name, file.point_line[std::next(twice)->second],
            "node " + std::to_string(twice->first) + " is given twice");
  }
}

/// Position of a node tag, or -1. Tags mostly run without gaps: try that place first.
int find_node(const File& file, std::int64_t tag) {
  if (file.by_tag.empty()) return -1;
  const std::int64_t guess = tag - file.by_tag.front().first;
  if (guess >= 0 && guess < static_cast<std::int64_t>(file.by_tag.size()) &&
      file.by_tag[guess].first == tag) {
    return file.by_tag[guess].second;
  }
  const auto found = std::ranges::lower_bound(file.by_tag, std::pair{tag, 0});
  return found != file.by_tag.end() && found->first == tag ? found->second : -1;
}

int dimension_of_type(const Tokens& in, int type) {
  switch (type) {
    case 15:
      return 0;
    case 1:
      return 1;
    case 2:
      return 2;
    case 4:
      return 3;
    default:
      break;
  }
  constexpr const char* allowed =
      "; allowed: 1 (line), 2 (triangle), 4 (tetrahedron), 15 (point). ";
  const std::string head = "element type " + std::to_string(type);
  if (type == 3 || (type >= 5 && type <= 7)) {
    in.fail(head + " is no simplex" + allowed + "Mesh without Recombine");
  }
  if (type >= 8 && type <= 31) {
    in.fail(head + " is of second or higher order" + allowed + "Use gmsh -order 1");
  }
  in.fail(head + " is unknown" + allowed);
}

std::array<int, 4> read_corners(Tokens& in, const File& file, int dim, std::int64_t number) {
  std::array<int, 4> nodes{};
  for (int k = 0; k <= dim; ++k) {
    const auto tag = in.count("a node tag");
    nodes[k] = find_node(file, tag);
    if (nodes[k] < 0) {
      in.fail(std::string(element_word[dim]) + " " + std::to_string(number) + " uses node " +
              std::to_string(tag) + ", which is not in $Nodes");
    }
  }
  return nodes;
}

void read_elements_2(Tokens& in, File& file) {
  const auto n = in.count("the number of elements");
  for (std::int64_t i = 0; i < n; ++i) {
    const auto number = in.count("an element number");
    const int dim = dimension_of_type(in, in.number<int>("an element type"));
    const auto n_tags = in.count("a number of tags");
    const int group = n_tags > 0 ? std::abs(in.number<int>("a physical tag")) : 0;
    const int entity = n_tags > 1 ? in.number<int>("an entity tag") : 0;
    for (std::int64_t k = 2; k < n_tags; ++k) in.number<int>("a tag");
    const auto nodes = read_corners(in, file, dim, number);
    file.elements[dim].push_back({nodes, group, entity, number, in.line()});
  }
  in.expect("$EndElements");
}

void read_elements_4(Tokens& in, File& file) {
  const auto n_blocks = in.count("a number of element blocks");
  for (int k = 0; k < 3; ++k) in.count("a number of elements or an element tag");
  for (std::int64_t block = 0; block < n_blocks; ++block) {
    const int entity_dim = in.number<int>("an entity dimension");
    const int entity = in.number<int>("an entity tag");
    const int dim = dimension_of_type(in, in.number<int>("an element type"));
    std::vector<int> groups = file.groups_of_entity[{entity_dim, entity}];
    if (groups.empty()) groups = {0};
    const auto n = in.count("the number of elements of a block");
    for (std::int64_t i = 0; i < n; ++i) {
      const auto number = in.count("an element tag");
      const auto nodes = read_corners(in, file, dim, number);
      for (int group : groups) {
        file.elements[dim].push_back({nodes, group, entity, number, in.line()});
      }
    }
  }
  in.expect("$EndElements");
}

}  // namespace

File read(const std::string& name, const std::string& text) {
  Tokens in(name, text);
  if (in.at_end()) in.fail("the file is empty; expected $MeshFormat");
  File file;
  file.name = name;
  std::string version;
  bool has_elements = false;
  while (!in.at_end()) {
    const std::string_view section = in.word("a section");
    if (section.front() != '$') {
      in.fail("expected a section such as $MeshFormat, found '" +
              std::string(section.substr(0, 40)) + "'; is this a Gmsh file?");
    }
    if (section == "$MeshFormat") {
      read_format(in, version);
    } else if (version.empty() && section != "$Comments") {
      in.fail("expected $MeshFormat, found " + std::string(section));
    } else if (section == "$PhysicalNames") {
      read_names(in, file);
    } else if (section == "$Entities") {
      read_entities(in, file);
    } else if (section == "$PartitionedEntities") {
      in.fail("partitioned mesh; save it without partitions");
    } else if (section == "$Nodes") {
      read_nodes(in, file, version == "4.1");
    } else if (section == "$Elements") {
      version == "4.1" ? read_elements_4(in, file) : read_elements_2(in, file);
      has_elements = true;
    } else {
      in.skip_section(section);
    }
  }
  if (!has_elements) in.fail("the file ends without $Elements: truncated?");
  file.last_line = in.line();
  return file;
}

}  // namespace stylet::gmsh
