#include "stylet/needle/advance.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/geometry/triangle.hpp"
#include "stylet/needle/quality.hpp"
#include "stylet/needle/skin.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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

// The tip goes forward as long as the elements around it keep this quality (or most of what they
// have): moving along the element ahead can flatten those beside it.
double reach_of(const Mesh& mesh, int tip, Vector2 r, double distance) {
  const ReferencePoint p = mesh.point(tip);
  const auto worst_at = [&](double b) {
    const NodeEdit edit[1] = {{tip, p + b * r, {}}};
    return quality_after(mesh, edit);
  };
  constexpr double kept = 0.7;
  const double lowest = std::max(least_quality, std::min(fair_quality, kept * worst_at(0)));
  constexpr int samples = 20;
  constexpr double most = 0.95;
  double reach = 0;
  for (int i = 1; i <= samples; ++i) {
    const double b = most * distance * i / samples;
    if (worst_at(b) < lowest) break;
    reach = b;
  }
  return reach;
}

// Neighbours of the tip that may take its place: the nearer end of the edge ahead, the other end,
// then the rest that lies ahead by distance; of two equally near ones the higher.
std::vector<int> candidates(const Mesh& mesh, const AdvanceBase& base, int tip) {
  const ReferencePoint p = mesh.point(tip);
  const auto nearer = [&](int a, int b) {
    const double da = distance(mesh.point(a), p);
    const double db = distance(mesh.point(b), p);
    constexpr double equal = 1e-6;
    if (std::abs(da - db) > equal * (da + db)) return da < db;
    return Axis::across(mesh.point(a)) > Axis::across(mesh.point(b));
  };
  std::vector<int> nodes{base.j, base.k};
  if (nearer(base.k, base.j)) std::swap(nodes[0], nodes[1]);
  std::vector<int> rest;
  for (const int node : mesh.neighbours(tip)) {
    if (node == tip || node == base.j || node == base.k) continue;
    if (dot(mesh.point(node) - p, base.r) > 0) rest.push_back(node);
  }
  std::ranges::sort(rest, nearer);
  nodes.insert(nodes.end(), rest.begin(), rest.end());
  return nodes;
}

// Edges of the cells around a node that may be flipped, from above to below.
std::vector<EdgeFlip> edges_around(const Mesh& mesh, const Track& track, int node) {
  std::vector<EdgeFlip> edges;
  for (const int c : mesh.cells_around(node)) {
    const auto n = mesh.cell(c);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(n[i], n[(i + 1) % 3]);
      if (mesh.is_locked_edge(a, b) || track.has_edge(a, b)) continue;
      const auto same = [a = a, b = b](const EdgeFlip& e) { return e.a == a && e.b == b; };
      if (std::ranges::none_of(edges, same)) edges.push_back({a, b});
    }
  }
  std::ranges::sort(edges, [&](const EdgeFlip& x, const EdgeFlip& y) {
    const auto mx = midpoint(mesh.point(x.a), mesh.point(x.b));
    const auto my = midpoint(mesh.point(y.a), mesh.point(y.b));
    if (Axis::across(mx) != Axis::across(my)) return Axis::across(mx) > Axis::across(my);
    return Axis::along(mx) > Axis::along(my);
  });
  return edges;
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
  base.reach = reach_of(mesh, tip, base.r, base.distance);
  if (track.size() == 1) {
    base.hand_over = 0;  // the first cut hands over at once (src/MODEL.md, section 4)
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
  const LocalMesh patch(mesh, mesh.neighbours(old_tip));
  // Flips commute with moves, so one before the hand-over stands first among those after it.
  const auto plan_for = [&](int node, const std::optional<EdgeFlip>& first) {
    HandOver plan;
    plan.new_tip = node;
    if (at_skin) {
      const NodeEdit ahead = advanced(base, old_tip, 0.5 * base.distance);
      plan.edits.moves.push_back({node, ahead.x, ahead.state});
    } else {
      const int l = track.behind_tip();
      plan.edits.moves.push_back({node, p, start.at(old_tip)});
      plan.edits.moves.push_back(
          {old_tip, midpoint(mesh.point(l), p), interpolate(0.5, start.at(l), start.at(old_tip))});
    }
    LocalMesh copy = patch;
    Mesh& local = copy.mesh();
    Track path = copy.local(track);
    path.push({copy.local(node)});
    std::vector<int> touched;
    if (first) {
      touched = local.cells_with(copy.local(first->a), copy.local(first->b));
      local.flip_edge(copy.local(first->a), copy.local(first->b));
      plan.edits.flips.push_back(*first);
    }
    for (const auto& move : plan.edits.moves) {
      local.move_node(copy.local(move.node), move.x);
      const auto around = local.cells_around(copy.local(move.node));
      touched.insert(touched.end(), around.begin(), around.end());
    }
    for (const auto& edge : repair(local, path, touched, good_quality)) {
      plan.edits.flips.push_back(copy.global(edge));
    }
    plan.quality = local.worst_quality(touched);
    return plan;
  };
  std::optional<HandOver> best;
  const auto consider = [&](int node, const std::optional<EdgeFlip>& first) {
    if (mesh.is_locked(node) || track.holds(node)) return;
    HandOver plan = plan_for(node, first);
    // Of equally good ones the earlier.
    if (!best || plan.quality > best->quality + 1e-6) best = std::move(plan);
  };
  // The nearer node of the edge ahead (paper), then the other, then all around.
  const auto nodes = candidates(mesh, base, old_tip);
  for (const int node : nodes) {
    consider(node, std::nullopt);
    const bool enough = best && best->quality >= (node == nodes[0] ? good_quality : fair_quality);
    if (enough && (node != nodes[0] || best->quality >= good_quality)) break;
  }
  if (best && best->quality >= fair_quality) return best;
  for (const auto& edge : edges_around(mesh, track, old_tip)) {
    for (const int node : nodes) {
      const auto n = patch.mesh().cells_with(patch.local(node), patch.local(old_tip));
      const bool parted = (edge.a == node && edge.b == old_tip) ||
                          (edge.b == node && edge.a == old_tip);  // must stay a neighbour
      if (!n.empty() && !parted) consider(node, edge);
    }
  }
  return best;
}

std::optional<EdgeFlip> plan_passage(const Mesh& mesh,
                                     const Track& track,
                                     const AdvanceBase& base) {
  const int tip = track.tip();
  const LocalMesh patch(mesh, mesh.neighbours(tip));
  std::optional<EdgeFlip> best;
  constexpr double worth_it = 1.2;
  double longest = worth_it * base.reach;
  for (const auto& edge : edges_around(mesh, track, tip)) {
    LocalMesh copy = patch;
    Mesh& local = copy.mesh();
    const auto both = local.cells_with(copy.local(edge.a), copy.local(edge.b));
    local.flip_edge(copy.local(edge.a), copy.local(edge.b));
    if (local.worst_quality(both) < least_quality) continue;
    const int at = copy.local(tip);
    const Way way = widest_way(local, at, [&](int) { return std::optional<Vector2>(base.r); });
    if (way.margin < -tie) continue;
    const double far = reach_of(local, at, base.r, way.hit.s);
    if (far > longest * (1 + 1e-6)) {
      longest = far;
      best = edge;
    }
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
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (int node = 0; node < mesh.n_nodes(); ++node) {
      low = std::min(low, Axis::across(mesh.point(node)));
      high = std::max(high, Axis::across(mesh.point(node)));
    }
    const double size = high - low;
    throw InputError("needle '" + needle + "' at height " + ten_digits(y) +
                     " m misses the tissue, which spans heights from " +
                     ten_digits(cleared(low, size)) + " m to " + ten_digits(cleared(high, size)) +
                     " m");
  }
  // A corner of the tissue must stay where it is: then the other end slides.
  if (entry->fraction > 0 && is_corner(mesh, entry->node)) {
    std::swap(entry->node, entry->neighbour);
    entry->fraction = 1 - entry->fraction;
    if (entry->fraction < 1 && is_corner(mesh, entry->node)) {
      throw InputError("needle '" + needle + "' at height " + ten_digits(y) +
                       " m enters between two corners of the tissue: refine the mesh");
    }
  }
  return *entry;
}

}  // namespace stylet
