// Points of the reference mesh and of the world, as types that do not mix: in the plane, and in space.
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

/// A direction or a displacement in space (m). One of the plane has z = 0, and the same length.
struct Vector3 {
  double x = 0;
  double y = 0;
  double z = 0;
  friend Vector3 operator+(Vector3 a, Vector3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vector3 operator-(Vector3 a, Vector3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vector3 operator-(Vector3 a) { return {-a.x, -a.y, -a.z}; }
  friend Vector3 operator*(double s, Vector3 a) { return {s * a.x, s * a.y, s * a.z}; }
  friend bool operator==(const Vector3&, const Vector3&) = default;
};

inline Vector3 in_space(Vector2 v) {
  return {v.x, v.y, 0};
}
inline double dot(Vector3 a, Vector3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vector3 cross(Vector3 a, Vector3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(Vector3 a) {
  return std::hypot(std::hypot(a.x, a.y), a.z);
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

/// A point of space in the frame `Frame` (m); one of the plane has z = 0.
template <class Frame>
struct SpacePoint {
  double x = 0;
  double y = 0;
  double z = 0;
  constexpr SpacePoint() = default;
  constexpr SpacePoint(double x_, double y_, double z_ = 0) : x(x_), y(y_), z(z_) {}
  constexpr SpacePoint(Point<Frame> p) : x(p.x), y(p.y) {}  // NOLINT: every plane lies in space
  [[nodiscard]] Point<Frame> in_plane() const { return {x, y}; }
  friend Vector3 operator-(SpacePoint a, SpacePoint b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend SpacePoint operator+(SpacePoint p, Vector3 v) { return {p.x + v.x, p.y + v.y, p.z + v.z}; }
  friend bool operator==(const SpacePoint&, const SpacePoint&) = default;
};

using ReferencePoint = Point<struct ReferenceFrame>;
using WorldPoint = Point<struct WorldFrame>;
using ReferencePlace = SpacePoint<ReferenceFrame>;
using WorldPlace = SpacePoint<WorldFrame>;

template <class Frame>
double distance(Point<Frame> a, Point<Frame> b) {
  return norm(a - b);
}
template <class Frame>
double distance(SpacePoint<Frame> a, SpacePoint<Frame> b) {
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
inline WorldPlace displaced(ReferencePlace x, Vector3 u) {
  return {x.x + u.x, x.y + u.y, x.z + u.z};
}

}  // namespace stylet
