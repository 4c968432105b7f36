#include "stylet/mesh/rectangle.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/geometry/triangle.hpp"
#include "stylet/mesh/conform.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/outline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <random>
#include <utility>

namespace stylet {

namespace {

constexpr const char* source = "rectangle";
const std::vector<std::string> side_names = {"left", "right", "bottom", "top"};

[[noreturn]] void fail(const std::string& message) {
  throw InputError(source + (": " + message));
}

/// A measured value for a message, without its rounding.
std::string brief(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

void check_names(const RectangleMesh& p) {
  std::vector<std::string> regions = {p.region};
  std::vector<std::string> curves = side_names;
  for (const auto& region : p.inner_regions) {
    regions.push_back(region.name);
    curves.push_back(region.name + "_outline");
  }
  for (const auto& curve : p.curves) curves.push_back(curve.name);
  for (auto* names : {&regions, &curves}) {
    std::ranges::sort(*names);
    if (names->front().empty()) fail("a region or a curve has no name");
    const auto twice = std::ranges::adjacent_find(*names);
    if (twice != names->end()) {
      fail("the name '" + *twice + "' is given twice; each region and each curve needs its own " +
           "(curves in use: " + join(curves) + ")");
    }
  }
}

void check(const RectangleMesh& p) {
  constexpr double most_jitter = 0.3;  // two neighbours may approach by 0.6 of the spacing
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (!positive(p.width)) fail("width = " + exact(p.width) + "; allowed: above 0 m");
  if (!positive(p.height)) fail("height = " + exact(p.height) + "; allowed: above 0 m");
  if (p.columns < 1) fail("columns = " + std::to_string(p.columns) + "; allowed: 1 or more");
  if (p.rows < 1) fail("rows = " + std::to_string(p.rows) + "; allowed: 1 or more");
  if (6 * std::int64_t{p.columns} * p.rows > std::numeric_limits<int>::max()) {
    fail(std::to_string(p.columns) + " columns and " + std::to_string(p.rows) +
         " rows make too many triangles");
  }
  if (!(p.jitter >= 0 && p.jitter < most_jitter)) {
    fail("jitter = " + exact(p.jitter) + "; allowed: 0 or more, below " + exact(most_jitter));
  }
  check_names(p);
  for (const auto& region : p.inner_regions) {
    const std::string who = std::string(source) + ": region '" + region.name + "'";
    check_outline(region.outline, who);
    const auto [low, high] = bounding_box(region.outline);
    const double same = 1e-9 * (p.width + p.height);
    if (low.x < p.origin.x - same || high.x > p.origin.x + p.width + same ||
        low.y < p.origin.y - same || high.y > p.origin.y + p.height + same) {
      throw InputError(who + " reaches out of the rectangle; allowed: inside it");
    }
  }
  for (const auto& curve : p.curves) {
    if (curve.points.size() < 2) fail("curve '" + curve.name + "' needs two points or more");
  }
}

std::string advice(const RectangleMesh& p) {
  constexpr double clearly = 1.2;  // below this the squares are near enough to square
  const double dx = p.width / p.columns;
  const double dy = p.height / p.rows;
  const std::string columns = "columns (now " + std::to_string(p.columns) + ")";
  const std::string rows = "rows (now " + std::to_string(p.rows) + ")";
  std::string text = "the grid is too coarse: raise ";
  text += dx > clearly * dy ? columns : dy > clearly * dx ? rows : columns + " and " + rows;
  return p.jitter > 0 ? text + ", or lower jitter" : text;
}

MeshData make_grid(const RectangleMesh& p) {
  MeshData mesh;
  mesh.source = source;
  for (int j = 0; j <= p.rows; ++j) {
    for (int i = 0; i <= p.columns; ++i) {
      mesh.coordinates.push_back(p.origin.x + p.width * i / p.columns);
      mesh.coordinates.push_back(p.origin.y + p.height * j / p.rows);
    }
  }
  const int stride = p.columns + 1;
  for (int j = 0; j < p.rows; ++j) {
    for (int i = 0; i < p.columns; ++i) {
      const int a = j * stride + i;
      const int b = a + 1;
      const int c = b + stride;
      const int d = a + stride;
      const bool rising = p.diagonals == Diagonals::one_way || (i + j) % 2 == 0;
      if (rising) {
        mesh.cells.insert(mesh.cells.end(), {a, b, c, a, c, d});
      } else {
        mesh.cells.insert(mesh.cells.end(), {a, b, d, b, c, d});
      }
    }
  }
  mesh.region_names = {p.region};
  mesh.cell_region.assign(mesh.n_cells(), 0);
  mesh.curve_names = side_names;
  const auto add_facet = [&mesh](int a, int b, int side) {
    mesh.facets.insert(mesh.facets.end(), {a, b});
    mesh.facet_curve.push_back(side);
  };
  for (int j = 0; j < p.rows; ++j) add_facet((j + 1) * stride, j * stride, 0);
  for (int j = 1; j <= p.rows; ++j) add_facet(j * stride - 1, (j + 1) * stride - 1, 1);
  for (int i = 0; i < p.columns; ++i) add_facet(i, i + 1, 2);
  for (int i = 0; i < p.columns; ++i) {
    add_facet(p.rows * stride + i + 1, p.rows * stride + i, 3);
  }
  return mesh;
}

std::vector<KeptLine> kept_lines(const RectangleMesh& p) {
  const ReferencePoint a = p.origin;
  const ReferencePoint b = a + Vector2{p.width, 0};
  const ReferencePoint c = a + Vector2{p.width, p.height};
  const ReferencePoint d = a + Vector2{0, p.height};
  std::vector<KeptLine> lines = {{a, b}, {b, c}, {c, d}, {d, a}};
  for (const auto& curve : p.curves) {
    for (std::size_t i = 1; i < curve.points.size(); ++i) {
      lines.push_back({curve.points[i - 1], curve.points[i]});
    }
  }
  return lines;
}

void shake(Mesh& mesh, const RectangleMesh& p, const std::vector<KeptLine>& lines) {
  if (p.jitter == 0) return;
  const double same = coincidence(mesh);
  std::mt19937 random(static_cast<std::uint32_t>(p.seed));
  // std::uniform_real_distribution differs between libraries; this does not.
  const auto uniform = [&random] { return 2 * (static_cast<double>(random()) * 0x1p-32) - 1; };
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    const double dx = uniform() * p.jitter * p.width / p.columns;
    const double dy = uniform() * p.jitter * p.height / p.rows;
    const ReferencePoint x = mesh.point(i);
    const bool kept = std::ranges::any_of(lines, [&](const KeptLine& line) {
      return distance(x, nearest_on_segment(line.a, line.b, x)) <= same;
    });
    const bool on_outline = std::ranges::any_of(p.inner_regions, [&](const InnerRegion& region) {
      return distance(x, nearest_point(region.outline, x)) <= same;
    });
    if (!kept && !on_outline) mesh.move_node(i, x + Vector2{dx, dy});
  }
}

/// Gives the cells inside the outline to the region, and its rim the name `<region>_outline`.
void add_region(const Mesh& mesh,
                const InnerRegion& region,
                const std::string& hint,
                MeshData& data) {
  constexpr double allowed = 0.03;  // of the area; the chords of ten nodes on a circle lose 6 %
  const int index = static_cast<int>(data.region_names.size());
  const int curve = static_cast<int>(data.curve_names.size());
  data.region_names.push_back(region.name);
  data.curve_names.push_back(region.name + "_outline");
  std::vector<bool> inside(mesh.n_cells());
  double area = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    inside[c] = is_inside(region.outline, centroid(mesh, c));
    if (!inside[c]) continue;
    area += mesh.cell_measure(c);
    data.cell_region[c] = index;
  }
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto nodes = mesh.cell(c);
    for (std::size_t k = 0; inside[c] && k < 3; ++k) {
      const auto other = mesh.across(c, nodes[k], nodes[(k + 1) % 3]);
      if (other && inside[*other]) continue;
      data.facets.insert(data.facets.end(), {nodes[k], nodes[(k + 1) % 3]});
      data.facet_curve.push_back(curve);
    }
  }
  const double wanted = enclosed_area(region.outline);
  if (std::abs(area - wanted) <= allowed * wanted) return;
  fail("region '" + region.name + "' covers " + brief(area) + " m2 instead of " + brief(wanted) +
       "; allowed: 3 % apart; " + hint);
}

void add_curve(const Mesh& mesh, const InnerCurve& curve, MeshData& data) {
  constexpr double gap = 1e-6;  // of the length: less than any missing edge
  const double same = coincidence(mesh);
  const auto on_curve = [&](ReferencePoint p) {
    for (std::size_t i = 1; i < curve.points.size(); ++i) {
      const auto q = nearest_on_segment(curve.points[i - 1], curve.points[i], p);
      if (distance(p, q) <= same) return true;
    }
    return false;
  };
  std::vector<bool> marked(mesh.n_nodes());
  for (int i = 0; i < mesh.n_nodes(); ++i) marked[i] = on_curve(mesh.point(i));
  std::vector<std::pair<int, int>> edges;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto nodes = mesh.cell(c);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(nodes[k], nodes[(k + 1) % 3]);
      // The middle too: both ends of a diagonal may lie on a curve that turns a corner.
      if (!marked[a] || !marked[b] || !on_curve(midpoint(mesh.point(a), mesh.point(b)))) continue;
      edges.emplace_back(a, b);
    }
  }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  double covered = 0;
  double length = 0;
  for (const auto& [a, b] : edges) {
    covered += distance(mesh.point(a), mesh.point(b));
    data.facets.insert(data.facets.end(), {a, b});
    data.facet_curve.push_back(static_cast<int>(data.curve_names.size()));
  }
  for (std::size_t i = 1; i < curve.points.size(); ++i) {
    length += distance(curve.points[i - 1], curve.points[i]);
  }
  if (!(std::abs(covered - length) <= gap * length) || length == 0) {
    fail("curve '" + curve.name + "': triangle edges cover " + brief(covered) + " m of its " +
         brief(length) + " m; it must run along grid lines, inside the rectangle, each piece once");
  }
  data.curve_names.push_back(curve.name);
}

void check_quality(const Mesh& mesh, const std::string& hint) {
  constexpr double least = 0.1;  // flatter triangles spoil the condition of the stiffness matrix
  for (int c = 0; c < mesh.n_cells(); ++c) {
    if (mesh.cell_quality(c) > least) continue;
    const ReferencePoint p = mesh.point(mesh.cell(c)[0]);
    fail("the triangle at (" + brief(p.x) + ", " + brief(p.y) + ") m has quality " +
         brief(mesh.cell_quality(c)) + "; allowed: above " + brief(least) + "; " + hint);
  }
}

}  // namespace

MeshData make_rectangle(const RectangleMesh& parameters) {
  check(parameters);
  const std::string hint = advice(parameters);
  const auto lines = kept_lines(parameters);
  Mesh mesh(make_grid(parameters));
  shake(mesh, parameters, lines);
  if (!parameters.inner_regions.empty()) conform(mesh, parameters.inner_regions, lines, hint);
  check_quality(mesh, hint);
  MeshData data = mesh.data();
  for (const auto& region : parameters.inner_regions) add_region(mesh, region, hint, data);
  for (const auto& curve : parameters.curves) add_curve(mesh, curve, data);
  return data;
}

}  // namespace stylet
