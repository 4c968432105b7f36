#include "stylet/needle/advance.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/geometry/triangle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace stylet {

namespace {

/// The mesh with some nodes moved, without touching it.
class Overlay {
 public:
  Overlay(const Mesh& mesh, std::span<const NodeEdit> moves) : mesh_(mesh), moves_(moves) {}
  [[nodiscard]] ReferencePoint point(int node) const {
    const auto moved = std::ranges::find(moves_, node, &NodeEdit::node);
    return moved == moves_.end() ? mesh_.point(node) : moved->x;
  }
  [[nodiscard]] double cell_quality(int c) const {
    const auto n = mesh_.cell(c);
    return quality(point(n[0]), point(n[1]), point(n[2]));
  }

 private:
  const Mesh& mesh_;
  std::span<const NodeEdit> moves_;
};

/// Solves F r = d for the deformation gradient F of the cell; none where det F is too small.
std::optional<Vector2> pulled_back(const Mesh& mesh, int c, const NeedleView& start, Vector2 d) {
  const auto n = mesh.cell(c);
  const Vector2 e1 = mesh.point(n[1]) - mesh.point(n[0]);
  const Vector2 e2 = mesh.point(n[2]) - mesh.point(n[0]);
  const Vector2 u0 = start.at(n[0]).u;
  const Vector2 w1 = e1 + (start.at(n[1]).u - u0);
  const Vector2 w2 = e2 + (start.at(n[2]).u - u0);
  // In the world d = s1 w1 + s2 w2; in the reference mesh the same combination of e1, e2.
  const double det = cross(w1, w2);
  constexpr double collapsed = 0.05;  // of the reference area
  if (det < collapsed * cross(e1, e2)) return std::nullopt;
  return (cross(d, w2) / det) * e1 + (cross(w1, d) / det) * e2;
}

struct Way {
  int cell = -1;
  int j = -1;
  int k = -1;
  Vector2 r;
  RayHit hit{};
  double margin = -std::numeric_limits<double>::infinity();
};

// A direction that leaves its own cell by less than this (of the edge ahead) still counts as ahead.
constexpr double tie = 1e-6;

template <class Direction>
Way widest_way(const Mesh& mesh, int tip, Direction&& direction_in) {
  Way best;
  const ReferencePoint p = mesh.point(tip);
  double best_across = 0;
  for (const int c : mesh.cells_around(tip)) {
    const std::optional<Vector2> direction = direction_in(c);
    if (!direction) continue;
    const auto n = mesh.cell(c);
    const auto at = static_cast<std::size_t>(std::ranges::find(n, tip) - n.begin());
    Way way{c, n[(at + 1) % 3], n[(at + 2) % 3], (1 / norm(*direction)) * *direction, {}, 0};
    const auto hit = ray_segment(p, way.r, mesh.point(way.j), mesh.point(way.k));
    if (!hit || hit->s <= 0) continue;
    way.hit = *hit;
    way.margin = std::min({hit->fraction, 1 - hit->fraction, tie});
    const double across = Axis::across(midpoint(mesh.point(way.j), mesh.point(way.k)));
    // Along an edge two cells tie: the one on the higher side wins.
    if (way.margin > best.margin + tie / 2 ||
        (way.margin > best.margin - tie / 2 && across > best_across)) {
      best = way;
      best_across = across;
    }
  }
  return best;
}

}  // namespace

double quality_after(const Mesh& mesh, std::span<const NodeEdit> moves) {
  const Overlay overlay(mesh, moves);
  double worst = std::numeric_limits<double>::infinity();
  for (const auto& move : moves) {
    for (const int c : mesh.cells_around(move.node)) {
      worst = std::min(worst, overlay.cell_quality(c));
    }
  }
  return worst;
}

std::optional<AdvanceBase> find_way(const Mesh& mesh,
                                    const Track& track,
                                    const Axis& axis,
                                    const NeedleView& start) {
  const int tip = track.tip();
  const Vector2 d = axis.direction();
  Way way = widest_way(mesh, tip, [&](int c) -> std::optional<Vector2> {
    const auto r = pulled_back(mesh, c, start, d);
    constexpr double turned_away = 0.2;
    if (!r || dot(*r, d) < turned_away * norm(*r)) return std::nullopt;
    return r;
  });
  AdvanceBase base;
  if (way.margin < -tie) {
    way = widest_way(mesh, tip, [&](int) { return std::optional<Vector2>(d); });
    base.fell_back = true;
    if (way.margin < -tie) return std::nullopt;
  }
  base.p = mesh.point(tip);
  base.r = way.r;
  base.cell = way.cell;
  base.j = way.j;
  base.k = way.k;
  base.distance = way.hit.s;
  base.at_tip = start.at(tip);
  base.at_edge = interpolate(way.hit.fraction, start.at(way.j), start.at(way.k));
  if (track.size() == 1) {
    base.hand_over = 0;  // the first cut hands over at once (model.md: the skin is never dented)
    return base;
  }
  // |l - p - b r| = 2 (distance - b), the smaller root (paper, sec. V.A).
  const Vector2 w = base.p - mesh.point(track.behind_tip());
  const double half = 4 * base.distance + dot(w, base.r);
  const double c = 4 * base.distance * base.distance - dot(w, w);
  base.hand_over = c / (half + std::sqrt(std::max(0.0, half * half - 3 * c)));
  return base;
}

NodeEdit advanced(const AdvanceBase& base, int tip, double b) {
  return {tip, base.p + b * base.r, interpolate(b / base.distance, base.at_tip, base.at_edge)};
}

std::optional<HandOver> plan_hand_over(const Mesh& mesh,
                                       const Track& track,
                                       const AdvanceBase& base,
                                       const NeedleView& start) {
  const int old_tip = track.tip();
  const ReferencePoint p = mesh.point(old_tip);
  const bool at_skin = track.size() == 1;
  const auto plan_for = [&](int node) -> std::optional<HandOver> {
    if (mesh.is_locked(node) || track.holds(node)) return std::nullopt;
    HandOver plan{node, {}, 0};
    if (at_skin) {
      const NodeEdit ahead = advanced(base, old_tip, 0.5 * base.distance);
      plan.moves.push_back({node, ahead.x, ahead.state});
    } else {
      const int l = track.behind_tip();
      plan.moves.push_back({node, p, start.at(old_tip)});
      plan.moves.push_back(
          {old_tip, midpoint(mesh.point(l), p), interpolate(0.5, start.at(l), start.at(old_tip))});
    }
    plan.quality = quality_after(mesh, plan.moves);
    return plan;
  };
  // The nearer node of the edge ahead (paper); of two equally near ones the higher.
  int first = base.j;
  int second = base.k;
  const double dj = distance(mesh.point(base.j), p);
  const double dk = distance(mesh.point(base.k), p);
  constexpr double equal = 1e-6;
  const bool tied = std::abs(dj - dk) <= equal * (dj + dk);
  if (tied ? Axis::across(mesh.point(second)) > Axis::across(mesh.point(first)) : dk < dj) {
    std::swap(first, second);
  }
  auto best = plan_for(first);
  constexpr double good_enough = 0.2;  // below it the other node is tried as well
  if (!best || best->quality < good_enough) {
    const auto other = plan_for(second);
    if (other && (!best || other->quality > best->quality)) best = other;
  }
  return best;
}

Entry find_entry(const Mesh& mesh, const Axis& axis, const std::string& needle) {
  // Boundary edges that the axis crosses; the first one from outside is met at the lowest along.
  std::optional<Entry> entry;
  double first_along = std::numeric_limits<double>::infinity();
  const double y = axis.across_position;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto n = mesh.cell(c);
    for (std::size_t i = 0; i < 3; ++i) {
      int a = n[i];
      int b = n[(i + 1) % 3];
      double ya = Axis::across(mesh.point(a));
      double yb = Axis::across(mesh.point(b));
      if ((ya > y) == (yb > y) || !mesh.on_boundary(a) || !mesh.on_boundary(b)) continue;
      if (mesh.across(c, a, b)) continue;
      double s = (y - ya) / (yb - ya);
      if (s > 0.5) {  // the nearer end slides
        std::swap(a, b);
        s = 1 - s;
      }
      const ReferencePoint x = mesh.point(a) + s * (mesh.point(b) - mesh.point(a));
      if (Axis::along(x) < first_along) {
        first_along = Axis::along(x);
        entry = Entry{a, b, s, {x.x, y}};
      }
    }
  }
  if (!entry) {
    throw InputError("needle '" + needle + "' at height " + std::to_string(y) +
                     " m misses the tissue");
  }
  // A corner of the tissue must stay where it is: then the other end slides.
  const auto is_corner = [&](int node) {
    std::vector<int> ends;
    for (const int other : mesh.neighbours(node)) {
      if (other == node || !mesh.on_boundary(other)) continue;
      if (mesh.cells_with(node, other).size() == 1) ends.push_back(other);
    }
    if (ends.size() != 2) return true;
    const Vector2 e0 = mesh.point(node) - mesh.point(ends[0]);
    const Vector2 e1 = mesh.point(ends[1]) - mesh.point(node);
    constexpr double straight = 0.5;  // sine of 30 degrees
    return dot(e0, e1) <= 0 || std::abs(cross(e0, e1)) > straight * norm(e0) * norm(e1);
  };
  if (entry->fraction > 0 && is_corner(entry->node)) {
    std::swap(entry->node, entry->neighbour);
    entry->fraction = 1 - entry->fraction;
    if (entry->fraction < 1 && is_corner(entry->node)) {
      throw InputError("needle '" + needle + "' at height " + std::to_string(y) +
                       " m enters between two corners of the tissue: refine the mesh");
    }
  }
  return *entry;
}

std::optional<EdgeFlip> best_flip(const Mesh& mesh,
                                  const Track& track,
                                  std::span<const int> touched_cells,
                                  double wanted) {
  const std::set<int> cells(touched_cells.begin(), touched_cells.end());
  std::optional<EdgeFlip> best;
  constexpr double worth_it = 1.05;  // a flip must raise the worst quality by this factor
  double best_gain = 0;
  for (const int c : cells) {
    if (mesh.cell_quality(c) >= wanted) continue;
    const auto n = mesh.cell(c);
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = n[i];
      const int b = n[(i + 1) % 3];
      const auto other = mesh.across(c, a, b);
      if (!other || mesh.is_locked_edge(a, b)) continue;
      const auto nodes = track.nodes();
      const auto consecutive = [&](const ShaftNode& x, const ShaftNode& y) {
        return (x.node == a && y.node == b) || (x.node == b && y.node == a);
      };
      if (std::ranges::adjacent_find(nodes, consecutive) != nodes.end()) continue;
      const int mine = n[(i + 2) % 3];
      const int far = mesh.opposite(*other, a, b);
      const double before = std::min(mesh.cell_quality(c), mesh.cell_quality(*other));
      const double after = std::min(quality(mesh.point(mine), mesh.point(a), mesh.point(far)),
                                    quality(mesh.point(mine), mesh.point(far), mesh.point(b)));
      if (after > std::max(worth_it * before, before + 1e-3) &&
          after - before > best_gain * (1 + 1e-9)) {
        best_gain = after - before;
        best = EdgeFlip{a, b};
      }
    }
  }
  return best;
}

}  // namespace stylet
