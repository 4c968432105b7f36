#include "stylet/mesh/conform.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/geometry/triangle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace stylet {

namespace {

constexpr int is_free = -1;
constexpr int is_fixed = -2;

/// Move `node` to `target` so that the edge to `other` no longer crosses.
struct Snap {
  double distance;
  int node;
  int other;
  ReferencePoint target;
};

class Fitter {
 public:
  Fitter(Mesh& mesh, std::span<const KeptLine> lines, std::string advice)
      : mesh_(mesh), lines_(lines), advice_(std::move(advice)), same_(coincidence(mesh)) {
    line_of_.resize(mesh.n_nodes());
    outline_of_.assign(mesh.n_nodes(), is_fixed);
    for (int i = 0; i < mesh.n_nodes(); ++i) line_of_[i] = find_line(mesh.point(i));
  }

  void fit(const InnerRegion& region);
  void improve();

 private:
  [[nodiscard]] bool on_line(ReferencePoint p, const KeptLine& line) const {
    return distance(p, nearest_on_segment(line.a, line.b, p)) <= same_;
  }
  [[nodiscard]] int find_line(ReferencePoint p) const;
  void place_corners(const InnerRegion& region);
  void find_sides(const Outline& outline);
  [[nodiscard]] std::vector<Snap> crossing_edges(const Outline& outline) const;
  void add_snap(const Outline& outline, int node, int other, std::vector<Snap>& snaps) const;
  void pin(int node, bool is_corner = false);
  [[nodiscard]] std::vector<int> nodes_nearby() const;
  void flip_around(int node);
  void release(int node);
  void smooth(int node);
  [[nodiscard]] bool on_one_side(int c, int d) const;
  [[noreturn]] void fail(const InnerRegion& region, const std::string& what) const {
    throw InputError(mesh_.data().source + ": region '" + region.name + "': " + what + "; " +
                     advice_);
  }

  Mesh& mesh_;
  std::span<const KeptLine> lines_;
  std::string advice_;
  double same_;
  std::vector<int> line_of_;     ///< the one line a node may slide on, is_free or is_fixed
  std::vector<int> outline_of_;  ///< the one outline a snapped node may slide on, or is_fixed
  std::vector<int> side_;        ///< of the present outline: -1 inside, 0 on it, 1 outside
  std::vector<int> pinned_;
  std::vector<const Outline*> fitted_;
  std::vector<std::vector<int>> sides_;  ///< side_ of each fitted outline
};

int Fitter::find_line(ReferencePoint p) const {
  int line = is_free;
  for (std::size_t l = 0; l < lines_.size(); ++l) {
    if (!on_line(p, lines_[l])) continue;
    const bool at_end = distance(p, lines_[l].a) <= same_ || distance(p, lines_[l].b) <= same_;
    if (at_end || line != is_free) return is_fixed;
    line = static_cast<int>(l);
  }
  return line;
}

void Fitter::pin(int node, bool is_corner) {
  const bool slides = line_of_[node] == is_free && !is_corner;
  outline_of_[node] = slides ? static_cast<int>(fitted_.size()) : is_fixed;
  line_of_[node] = is_fixed;
  pinned_.push_back(node);
}

void Fitter::place_corners(const InnerRegion& region) {
  const auto* polygon = std::get_if<std::vector<ReferencePoint>>(&region.outline);
  if (polygon == nullptr) return;
  for (const ReferencePoint corner : *polygon) {
    const int corner_line = find_line(corner);
    int best = -1;
    double shortest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < mesh_.n_nodes(); ++i) {
      const double d = distance(mesh_.point(i), corner);
      const bool movable = line_of_[i] != is_fixed && line_of_[i] == corner_line;
      if (d >= shortest || !(movable || d <= same_)) continue;
      shortest = d;
      best = i;
    }
    if (best < 0) fail(region, "no node is left for a corner of the polygon");
    mesh_.move_node(best, corner);
    pin(best, true);
  }
}

void Fitter::find_sides(const Outline& outline) {
  const auto box = bounding_box(outline);
  side_.assign(mesh_.n_nodes(), 1);
  for (int i = 0; i < mesh_.n_nodes(); ++i) {
    const ReferencePoint p = mesh_.point(i);
    if (p.x < box[0].x - same_ || p.x > box[1].x + same_) continue;
    if (p.y < box[0].y - same_ || p.y > box[1].y + same_) continue;
    if (distance(p, nearest_point(outline, p)) <= same_) {
      side_[i] = 0;
      pin(i);
    } else if (is_inside(outline, p)) {
      side_[i] = -1;
    }
  }
}

/// Where the edge from p (on one side) to q (on the other) meets the outline.
ReferencePoint crossing_point(const Outline& outline, ReferencePoint p, ReferencePoint q) {
  constexpr int n_halvings = 60;  // more bits than a double has
  const bool inside = is_inside(outline, p);
  double low = 0;
  double high = 1;
  for (int i = 0; i < n_halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (is_inside(outline, p + middle * (q - p)) == inside ? low : high) = middle;
  }
  return p + high * (q - p);
}

void Fitter::add_snap(const Outline& outline, int node, int other, std::vector<Snap>& snaps) const {
  const ReferencePoint p = mesh_.point(node);
  const ReferencePoint q = mesh_.point(other);
  if (line_of_[node] == is_free) {
    ReferencePoint target = nearest_point(outline, p);
    const auto* polygon = std::get_if<std::vector<ReferencePoint>>(&outline);
    // A corner has its node already.
    const auto is_target = [&](ReferencePoint c) { return distance(c, target) <= same_; };
    if (polygon != nullptr && std::ranges::any_of(*polygon, is_target)) {
      target = crossing_point(outline, p, q);
    }
    snaps.push_back({distance(p, target), node, other, target});
  } else if (line_of_[node] != is_fixed && on_line(q, lines_[line_of_[node]])) {
    const ReferencePoint target = crossing_point(outline, p, q);
    snaps.push_back({distance(p, target), node, other, target});
  }
}

std::vector<Snap> Fitter::crossing_edges(const Outline& outline) const {
  std::vector<Snap> snaps;
  for (int c = 0; c < mesh_.n_cells(); ++c) {
    const auto nodes = mesh_.cell(c);
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = nodes[k];
      const int b = nodes[(k + 1) % 3];
      if (side_[a] * side_[b] >= 0) continue;
      add_snap(outline, a, b, snaps);
      add_snap(outline, b, a, snaps);
    }
  }
  std::ranges::sort(snaps, [](const Snap& a, const Snap& b) {
    return std::tie(a.distance, a.node, a.other) < std::tie(b.distance, b.node, b.other);
  });
  return snaps;
}

void Fitter::fit(const InnerRegion& region) {
  place_corners(region);
  find_sides(region.outline);
  // The shortest moves first: a node that has moved settles all its edges. Moves that flatten a
  // triangle wait, in case the other ends of the edges serve.
  const auto snaps = crossing_edges(region.outline);
  for (const double least : {0.3, 0.1, -1.0}) {
    for (const Snap& snap : snaps) {
      if (side_[snap.node] * side_[snap.other] >= 0) continue;
      const ReferencePoint old = mesh_.point(snap.node);
      mesh_.move_node(snap.node, snap.target);
      if (mesh_.worst_quality(mesh_.cells_around(snap.node)) < least) {
        mesh_.move_node(snap.node, old);
        continue;
      }
      side_[snap.node] = 0;
      pin(snap.node);
    }
  }
  for (int c = 0; c < mesh_.n_cells(); ++c) {
    const auto nodes = mesh_.cell(c);
    const auto [low, high] = std::minmax({side_[nodes[0]], side_[nodes[1]], side_[nodes[2]]});
    if (low < 0 && high > 0) fail(region, "a triangle is cut by the outline");
  }
  fitted_.push_back(&region.outline);
  sides_.push_back(side_);
}

std::vector<int> Fitter::nodes_nearby() const {
  constexpr int n_rings = 3;  // moves are below one spacing; farther triangles are untouched
  std::vector<int> nodes = pinned_;
  for (int ring = 0; ring < n_rings; ++ring) {
    std::vector<int> wider;
    for (int i : nodes) {
      for (int j : mesh_.neighbours(i)) wider.push_back(j);
    }
    std::ranges::sort(wider);
    wider.erase(std::unique(wider.begin(), wider.end()), wider.end());
    nodes = std::move(wider);
  }
  return nodes;
}

/// True if no outline separates the two cells. A triangle with all corners on an outline may have
/// been flattened: it belongs to either side, and its long edge is free to flip.
bool Fitter::on_one_side(int c, int d) const {
  constexpr double flat = 0.3;
  for (std::size_t i = 0; i < fitted_.size(); ++i) {
    const auto side_of_cell = [&](int cell) {
      int sum = 0;
      for (int node : mesh_.cell(cell)) sum += sides_[i][node];
      if (sum != 0 || mesh_.cell_quality(cell) < flat) return sum;
      return is_inside(*fitted_[i], centroid(mesh_, cell)) ? -1 : 1;
    };
    if (side_of_cell(c) * side_of_cell(d) < 0) return false;
  }
  return true;
}

/// Flips edges at a node where the worse of the two triangles becomes better.
void Fitter::flip_around(int node) {
  constexpr double clearly = 1e-6;  // a gain, not rounding: no flipping to and fro
  for (int other : mesh_.neighbours(node)) {
    if (other == node) continue;
    const auto cells = mesh_.cells_with(node, other);
    if (cells.size() != 2) continue;
    const bool kept = std::ranges::any_of(lines_, [&](const KeptLine& line) {
      return on_line(mesh_.point(node), line) && on_line(mesh_.point(other), line);
    });
    if (kept || !on_one_side(cells[0], cells[1])) continue;
    const int c = mesh_.opposite(cells[0], node, other);
    const int d = mesh_.opposite(cells[1], node, other);
    if (!mesh_.cells_with(c, d).empty()) continue;  // that edge exists
    const double before = mesh_.worst_quality(cells);
    mesh_.flip_edge(node, other);
    if (!(mesh_.worst_quality(cells) > before + clearly)) mesh_.flip_edge(c, d);
  }
}

/// Moves a node towards the mean of its neighbours, on an outline along it, if that makes its worst
/// triangle better.
void Fitter::smooth(int node) {
  constexpr std::array<double, 3> steps = {1, 0.5, 0.25};
  const auto cells = mesh_.cells_around(node);
  const auto neighbours = mesh_.neighbours(node);
  const ReferencePoint old = mesh_.point(node);
  Vector2 mean{};
  for (int i : neighbours) mean = mean + (mesh_.point(i) - old);
  mean = (1.0 / static_cast<double>(neighbours.size() - 1)) * mean;
  const double before = mesh_.worst_quality(cells);
  for (const double step : steps) {
    const ReferencePoint target = old + step * mean;
    const int outline = outline_of_[node];
    mesh_.move_node(node, outline < 0 ? target : nearest_point(*fitted_[outline], target));
    if (mesh_.worst_quality(cells) > before) return;
  }
  mesh_.move_node(node, old);
}

/// Takes a node off its outline if its neighbours bridge the gap with a triangle it flattens.
void Fitter::release(int node) {
  constexpr double flat = 0.1;
  const int outline = outline_of_[node];
  if (outline < 0 || mesh_.worst_quality(mesh_.cells_around(node)) > flat) return;
  bool inside = false;
  bool outside = false;
  for (int i : mesh_.neighbours(node)) {
    inside = inside || sides_[outline][i] < 0;
    outside = outside || sides_[outline][i] > 0;
  }
  if (inside == outside) return;
  sides_[outline][node] = inside ? -1 : 1;
  outline_of_[node] = is_fixed;
  line_of_[node] = is_free;
}

void Fitter::improve() {
  constexpr int n_sweeps = 5;
  for (int sweep = 0; sweep < n_sweeps; ++sweep) {
    const std::vector<int> nodes = nodes_nearby();
    for (int i : nodes) release(i);
    for (int i : nodes) flip_around(i);
    for (int i : nodes) {
      if (line_of_[i] == is_free || outline_of_[i] != is_fixed) smooth(i);
    }
  }
}

}  // namespace

ReferencePoint centroid(const Mesh& mesh, int c) {
  const auto nodes = mesh.cell(c);
  const ReferencePoint p = mesh.point(nodes[0]);
  return p + (1.0 / 3) * ((mesh.point(nodes[1]) - p) + (mesh.point(nodes[2]) - p));
}

double coincidence(const Mesh& mesh) {
  constexpr double relative = 1e-9;  // of the size: far above rounding, far below any cell
  double extent = 0;
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    extent = std::max(extent, norm(mesh.point(i) - mesh.point(0)));
  }
  return relative * extent;
}

void conform(Mesh& mesh,
             const std::vector<InnerRegion>& regions,
             std::span<const KeptLine> lines,
             const std::string& advice) {
  Fitter fitter(mesh, lines, advice);
  for (const InnerRegion& region : regions) fitter.fit(region);
  fitter.improve();
}

}  // namespace stylet
