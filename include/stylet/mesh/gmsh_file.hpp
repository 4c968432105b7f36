// What a Gmsh file says, before it is reduced to named cells and facets: formats 2 and 4.1, ASCII and
// binary of either byte order, and ASCII 4.0.
// Errors: InputError that begins with the place in the file.
#pragma once

#include "stylet/mesh/gmsh_tokens.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace stylet::gmsh {

inline constexpr std::array<const char*, 4> element_word = {"point", "line", "triangle",
                                                            "tetrahedron"};
inline constexpr std::array<const char*, 4> entity_word = {"point", "curve", "surface", "volume"};
inline constexpr std::array<const char*, 4> gmsh_word = {"Point", "Curve", "Surface", "Volume"};

inline constexpr int any_dim = -1;

struct PhysicalName {
  int dim;  ///< or any_dim: format 2.0 did not say
  int tag;
  std::string name;
};

struct Element {
  std::array<int, 4> nodes;  ///< positions in the file, not tags
  int groups;                ///< index into File::groups
  int entity;
  std::int64_t number;
  std::int64_t place;
};

struct File {
  std::string name;
  bool binary = false;
  FilePlace end;
  std::vector<PhysicalName> names;
  /// Sets of physical tags; the first one is empty. Elements share them: one surface may be in many
  /// groups and have many elements.
  std::vector<std::vector<int>> groups = {{}};
  std::vector<std::array<double, 3>> points;
  std::vector<std::int64_t> point_place;
  std::vector<std::pair<std::int64_t, int>> by_tag;  ///< tag and position, sorted
  std::array<std::vector<Element>, 4> elements;      ///< by dimension

  [[noreturn]] void fail(std::int64_t place, const std::string& message) const {
    fail_at(name, {binary, place}, message);
  }
};

/// Reads all sections that matter and checks their structure.
File read(const std::string& name, const std::string& text);

}  // namespace stylet::gmsh
