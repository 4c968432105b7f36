// Points of the reference mesh and of the world, as types that do not mix.
#pragma once

#include <cmath>

namespace stylet {

/// A direction or a displacement in the plane (m).
struct Vector2 {
  double x = 0;
  double y = 0;
  friend Vector2 operator+(Vector2 a, Vector2 b) { return {a.x + b.x, a.y + b.y}; }
  friend Vector2 operator-(Vector2 a, Vector2 b) { return {a.x - b.x, a.y - b.y}; }
  friend Vector2 operator-(Vector2 a) { return {-a.x, -a.y}; }
  friend Vector2 operator*(double s, Vector2 a) { return {s * a.x, s * a.y}; }
  friend bool operator==(const Vector2&, const Vector2&) = default;
};

inline double dot(Vector2 a, Vector2 b) {
  return a.x * b.x + a.y * b.y;
}
inline double cross(Vector2 a, Vector2 b) {
  return a.x * b.y - a.y * b.x;
}
inline double norm(Vector2 a) {
  return std::hypot(a.x, a.y);
}

/// A point in the frame `Frame` (m).
template <class Frame>
struct Point {
  double x = 0;
  double y = 0;
  friend Vector2 operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
  friend Point operator+(Point p, Vector2 v) { return {p.x + v.x, p.y + v.y}; }
  friend Point operator-(Point p, Vector2 v) { return {p.x - v.x, p.y - v.y}; }
  friend bool operator==(const Point&, const Point&) = default;
};

using ReferencePoint = Point<struct ReferenceFrame>;
using WorldPoint = Point<struct WorldFrame>;

template <class Frame>
double distance(Point<Frame> a, Point<Frame> b) {
  return norm(a - b);
}

template <class Frame>
Point<Frame> midpoint(Point<Frame> a, Point<Frame> b) {
  return {0.5 * (a.x + b.x), 0.5 * (a.y + b.y)};
}

/// World position of a reference point with displacement u.
inline WorldPoint displaced(ReferencePoint x, Vector2 u) {
  return {x.x + u.x, x.y + u.y};
}

}  // namespace stylet
