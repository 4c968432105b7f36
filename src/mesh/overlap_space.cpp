// Whether the tetrahedra of a mesh cover each point once and hang together.
#include "stylet/base/errors.hpp"
#include "stylet/geometry/tetrahedron.hpp"
#include "stylet/mesh/overlap.hpp"
#include "stylet/mesh/sides.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

namespace stylet {

namespace {

using Triangle = std::array<int, 3>;
using Place = ReferencePlace;

double coordinate(const Place& p, int k) {
  return k == 0 ? p.x : k == 1 ? p.y : p.z;
}

class Solid {
 public:
  explicit Solid(const MeshData& mesh) : mesh_(mesh), low_(place(0)), high_(place(0)) {
    double shortest = 1e300;
    for (int c = 0; c < mesh.n_cells(); ++c) {
      for (int k = 0; k < 4; ++k) {
        const Place p = place(node(c, k));
        low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y), std::min(low_.z, p.z)};
        high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y), std::max(high_.z, p.z)};
        for (int l = 0; l < k; ++l) shortest = std::min(shortest, distance(p, place(node(c, l))));
      }
    }
    constexpr double of_size = 1e-8;
    constexpr double of_shortest = 1e-3;
    touch_ = std::min(of_size * distance(low_, high_), of_shortest * shortest);
  }

  void check() {
    std::vector<int> nodes(mesh_.cells.begin(), mesh_.cells.end());
    std::ranges::sort(nodes);
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    check_doubled(nodes.begin(), nodes.end(), 0);
    check_angles();
    sides_ = sides_of<3>(mesh_);
    check_parts();
    check_boundary();
  }

 private:
  using Iterator = std::vector<int>::iterator;

  [[noreturn]] void fail(const std::string& message) const {
    throw InputError(mesh_.source + ": " + message);
  }
  [[nodiscard]] int node(int c, int k) const {
    return mesh_.cells[4 * static_cast<std::size_t>(c) + static_cast<std::size_t>(k)];
  }
  [[nodiscard]] Place place(int n) const {
    const auto at = 3 * static_cast<std::size_t>(n);
    return {mesh_.coordinates[at], mesh_.coordinates[at + 1], mesh_.coordinates[at + 2]};
  }
  [[nodiscard]] std::string at(int n) const {
    const Place p = place(n);
    char text[80];
    std::snprintf(text, sizeof text, "(%.9g, %.9g, %.9g) m", p.x, p.y, p.z);
    return text;
  }
  [[nodiscard]] std::string name(int n) const {
    return number_in_file(mesh_.origin.node_number, n) + " at " + at(n);
  }
  [[nodiscard]] std::string cell_name(int c) const {
    return number_in_file(mesh_.origin.cell_number, c);
  }

  // Groups of nodes that are close along x, in them along y, in them along z.
  void check_doubled(Iterator begin, Iterator end, int k) const {
    if (end - begin < 2) return;
    if (k == 3) {
      fail("nodes " + name(*begin) + " and " +
           number_in_file(mesh_.origin.node_number, *std::next(begin)) +
           " are at the same place: tetrahedra on the two sides are not joined there; allowed: one "
           "node a place (merge doubled interfaces in the mesher)");
    }
    std::sort(begin, end, [&](int a, int b) {
      const double xa = coordinate(place(a), k);
      const double xb = coordinate(place(b), k);
      return xa != xb ? xa < xb : a < b;
    });
    while (begin != end) {
      const auto last = std::adjacent_find(begin, end, [&](int a, int b) {
        return coordinate(place(b), k) - coordinate(place(a), k) > touch_;
      });
      const auto group_end = last == end ? end : std::next(last);
      check_doubled(begin, group_end, k + 1);
      begin = group_end;
    }
  }

  // Around a node tetrahedra fill the sphere once at most. Solid angle: Van Oosterom and Strackee, IEEE
  // Trans. Biomed. Eng. 30 (1983) 125.
  void check_angles() const {
    std::vector<double> filled(static_cast<std::size_t>(mesh_.n_nodes()), 0.0);
    constexpr double round_off = 1e-6;
    for (int c = 0; c < mesh_.n_cells(); ++c) {
      for (int k = 0; k < 4; ++k) {
        const int n = node(c, k);
        const auto to = [&](int i) {
          const Vector3 v = place(node(c, corners_of_sides<3>[k][i])) - place(n);
          return (1 / norm(v)) * v;
        };
        const Vector3 a = to(0), b = to(1), d = to(2);
        const double triple = std::abs(dot(a, cross(b, d)));
        double& angle = filled[static_cast<std::size_t>(n)];
        angle += 2 * std::atan2(triple, 1 + dot(a, b) + dot(b, d) + dot(d, a));
        if (angle > 4 * std::numbers::pi + round_off) {
          fail("tetrahedra overlap at node " + name(n) +
               ": they fill the space around it more than once; one of them is tetrahedron " +
               cell_name(c));
        }
      }
    }
  }

  [[nodiscard]] int part(int c) const { return sides_.part[static_cast<std::size_t>(c)]; }

  void check_parts() const {
    const int first = part(0);
    for (int c = 1; c < mesh_.n_cells(); ++c) {
      if (part(c) == first) continue;
      fail("the mesh is in parts that share no face: one has tetrahedron " + cell_name(0) + " at " +
           at(node(0, 0)) + ", another tetrahedron " + cell_name(c) + " at " + at(node(c, 0)) +
           "; allowed: one part, joined along faces");
    }
  }

  // Pairs of outer triangles that come close, by a grid of boxes about as large as they are.
  void check_boundary() const {
    const double n_across = std::sqrt(static_cast<double>(sides_.outer.size()) / 6);
    const double box = std::max({high_.x - low_.x, high_.y - low_.y, high_.z - low_.z}) /
                       std::max(1.0, std::floor(n_across));
    struct InBox {
      std::array<int, 3> box;
      int triangle;
    };
    std::vector<InBox> entries;
    for (std::size_t t = 0; t < sides_.outer.size(); ++t) {
      std::array<int, 3> from{};
      std::array<int, 3> to{};
      for (int k = 0; k < 3; ++k) {
        const auto x = [&](std::size_t i) { return coordinate(place(sides_.outer[t][i]), k); };
        const double low = std::min({x(0), x(1), x(2)}) - touch_ - coordinate(low_, k);
        const double high = std::max({x(0), x(1), x(2)}) + touch_ - coordinate(low_, k);
        from[static_cast<std::size_t>(k)] = static_cast<int>(std::floor(low / box));
        to[static_cast<std::size_t>(k)] = static_cast<int>(std::floor(high / box));
      }
      for (int i = from[0]; i <= to[0]; ++i) {
        for (int j = from[1]; j <= to[1]; ++j) {
          for (int k = from[2]; k <= to[2]; ++k) {
            entries.push_back({{i, j, k}, static_cast<int>(t)});
          }
        }
      }
    }
    std::ranges::sort(entries, {}, [](const InBox& e) { return std::pair(e.box, e.triangle); });
    for (auto first = entries.begin(); first != entries.end();) {
      auto last = first;
      while (last != entries.end() && last->box == first->box) ++last;
      for (auto a = first; a != last; ++a) {
        for (auto b = std::next(a); b != last; ++b) {
          check_pair(sides_.outer[static_cast<std::size_t>(a->triangle)],
                     sides_.outer[static_cast<std::size_t>(b->triangle)]);
        }
      }
      first = last;
    }
  }

  void check_pair(const Triangle& s, const Triangle& t) const {
    const auto in = [](const Triangle& triangle, int n) {
      return std::ranges::find(triangle, n) != triangle.end();
    };
    const auto shared = std::ranges::count_if(s, [&](int n) { return in(t, n); });
    for (std::size_t i = 0; i < 3; ++i) {
      if (!in(t, s[i])) check_node(s[i], t);
      if (!in(s, t[i])) check_node(t[i], s);
    }
    if (shared == 2) {
      check_joined(s, t, *std::ranges::find_if_not(s, [&](int n) { return in(t, n); }),
                   *std::ranges::find_if_not(t, [&](int n) { return in(s, n); }));
      return;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t next = (i + 1) % 3;
      if (!in(t, s[i]) && !in(t, s[next])) check_edge(s[i], s[next], t);
      if (!in(s, t[i]) && !in(s, t[next])) check_edge(t[i], t[next], s);
    }
  }

  [[nodiscard]] std::string triangle_name(const Triangle& t) const {
    return "the outer triangle of nodes " + name(t[0]) + ", " + name(t[1]) + " and " + name(t[2]);
  }

  [[nodiscard]] Vector3 normal_of(const Triangle& t) const {
    const Vector3 normal = cross(place(t[1]) - place(t[0]), place(t[2]) - place(t[0]));
    return (1 / norm(normal)) * normal;
  }

  // Whether a place in the plane of a triangle is in it.
  [[nodiscard]] bool covers(const Triangle& t, const Vector3& normal, const Place& x) const {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3 side = place(t[(i + 1) % 3]) - place(t[i]);
      if (dot(cross(side, x - place(t[i])), normal) < -touch_ * norm(side)) return false;
    }
    return true;
  }

  // A node that hangs at a face of tetrahedra that do not have it.
  void check_node(int n, const Triangle& t) const {
    const Vector3 normal = normal_of(t);
    if (std::abs(dot(place(n) - place(t[0]), normal)) > touch_ || !covers(t, normal, place(n))) {
      return;
    }
    fail("node " + name(n) + " is on " + triangle_name(t) +
         ", whose tetrahedron does not have it; allowed: tetrahedra that meet face to face");
  }

  // Two triangles at an edge, one on the other: faces of tetrahedra that meet without sharing them.
  void check_joined(const Triangle& s, const Triangle& t, int of_s, int of_t) const {
    if (std::abs(dot(place(of_s) - place(t[0]), normal_of(t))) > touch_) return;
    const auto one = std::ranges::find_if(s, [&](int n) { return n != of_s; });
    const auto other = std::find_if(std::next(one), s.end(), [&](int n) { return n != of_s; });
    const Vector3 edge = place(*other) - place(*one);
    const auto away = [&](int n) { return cross(edge, place(n) - place(*one)); };
    if (dot(away(of_s), away(of_t)) <= 0) return;  // side by side
    fail(triangle_name(s) + " lies on " + triangle_name(t) +
         ", and no tetrahedra share them; allowed: tetrahedra that meet face to face");
  }

  // Whether the edge from a to b goes through a triangle.
  void check_edge(int a, int b, const Triangle& t) const {
    const Place p = place(a);
    const Place q = place(b);
    const Vector3 normal = normal_of(t);
    const double before = dot(p - place(t[0]), normal);
    const double after = dot(q - place(t[0]), normal);
    if (std::min(before, after) > touch_ || std::max(before, after) < -touch_) return;
    if (before == after) return;  // in the plane: an edge that is not reaches through too
    const double share = std::clamp(before / (before - after), 0.0, 1.0);
    if (!covers(t, normal, p + share * (q - p))) return;
    fail("tetrahedra overlap: the outer edge from node " + name(a) + " to node " + name(b) +
         " meets " + triangle_name(t) + "; allowed: one part that covers each point once");
  }

  const MeshData& mesh_;
  Place low_;
  Place high_;
  double touch_ = 0;  ///< closer than this is on each other (m)
  Sides<3> sides_;
};

}  // namespace

void check_overlaps_in_space(const MeshData& mesh) {
  Solid(mesh).check();
}

}  // namespace stylet
