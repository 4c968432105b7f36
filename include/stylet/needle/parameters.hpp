// What a needle does and how tissue resists it.
#pragma once

#include "stylet/base/archive.hpp"
#include "stylet/geometry/components.hpp"
#include "stylet/geometry/points.hpp"

#include <optional>
#include <string>
#include <vector>

namespace stylet {

/// consistent: the tip advances, inside the step, just as far as brings its force back to the
/// threshold. lagged: one solve a step, the advance follows one step later. increment: the paper's
/// fixed length b whenever the force of the last step reached the threshold.
enum class CuttingLaw { consistent, lagged, increment };

struct CuttingParameters {
  CuttingLaw law = CuttingLaw::consistent;
  double cutting_force = 0;    ///< N, of a needle of sharpness 1
  double sharpness = 1;        ///< in (0, 1]; threshold = cutting_force / sharpness
  double stiffness_share = 0;  ///< share of the cutting force that scales with E / reference
  double reference_youngs_modulus = 0;  ///< Pa; of stiffness_share
  double tip_length = 0;                ///< m; 0 is the paper's point tip
  double increment = 0;                 ///< m; b of the increment law
};

/// The law finds the advance within the step.
[[nodiscard]] inline bool searches(const CuttingParameters& cutting) {
  return cutting.law == CuttingLaw::consistent;
}

/// Per metre of reference path, therefore independent of the mesh.
struct FrictionParameters {
  double static_force = 0;         ///< N/m
  double kinetic_force = 0;        ///< N/m
  double stick_speed = 0;          ///< m/s; a slower sliding node sticks again
  double slip_speed = 0;           ///< m/s; above it a node slides; > stick_speed
  double viscous_coefficient = 0;  ///< N s/m^2; adds to kinetic_force by the speed of sliding
};

/// A closed polygon in the reference frame, given by its vertices or as the boundary of a region; in space a
/// closed surface, named or the boundary of a region.
struct MembraneParameters {
  std::string region;                   ///< empty if the polygon or the surface is given
  std::string surface;                  ///< in space
  std::vector<ReferencePoint> polygon;  ///< vertices, filled in from the region before use
  double puncture_force = 0;            ///< N
};

enum class ActionKind { insert, hold, implant, retract, settle };

/// insert: to `depth` behind the skin or to `position`; retract: likewise, default all the way out.
struct Action {
  ActionKind kind = ActionKind::hold;
  double speed = 0;                ///< m/s; insert, retract
  std::optional<double> depth;     ///< m behind the entry point in the world; insert, retract
  std::optional<double> position;  ///< m; tip's coordinate along the axis in the world
  std::optional<double> duration;  ///< s; hold, settle
  double speed_tolerance = 1e-9;   ///< m/s; settle ends when every node is slower
  std::string target;              ///< implant: name of the target of this seed
};

/// Of a needle in space: its axis, and how it is split into what the mesh carries and what is added in closed
/// form (embedded_track.hpp).
struct SpaceParameters {
  std::optional<Components> entry;      ///< m; a point of the axis on the skin, or in front of it
  std::optional<Components> target;     ///< m; another point of the axis, or
  std::optional<Components> direction;  ///< of insertion, of any length
  double kernel_radius = 0;             ///< m
  double segment = 0.5e-3;              ///< m; length of a piece of the track
};

struct NeedleParameters {
  std::string name;
  double height = 0;          ///< m; coordinate of the axis across the needle, in the plane
  double diameter = 1.27e-3;  ///< m; an 18 gauge needle
  SpaceParameters space;
  CuttingParameters cutting;
  std::optional<FrictionParameters> friction;
  std::vector<Action> motion;
};

void archive(Archive& archive, CuttingParameters& parameters);
void archive(Archive& archive, NeedleParameters& parameters);

}  // namespace stylet
