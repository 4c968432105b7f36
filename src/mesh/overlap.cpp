#include "stylet/mesh/overlap.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/geometry/points.hpp"
#include "stylet/geometry/triangle.hpp"
#include "stylet/mesh/sides.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace stylet {

namespace {

using Edge = std::array<int, 2>;

class Sheet {
 public:
  explicit Sheet(const MeshData& mesh) : mesh_(mesh) {
    low_ = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    high_ = {-low_.x, -low_.y};
    double shortest = low_.x;
    for (int c = 0; c < mesh.n_cells(); ++c) {
      for (int k = 0; k < 3; ++k) {
        const ReferencePoint p = point(node(c, k));
        low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
        high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y)};
        shortest = std::min(shortest, distance(p, point(node(c, (k + 1) % 3))));
      }
    }
    constexpr double of_size = 1e-8;
    constexpr double of_shortest = 1e-3;
    touch_ = std::min(of_size * distance(low_, high_), of_shortest * shortest);
  }

  void check() {
    check_doubled_nodes();
    check_angles();
    sides_ = sides_of<2>(mesh_);
    check_boundary();
    check_parts();
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw InputError(mesh_.source + ": " + message);
  }
  [[nodiscard]] int node(int c, int k) const {
    return mesh_.cells[3 * static_cast<std::size_t>(c) + static_cast<std::size_t>(k)];
  }
  [[nodiscard]] ReferencePoint point(int n) const {
    const auto at = 2 * static_cast<std::size_t>(n);
    return {mesh_.coordinates[at], mesh_.coordinates[at + 1]};
  }
  static std::string at(ReferencePoint p) {
    char text[64];
    std::snprintf(text, sizeof text, "(%.9g, %.9g) m", p.x, p.y);
    return text;
  }
  [[nodiscard]] std::string at(int n) const { return at(point(n)); }
  [[nodiscard]] std::string node_number(int n) const {
    return number_in_file(mesh_.origin.node_number, n);
  }
  [[nodiscard]] std::string cell_number(int c) const {
    return number_in_file(mesh_.origin.cell_number, c);
  }
  [[nodiscard]] std::string shown(const Edge& e) const {
    return "from node " + node_number(e[0]) + " at " + at(e[0]) + " to node " + node_number(e[1]) +
           " at " + at(e[1]);
  }

  void check_doubled_nodes() const {
    std::vector<int> nodes(mesh_.cells.begin(), mesh_.cells.end());
    std::ranges::sort(nodes);
    const auto [first, last] = std::ranges::unique(nodes);
    nodes.erase(first, last);
    std::ranges::sort(nodes, {}, [&](int n) { return point(n).x; });
    // Columns of nodes whose x are close, then neighbours in y: a grid has whole columns at one x.
    for (auto begin = nodes.begin(); begin != nodes.end();) {
      const auto end = std::adjacent_find(
          begin, nodes.end(), [&](int a, int b) { return point(b).x - point(a).x > touch_; });
      const auto column_end = end == nodes.end() ? end : std::next(end);
      std::ranges::sort(begin, column_end, {}, [&](int n) { return point(n).y; });
      for (auto i = begin; i != column_end; ++i) {
        for (auto j = std::next(i); j != column_end && point(*j).y - point(*i).y <= touch_; ++j) {
          if (std::abs(point(*j).x - point(*i).x) <= touch_) fail_doubled(*i, *j);
        }
      }
      begin = column_end;
    }
  }

  [[noreturn]] void fail_doubled(int i, int j) const {
    const auto [a, b] = std::minmax(i, j);
    fail("nodes " + node_number(a) + " and " + node_number(b) + " are at the same place, " + at(a) +
         ": triangles on the two sides are not joined there; allowed: one node a place (merge "
         "doubled interfaces in the mesher)");
  }

  // Around a node triangles turn once at most.
  void check_angles() const {
    std::vector<double> turned(static_cast<std::size_t>(mesh_.n_nodes()), 0.0);
    constexpr double round_off = 1e-6;
    for (int c = 0; c < mesh_.n_cells(); ++c) {
      for (int k = 0; k < 3; ++k) {
        const int n = node(c, k);
        const Vector2 e = point(node(c, (k + 1) % 3)) - point(n);
        const Vector2 f = point(node(c, (k + 2) % 3)) - point(n);
        double& angle = turned[static_cast<std::size_t>(n)];
        angle += std::atan2(cross(e, f), dot(e, f));
        if (angle > 2 * std::numbers::pi + round_off) {
          fail("triangles overlap at node " + node_number(n) + " at " + at(n) +
               ": they turn around it more than once; one of them is triangle " + cell_number(c));
        }
      }
    }
  }

  // Pairs of boundary edges that come close, by a grid of about as many squares as there are edges.
  void check_boundary() const {
    const auto n = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(sides_.outer.size()))));
    const double width = std::max((high_.x - low_.x) / n, touch_);
    const double height = std::max((high_.y - low_.y) / n, touch_);
    const auto column = [&](double x) {
      return std::clamp(static_cast<int>((x - low_.x) / width), 0, n - 1);
    };
    const auto row = [&](double y) {
      return std::clamp(static_cast<int>((y - low_.y) / height), 0, n - 1);
    };
    std::vector<std::vector<int>> squares(static_cast<std::size_t>(n) *
                                          static_cast<std::size_t>(n));
    for (std::size_t e = 0; e < sides_.outer.size(); ++e) {
      ReferencePoint a = point(sides_.outer[e][0]);
      ReferencePoint b = point(sides_.outer[e][1]);
      if (a.x > b.x) std::swap(a, b);
      for (int i = column(a.x - touch_); i <= column(b.x + touch_); ++i) {
        // What of the edge lies in this column.
        const double from = std::clamp(low_.x + i * width - touch_, a.x, b.x);
        const double to = std::clamp(low_.x + (i + 1) * width + touch_, a.x, b.x);
        const auto y_at = [&](double x) {
          return b.x > a.x ? a.y + (x - a.x) / (b.x - a.x) * (b.y - a.y) : a.y;
        };
        const double y0 = b.x > a.x ? y_at(from) : a.y;
        const double y1 = b.x > a.x ? y_at(to) : b.y;
        for (int j = row(std::min(y0, y1) - touch_); j <= row(std::max(y0, y1) + touch_); ++j) {
          auto& square = squares[static_cast<std::size_t>(i) * static_cast<std::size_t>(n) +
                                 static_cast<std::size_t>(j)];
          for (const int other : square)
            check_pair(sides_.outer[static_cast<std::size_t>(other)], sides_.outer[e]);
          square.push_back(static_cast<int>(e));
        }
      }
    }
  }

  void check_pair(const Edge& e, const Edge& f) const {
    check_node_on(e, f[0]);
    check_node_on(e, f[1]);
    check_node_on(f, e[0]);
    check_node_on(f, e[1]);
    if (e[0] == f[0] || e[0] == f[1] || e[1] == f[0] || e[1] == f[1]) return;
    const auto hit = ray_segment(point(e[0]), point(e[1]) - point(e[0]), point(f[0]), point(f[1]));
    if (!hit || hit->s <= 0 || hit->s >= 1 || hit->fraction <= 0 || hit->fraction >= 1) return;
    const ReferencePoint x = point(e[0]) + hit->s * (point(e[1]) - point(e[0]));
    fail("triangles overlap: their outer edges cross at " + at(x) + ", one " + shown(e) + ", one " +
         shown(f));
  }

  void check_node_on(const Edge& e, int n) const {
    if (n == e[0] || n == e[1]) return;
    const ReferencePoint a = point(e[0]);
    const Vector2 along = point(e[1]) - a;
    const Vector2 to = point(n) - a;
    const double share = dot(to, along) / dot(along, along);
    if (share <= 0 || share >= 1 || std::abs(cross(along, to)) > touch_ * norm(along)) return;
    fail("node " + node_number(n) + " at " + at(n) + " lies on an outer edge, " + shown(e) +
         ": triangles on the two sides are not joined there; allowed: edges that share both nodes");
  }

  [[nodiscard]] int part(int c) const { return sides_.part[static_cast<std::size_t>(c)]; }

  void check_parts() const {
    const int first = part(0);
    int other = -1;
    for (int c = 0; c < mesh_.n_cells() && other < 0; ++c) {
      if (part(c) != first) other = c;
    }
    if (other < 0) return;
    std::vector<char> of_first(static_cast<std::size_t>(mesh_.n_nodes()), 0);
    for (int c = 0; c < mesh_.n_cells(); ++c) {
      if (part(c) != first) continue;
      for (int k = 0; k < 3; ++k) of_first[static_cast<std::size_t>(node(c, k))] = 1;
    }
    for (int c = 0; c < mesh_.n_cells(); ++c) {
      if (part(c) == first) continue;
      for (int k = 0; k < 3; ++k) {
        if (of_first[static_cast<std::size_t>(node(c, k))] == 0) continue;
        fail("parts of the mesh hang together at a single node only, " + node_number(node(c, k)) +
             " at " + at(node(c, k)) + "; allowed: parts joined along edges");
      }
    }
    fail("the mesh is in parts that share no node: one has triangle " + cell_number(0) + " at " +
         at(node(0, 0)) + ", another triangle " + cell_number(other) + " at " + at(node(other, 0)) +
         "; allowed: one part, joined along edges");
  }

  const MeshData& mesh_;
  ReferencePoint low_;
  ReferencePoint high_;
  double touch_ = 0;  ///< closer than this is on each other (m)
  Sides<2> sides_;
};

}  // namespace

void check_overlaps(const MeshData& mesh) {
  Sheet(mesh).check();
}

}  // namespace stylet
