#include "stylet/mesh/outline.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/geometry/triangle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stylet {

namespace {

using Polygon = std::vector<ReferencePoint>;

bool is_inside_ellipse(const Ellipse& e, ReferencePoint p) {
  const double x = 2 * (p.x - e.centre.x) / e.width;
  const double y = 2 * (p.y - e.centre.y) / e.height;
  return x * x + y * y < 1;
}

/// Fixed-point iteration on the centre of curvature: the ellipse is replaced by its circle of
/// curvature at the present guess (cos, sin), which gives the next one.
ReferencePoint nearest_on_ellipse(const Ellipse& e, ReferencePoint p) {
  constexpr int n_steps = 12;  // converged to rounding after about five, also for thin ellipses
  const double a = 0.5 * e.width;
  const double b = 0.5 * e.height;
  const double px = std::abs(p.x - e.centre.x);
  const double py = std::abs(p.y - e.centre.y);
  double tx = std::sqrt(0.5);
  double ty = std::sqrt(0.5);
  for (int i = 0; i < n_steps; ++i) {
    const Vector2 centre{(a * a - b * b) * tx * tx * tx / a, (b * b - a * a) * ty * ty * ty / b};
    const double radius = norm(Vector2{a * tx, b * ty} - centre);
    const Vector2 towards = Vector2{px, py} - centre;
    const double length = norm(towards);
    if (length == 0) break;
    tx = std::clamp((towards.x * radius / length + centre.x) / a, 0.0, 1.0);
    ty = std::clamp((towards.y * radius / length + centre.y) / b, 0.0, 1.0);
    const double unit = std::hypot(tx, ty);
    tx /= unit;
    ty /= unit;
  }
  return {e.centre.x + std::copysign(a * tx, p.x - e.centre.x),
          e.centre.y + std::copysign(b * ty, p.y - e.centre.y)};
}

ReferencePoint nearest_on_polygon(const Polygon& polygon, ReferencePoint p) {
  ReferencePoint best = polygon.front();
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto q = nearest_on_segment(polygon[i], polygon[(i + 1) % polygon.size()], p);
    if (distance(p, q) >= shortest) continue;
    shortest = distance(p, q);
    best = q;
  }
  return best;
}

bool segments_cross(ReferencePoint a, ReferencePoint b, ReferencePoint c, ReferencePoint d) {
  const auto hit = ray_segment(a, b - a, c, d);
  return hit && hit->s >= 0 && hit->s <= 1 && hit->fraction >= 0 && hit->fraction <= 1;
}

void check_polygon(const Polygon& polygon, const std::string& who) {
  const std::size_t n = polygon.size();
  if (n < 3) {
    throw InputError(who + " has " + std::to_string(n) + " points; allowed: 3 or more");
  }
  for (std::size_t i = 0; i < n; ++i) {
    const auto a = polygon[i];
    const auto b = polygon[(i + 1) % n];
    if (!std::isfinite(a.x) || !std::isfinite(a.y)) {
      throw InputError(who + ": point " + std::to_string(i + 1) + " is not finite");
    }
    if (a == b) {
      throw InputError(who + ": points " + std::to_string(i + 1) + " and " +
                       std::to_string((i + 1) % n + 1) +
                       " are equal; the polygon closes by itself, each corner stands once");
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const auto a = polygon[i];
    const auto b = polygon[(i + 1) % n];
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;  // neighbours through the closing edge
      if (!segments_cross(a, b, polygon[j], polygon[(j + 1) % n])) continue;
      throw InputError(who + " crosses itself: edges " + std::to_string(i + 1) + " and " +
                       std::to_string(j + 1));
    }
  }
}

}  // namespace

ReferencePoint nearest_on_segment(ReferencePoint a, ReferencePoint b, ReferencePoint p) {
  const Vector2 edge = b - a;
  const double squared = dot(edge, edge);
  if (squared == 0) return a;
  const double s = dot(p - a, edge) / squared;
  if (s <= 0) return a;
  if (s >= 1) return b;
  return a + s * edge;
}

bool is_inside(const Outline& outline, ReferencePoint p) {
  if (const auto* ellipse = std::get_if<Ellipse>(&outline)) return is_inside_ellipse(*ellipse, p);
  return inside_polygon(std::span<const ReferencePoint>(std::get<Polygon>(outline)), p);
}

ReferencePoint nearest_point(const Outline& outline, ReferencePoint p) {
  if (const auto* ellipse = std::get_if<Ellipse>(&outline)) return nearest_on_ellipse(*ellipse, p);
  return nearest_on_polygon(std::get<Polygon>(outline), p);
}

double enclosed_area(const Outline& outline) {
  if (const auto* ellipse = std::get_if<Ellipse>(&outline)) {
    return std::acos(-1.0) / 4 * ellipse->width * ellipse->height;
  }
  const auto& polygon = std::get<Polygon>(outline);
  double area = 0;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    area += signed_area(polygon[0], polygon[i], polygon[i + 1]);
  }
  return std::abs(area);
}

std::array<ReferencePoint, 2> bounding_box(const Outline& outline) {
  if (const auto* e = std::get_if<Ellipse>(&outline)) {
    const Vector2 half{0.5 * e->width, 0.5 * e->height};
    return {e->centre - half, e->centre + half};
  }
  const auto& polygon = std::get<Polygon>(outline);
  std::array<ReferencePoint, 2> box = {polygon.front(), polygon.front()};
  for (const auto& p : polygon) {
    box[0] = {std::min(box[0].x, p.x), std::min(box[0].y, p.y)};
    box[1] = {std::max(box[1].x, p.x), std::max(box[1].y, p.y)};
  }
  return box;
}

void check_outline(const Outline& outline, const std::string& who) {
  if (const auto* e = std::get_if<Ellipse>(&outline)) {
    const bool positive = std::isfinite(e->width) && std::isfinite(e->height) && e->width > 0 &&
                          e->height > 0 && std::isfinite(e->centre.x) && std::isfinite(e->centre.y);
    if (positive) return;
    throw InputError(who + ": ellipse of " + exact(e->width) + " x " + exact(e->height) +
                     " m; allowed: width and height above 0");
  }
  check_polygon(std::get<Polygon>(outline), who);
}

}  // namespace stylet
