// What was asked: the scene after parsing and checking, in SI units.
#pragma once

#include "stylet/dynamics/parameters.hpp"
#include "stylet/fem/parameters.hpp"
#include "stylet/geometry/points.hpp"
#include "stylet/mesh/parameters.hpp"
#include "stylet/needle/parameters.hpp"
#include "stylet/scene/document.hpp"
#include "stylet/scene/procedure.hpp"

#include <array>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

enum class SupportKind { fixed, roller, free };

/// A named boundary and how it is held. roller: no displacement along the outward normal.
struct Support {
  std::string curve;
  SupportKind kind = SupportKind::free;
};

/// Force per volume (N/m^3) from `start` on.
struct BodyForce {
  Vector2 force;
  double start = 0;  ///< s
};

/// Force per metre of a named curve (N/m) from `start` on.
struct Traction {
  std::string curve;
  Vector2 force;
  double start = 0;  ///< s
};

/// A named curve moved by a given displacement; a component that is not given stays free. Reached
/// linearly over `ramp` after `start`.
struct PrescribedCurve {
  std::string curve;
  std::array<std::optional<double>, 2> displacement;  ///< m
  double start = 0;                                   ///< s
  double ramp = 0;                                    ///< s; 0: at once
};

struct Target {
  std::string name;
  ReferencePoint point;
};

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
  ReferencePoint point;
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

struct Scene {
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
