// What a Gmsh file says (ASCII 2.2 and 4.1), before it is reduced to named cells and facets.
// Errors: InputError "name:line: ...".
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace stylet::gmsh {

inline constexpr std::array<const char*, 4> element_word = {"point", "line", "triangle",
                                                            "tetrahedron"};
inline constexpr std::array<const char*, 4> entity_word = {"point", "curve", "surface", "volume"};
inline constexpr std::array<const char*, 4> gmsh_word = {"Point", "Curve", "Surface", "Volume"};

struct PhysicalName {
  int dim;
  int tag;
  std::string name;
};

struct Element {
  std::array<int, 4> nodes;  ///< positions in the file, not tags
  int group;                 ///< physical tag, 0 for none
  int entity;
  std::int64_t number;
  int line;
};

struct File {
  std::string name;
  int last_line = 0;
  std::vector<PhysicalName> names;
  std::map<std::pair<int, int>, std::vector<int>> groups_of_entity;  ///< by dimension and tag
  std::vector<std::array<double, 3>> points;
  std::vector<int> point_line;
  std::vector<std::pair<std::int64_t, int>> by_tag;  ///< tag and position, sorted
  std::array<std::vector<Element>, 4> elements;      ///< by dimension
};

/// Reads all sections that matter and checks their structure.
File read(const std::string& name, const std::string& text);

}  // namespace stylet::gmsh
