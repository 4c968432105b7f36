#include "stylet/mesh/gmsh_file.hpp"

#include "stylet/base/text.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <map>

namespace stylet::gmsh {

namespace {

constexpr const char* allowed =
    "allowed: 2 and 4.1, ASCII or binary, and 4.0 ASCII; convert it: gmsh OLD.msh -save -format "
    "msh41 -o NEW.msh";

enum class Format { none, two, four_zero, four_one };

class Reader {
 public:
  Reader(const std::string& name, std::string_view text) : in_(name, text) { file_.name = name; }

  File read();

 private:
  void read_section(std::string_view section);
  void read_format();
  void read_names();
  void read_entities();
  void read_nodes();
  void add_point(std::int64_t tag);
  void sort_tags();
  void read_elements();
  void read_elements_2();
  void read_elements_4();
  void read_tags_2(std::int64_t n, int& groups, int& entity);
  [[nodiscard]] int dimension_of(int type) const;
  [[nodiscard]] int find_node(std::int64_t tag) const;
  std::array<int, 4> read_corners(int dim, std::int64_t number);
  void enter_binary_part() {
    if (in_.binary()) in_.end_line();
  }

  Tokens in_;
  File file_;
  Format format_ = Format::none;
  bool has_elements_ = false;
  std::map<std::pair<int, int>, int> groups_of_entity_;  ///< by dimension and tag
  std::map<int, int> groups_of_tag_;                     ///< format 2
};

void Reader::read_format() {
  const std::string_view version = in_.word("the format version");
  double number = 0;
  const auto [end, status] =
      std::from_chars(version.data(), version.data() + version.size(), number);
  const bool is_number = status == std::errc() && end == version.data() + version.size();
  if (is_number && number >= 2 && number < 3) format_ = Format::two;
  if (is_number && number == 4) format_ = Format::four_zero;
  if (is_number && number == 4.1) format_ = Format::four_one;
  if (format_ == Format::none) in_.fail("Gmsh format " + cut_short(version, 40) + "; " + allowed);
  const int kind = in_.number<int>("0 for ASCII or 1 for binary");
  if (kind != 0 && kind != 1) {
    in_.fail("file type " + std::to_string(kind) + "; allowed: 0 for ASCII, 1 for binary");
  }
  if (kind == 1 && format_ == Format::four_zero) {
    in_.fail(std::string("binary file of Gmsh format 4.0; ") + allowed);
  }
  const auto size = in_.count("the size of a number");
  if (kind == 1) {
    if (size != sizeof(double)) {
      in_.fail("numbers of " + std::to_string(size) + " bytes in a binary file; allowed: 8");
    }
    in_.end_line();
    in_.make_binary(format_ == Format::two ? 4 : 8);
    file_.binary = true;
    const auto one = in_.raw<std::uint32_t>("the number 1");
    constexpr std::uint32_t swapped_one = 0x01000000;
    if (one == swapped_one) in_.swap_bytes();
    if (one != 1 && one != swapped_one) in_.fail("expected the binary number 1: damaged?");
  }
  in_.expect("$EndMeshFormat");
}

void Reader::read_names() {
  const auto n = in_.count("the number of physical names");
  for (std::int64_t i = 0; i < n; ++i) {
    if (in_.at_end()) in_.number<int>("a physical tag");
    // Format 2.0 has the tag alone, later ones the dimension before it.
    const bool has_dim = in_.before_quote().find_first_of(" \t") != std::string_view::npos;
    const int dim = has_dim ? in_.number<int>("a dimension") : any_dim;
    const int tag = in_.number<int>("a physical tag");
    file_.names.push_back({dim, tag, in_.quoted()});
  }
  in_.expect("$EndPhysicalNames");
}

void Reader::read_entities() {
  enter_binary_part();
  std::array<std::int64_t, 4> n{};
  for (auto& count : n) count = in_.id("a number of entities");
  for (int dim = 0; dim < 4; ++dim) {
    const int n_bounds = dim == 0 && format_ == Format::four_one ? 3 : 6;
    for (std::int64_t i = 0; i < n[dim]; ++i) {
      const int tag = in_.integer("an entity tag");
      for (int k = 0; k < n_bounds; ++k) in_.real("a bound of an entity");
      std::vector<int> groups;
      const auto n_groups = in_.id("a number of physical tags");
      for (std::int64_t k = 0; k < n_groups; ++k) {
        const int group = std::abs(in_.integer("a physical tag"));  // the sign is a direction
        if (group != 0) groups.push_back(group);
      }
      const auto n_bounding = dim == 0 ? 0 : in_.id("a number of bounding entities");
      for (std::int64_t k = 0; k < n_bounding; ++k) in_.integer("a bounding entity");
      if (groups.empty()) continue;
      groups_of_entity_[{dim, tag}] = static_cast<int>(file_.groups.size());
      file_.groups.push_back(std::move(groups));
    }
  }
  in_.expect("$EndEntities");
}

void Reader::add_point(std::int64_t tag) {
  const std::int64_t place = in_.place().number;
  const double x = in_.real("a coordinate");
  const double y = in_.real("a coordinate");
  const double z = in_.real("a coordinate");
  file_.by_tag.emplace_back(tag, static_cast<int>(file_.points.size()));
  file_.points.push_back({x, y, z});
  file_.point_place.push_back(in_.binary() ? place : in_.place().number);
  if (file_.points.size() > std::numeric_limits<int>::max() / 4) in_.fail("too many nodes");
}

void Reader::read_nodes() {
  std::vector<std::int64_t> tags;
  if (format_ == Format::two) {
    const auto n = in_.count("the number of nodes");
    enter_binary_part();
    for (std::int64_t i = 0; i < n; ++i) add_point(in_.id("a node number"));
  } else {
    const bool tags_first = format_ == Format::four_one;
    enter_binary_part();
    const auto n_blocks = in_.id("a number of node blocks");
    in_.id("the number of nodes");
    for (int k = 0; tags_first && k < 2; ++k) in_.id("a node tag");
    for (std::int64_t block = 0; block < n_blocks; ++block) {
      // 4.1: dimension, tag; 4.0 the other way round.
      const int first = in_.integer("an entity");
      const int second = in_.integer("an entity");
      const int dim = tags_first ? first : second;
      const bool parametric = in_.integer("0 or 1 (parametric)") != 0;
      const auto n = in_.id("the number of nodes of a block");
      tags.clear();
      for (std::int64_t i = 0; tags_first && i < n; ++i) tags.push_back(in_.id("a node tag"));
      for (std::int64_t i = 0; i < n; ++i) {
        add_point(tags_first ? tags[i] : in_.id("a node tag"));
        for (int k = 0; parametric && k < dim; ++k) in_.real("a node parameter");
      }
    }
  }
  in_.expect("$EndNodes");
  sort_tags();
}

void Reader::sort_tags() {
  std::ranges::sort(file_.by_tag);
  const auto twice = std::ranges::adjacent_find(
      file_.by_tag, [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice == file_.by_tag.end()) return;
  file_.fail(file_.point_place[std::next(twice)->second],
             "node " + std::to_string(twice->first) + " is given twice");
}

/// Position of a node tag, or -1. Tags mostly run without gaps: try that place first.
int Reader::find_node(std::int64_t tag) const {
  const auto& by_tag = file_.by_tag;
  if (by_tag.empty()) return -1;
  const std::int64_t guess = tag - by_tag.front().first;
  if (guess >= 0 && guess < static_cast<std::int64_t>(by_tag.size()) &&
      by_tag[guess].first == tag) {
    return by_tag[guess].second;
  }
  const auto found = std::ranges::lower_bound(by_tag, std::pair{tag, 0});
  return found != by_tag.end() && found->first == tag ? found->second : -1;
}

int Reader::dimension_of(int type) const {
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
  static const std::map<int, const char*> words = {{3, "quadrangle"},
                                                   {5, "hexahedron"},
                                                   {6, "prism"},
                                                   {7, "pyramid"},
                                                   {8, "second-order line"},
                                                   {9, "second-order triangle"},
                                                   {10, "second-order quadrangle"},
                                                   {11, "second-order tetrahedron"},
                                                   {16, "second-order quadrangle"},
                                                   {20, "third-order triangle"},
                                                   {21, "third-order triangle"},
                                                   {26, "third-order line"}};
  const auto word = words.find(type);
  const std::string name = word == words.end() ? "n element" : std::string(" ") + word->second;
  constexpr const char* rule =
      "; allowed: points, lines, triangles and tetrahedra of first order. ";
  const bool is_high = type >= 8 && type <= 140;
  in_.fail("a" + name + " (element type " + std::to_string(type) + ")" + rule +
           (is_high ? "Use gmsh -order 1" : "Mesh without Recombine"));
}

std::array<int, 4> Reader::read_corners(int dim, std::int64_t number) {
  std::array<int, 4> nodes{};
  for (int k = 0; k <= dim; ++k) {
    const auto tag = in_.id("a node number");
    nodes[k] = find_node(tag);
    if (nodes[k] >= 0) continue;
    in_.fail(std::string(element_word[dim]) + " " + std::to_string(number) + " uses node " +
             std::to_string(tag) + ", which is not in $Nodes");
  }
  return nodes;
}

/// Physical tag, entity, then partitions; all may be missing.
void Reader::read_tags_2(std::int64_t n, int& groups, int& entity) {
  const int tag = n > 0 ? std::abs(in_.integer("a physical tag")) : 0;
  entity = n > 1 ? in_.integer("an entity tag") : 0;
  for (std::int64_t k = 2; k < n; ++k) {
    if (in_.integer("a partition") != 0) {
      in_.fail("partitioned mesh; save it without partitions");
    }
  }
  groups = 0;
  if (tag == 0) return;
  const auto [known, is_new] =
      groups_of_tag_.try_emplace(tag, static_cast<int>(file_.groups.size()));
  if (is_new) file_.groups.push_back({tag});
  groups = known->second;
}

void Reader::read_elements_2() {
  const auto n = in_.count("the number of elements");
  enter_binary_part();
  for (std::int64_t i = 0; i < n;) {
    int type = 0;
    std::int64_t n_tags = 0;
    std::int64_t n_alike = 1;
    if (in_.binary()) {
      type = in_.integer("an element type");
      n_alike = in_.id("a number of elements");
      n_tags = in_.id("a number of tags");
      if (n_alike < 1 || n_alike > n - i) {
        in_.fail("a block of " + std::to_string(n_alike) + " elements, where " +
                 std::to_string(n - i) + " are left");
      }
    }
    for (std::int64_t k = 0; k < n_alike; ++k, ++i) {
      const auto number = in_.id("an element number");
      if (!in_.binary()) {
        type = in_.integer("an element type");
        n_tags = in_.count("a number of tags");
      }
      const int dim = dimension_of(type);
      Element element{{}, 0, 0, number, in_.place().number};
      read_tags_2(n_tags, element.groups, element.entity);
      element.nodes = read_corners(dim, number);
      if (!in_.binary()) element.place = in_.place().number;
      file_.elements[dim].push_back(element);
    }
  }
}

void Reader::read_elements_4() {
  const bool is_41 = format_ == Format::four_one;
  enter_binary_part();
  const auto n_blocks = in_.id("a number of element blocks");
  in_.id("the number of elements");
  for (int k = 0; is_41 && k < 2; ++k) in_.id("an element tag");
  for (std::int64_t block = 0; block < n_blocks; ++block) {
    const int first = in_.integer("an entity");
    const int second = in_.integer("an entity");
    const int entity = is_41 ? second : first;
    const auto groups = groups_of_entity_.find({is_41 ? first : second, entity});
    const int dim = dimension_of(in_.integer("an element type"));
    const auto n = in_.id("the number of elements of a block");
    for (std::int64_t i = 0; i < n; ++i) {
      const std::int64_t place = in_.place().number;
      const auto number = in_.id("an element number");
      const auto nodes = read_corners(dim, number);
      file_.elements[dim].push_back({nodes, groups == groups_of_entity_.end() ? 0 : groups->second,
                                     entity, number, in_.binary() ? place : in_.place().number});
    }
  }
}

void Reader::read_elements() {
  format_ == Format::two ? read_elements_2() : read_elements_4();
  in_.expect("$EndElements");
  has_elements_ = true;
}

void Reader::read_section(std::string_view section) {
  if (section.front() != '$') {
    in_.fail("expected a section such as $MeshFormat, found '" + cut_short(section, 40) +
             "'; is this a Gmsh file?");
  }
  if (section == "$MeshFormat") return read_format();
  if (section == "$NOD" || section == "$ELM") {
    in_.fail("Gmsh format 1 (" + std::string(section) + "); " + allowed);
  }
  if (format_ == Format::none && section != "$Comments") {
    in_.fail("expected $MeshFormat, found " + cut_short(section, 40));
  }
  if (section == "$PhysicalNames") return read_names();
  // Format 2 has them too (Mesh.SaveTopology), in another form, and names groups at its elements.
  if (section == "$Entities" && format_ != Format::two) return read_entities();
  if (section == "$Nodes") return read_nodes();
  if (section == "$Elements") return read_elements();
  if (section == "$PartitionedEntities") {
    in_.fail("partitioned mesh; save it without partitions");
  }
  if (section == "$ParametricNodes") {
    in_.fail("parametric nodes; save it with Mesh.SaveParametric = 0");
  }
  in_.skip_section(section);
}

File Reader::read() {
  if (in_.at_end()) in_.fail("the file is empty; expected $MeshFormat");
  while (!in_.at_end()) read_section(in_.word("a section"));
  if (!has_elements_) in_.fail("the file ends without $Elements: truncated?");
  file_.end = in_.place();
  return std::move(file_);
}

}  // namespace

File read(const std::string& name, const std::string& text) {
  return Reader(name, without_byte_order_mark(text)).read();
}

}  // namespace stylet::gmsh
