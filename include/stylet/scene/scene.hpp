// What was asked: the scene after parsing and checking, in SI units.
#pragma once

#include "stylet/dynamics/parameters.hpp"
#include "stylet/fem/parameters.hpp"
#include "stylet/geometry/components.hpp"
#include "stylet/mesh/parameters.hpp"
#include "stylet/needle/parameters.hpp"
#include "stylet/scene/document.hpp"
#include "stylet/scene/procedure.hpp"

#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

enum class SupportKind { fixed, roller, free };

/// A named boundary (a curve, or a surface in space) and how it is held. roller: no displacement along
/// the outward normal.
struct Support {
  std::string curve;
  SupportKind kind = SupportKind::free;
};

/// Force per volume (N/m^3) from `start` on.
struct BodyForce {
  Components force;
  double start = 0;  ///< s
};

/// Force per metre of a named curve (N/m), or per area of a named surface (Pa), from `start` on.
struct Traction {
  std::string curve;
  Components force;
  double start = 0;  ///< s
};

/// A named curve or surface moved by a given displacement; a component that is not given stays free.
/// Reached
/// linearly over `ramp` after `start`.
struct PrescribedCurve {
  std::string curve;
  std::vector<std::optional<double>> displacement;  ///< m; as many as there are dimensions
  double start = 0;                                 ///< s
  double ramp = 0;                                  ///< s; 0: at once
};

[[nodiscard]] inline bool moves(const PrescribedCurve& p) {
  for (const auto& component : p.displacement) {
    if (component.value_or(0) != 0) return true;
  }
  return false;
}

struct Target {
  std::string name;
  Components point;
};

/// Distance of a place from a target (m).
template <class Frame>
[[nodiscard]] double distance(SpacePoint<Frame> x, const Target& target) {
  const ReferencePlace to = target.point.place();
  return norm(Vector3{x.x - to.x, x.y - to.y, x.z - to.z});
}

/// A picture of the tissue before anything moves.
struct ImageParameters {
  std::string file;  ///< PNG or JPEG; empty: made like ultrasound, from regions and membrane
  std::optional<ReferencePoint> origin;  ///< of a file: its lower left corner
  std::optional<Vector2> size;           ///< of a file (m)
  int seed = 1;                          ///< of the speckle that is made
  double attenuation = 8;  ///< of the echo from the lower edge, where the probe is (1/m)
  double shadow = 0.5;     ///< share of the echo that is lost behind the needle
};

/// What a hand did, recorded.
struct ProcedureParameters {
  std::string file;
  std::vector<ProcedureRow> rows;  ///< filled in from the file before use
};

struct Probe {
  std::string name;
  Components point;
};

/// When a run writes what it can go on from, beside when it is stopped.
struct CheckpointParameters {
  std::optional<int> steps;         ///< of the clock between two
  std::optional<double> wall_time;  ///< s between two
  int keep = 2;                     ///< the newest so many
  bool at_end = false;              ///< one more when the run is done
};

struct OutputParameters {
  std::string directory;                           ///< may be overridden by --output
  bool history = true;                             ///< history.csv
  std::optional<double> snapshots;                 ///< s between snapshots; none: no snapshots.h5
  std::optional<CheckpointParameters> checkpoint;  ///< none: where the run is stopped only
};

/// A number of summary.json (path with dots) and the range it must lie in.
struct Expectation {
  std::string quantity;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// The tissue in which a scene begins.
struct StartParameters {
  std::string from;  ///< checkpoint, relative to the folder of the scene
};

/// Of the plane, or of space: without tissue.plane.
struct Scene {
  [[nodiscard]] int dim() const { return tissue.dim(); }
  /// What its mesh is made of, in words and keys.
  [[nodiscard]] std::string cells() const { return dim() == 2 ? "triangles" : "tetrahedra"; }

  std::string file;  ///< for messages; paths in the scene are relative to its folder
  MeshParameters mesh;
  TissueParameters tissue;
  std::vector<Support> supports;
  std::vector<BodyForce> body_forces;
  std::vector<Traction> tractions;
  std::vector<PrescribedCurve> prescribed;
  /// Of the direction in which all needles advance, counter-clockwise from +x (rad).
  double needle_angle = std::numbers::pi;
  std::vector<NeedleParameters> needles;
  std::optional<MembraneParameters> membrane;
  std::vector<Target> targets;
  std::vector<Probe> probes;
  TimeParameters time;
  OutputParameters output;
  std::vector<Expectation> expect;
  std::optional<ProcedureParameters> procedure;  ///< instead of needles
  std::optional<ImageParameters> image;
  std::optional<StartParameters> start;  ///< none: tissue at rest
  Node
      document;  ///< as it was read, for the places in messages; empty if the scene was made in code
};

}  // namespace stylet
