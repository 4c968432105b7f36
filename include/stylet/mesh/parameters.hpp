// Where a mesh comes from.
#pragma once

#include "stylet/geometry/points.hpp"

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace stylet {

/// Which way the squares of a structured grid are cut into triangles.
enum class Diagonals { one_way, alternating };

struct Ellipse {
  ReferencePoint centre;
  double width = 0;   ///< full extent in x (m)
  double height = 0;  ///< full extent in y (m)
};

/// A region inside the rectangle; the triangles conform to its outline.
struct InnerRegion {
  std::string name;
  std::variant<Ellipse, std::vector<ReferencePoint>> outline;
};

/// A named polyline inside the rectangle; it must run along grid edges.
struct InnerCurve {
  std::string name;
  std::vector<ReferencePoint> points;
};

/// Structured triangles on origin + [0, width] x [0, height]. Sides are named left, right, bottom
/// and top; the region outside the inner regions is named `region`.
struct RectangleMesh {
  ReferencePoint origin;
  double width = 0;   ///< m
  double height = 0;  ///< m
  int columns = 0;
  int rows = 0;
  Diagonals diagonals = Diagonals::alternating;
  double jitter = 0;  ///< random shift of inner nodes as a fraction of the spacing, below 0.3
  int seed = 1;       ///< of the jitter
  std::string region = "tissue";
  std::vector<InnerRegion> inner_regions;
  std::vector<InnerCurve> curves;
};

struct Ellipsoid {
  ReferencePlace centre;
  double width = 0;   ///< full extent in x (m)
  double height = 0;  ///< full extent in y (m)
  double depth = 0;   ///< full extent in z (m)
};

/// A region inside the box: the tetrahedra whose centre is in the ellipsoid, so its outline is stepped.
struct SolidRegion {
  std::string name;
  Ellipsoid ellipsoid;
};

/// Structured tetrahedra, six a brick, on origin + [0, width] x [0, height] x [0, depth]. Sides are
/// named left, right (x), bottom, top (y), back and front (z); the region outside the inner regions is
/// named `region`.
struct BoxMesh {
  ReferencePlace origin;
  double width = 0;   ///< m
  double height = 0;  ///< m
  double depth = 0;   ///< m
  int columns = 0;
  int rows = 0;
  int layers = 0;
  double jitter = 0;  ///< random shift of inner nodes as a fraction of the spacing, below 0.3
  int seed = 1;       ///< of the jitter
  std::string region = "tissue";
  std::vector<SolidRegion> inner_regions;
};

struct MeshParameters {
  std::variant<std::string, RectangleMesh, BoxMesh> source;  ///< a Gmsh file, a rectangle or a box
  double scale = 1;  ///< multiplies the coordinates of a file (0.001 for a file in millimetres)
  int refine = 0;    ///< splits every triangle in four, or tetrahedron in eight, this often
};

}  // namespace stylet
