// What is known of the needles' ways before the run: entries, stops, what they lead through.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/advance.hpp"
#include "stylet/scene/scene.hpp"
#include "stylet/simulation/conditions.hpp"

#include <string>
#include <vector>

namespace stylet {

/// A piece of the way within one region: depths behind the entry point (m).
struct PathPiece {
  std::string region;
  double from = 0;
  double to = 0;
};

struct NeedlePath {
  Entry entry;  ///< in the plane
  ReferencePlace skin_point;
  Vector3 direction;   ///< of the advance
  double skin = 0;     ///< along coordinate of the entry point (m); in space 0
  double deepest = 0;  ///< of all stops, behind the entry point (m)
  double end = 0;      ///< where the axis leaves the tissue again, behind the entry point (m)
  std::vector<PathPiece> pieces;  ///< from the skin to the deepest stop, in the undeformed tissue
};

[[nodiscard]] NeedlePath find_path(const Scene& scene, const Mesh& mesh, std::size_t needle);

/// Along coordinate of the entry point (m).
[[nodiscard]] double skin_of(const Mesh& mesh, const NeedleParameters& needle);

/// Depths (m) at which a closed polygon crosses the way, up to the deepest stop.
[[nodiscard]] std::vector<double> crossings(const NeedlePath& path,
                                            double height,
                                            std::span<const ReferencePoint> polygon);

/// True if the skin is where the mesh has it when this needle enters: nothing moved it before.
[[nodiscard]] bool skin_is_at_rest(const Scene& scene, std::size_t needle);

/// Throws InputError for needles that go backwards, implant outside the tissue, leave it, or meet a
/// curve that is held or moved.
void check_needles(const Scene& scene, const Mesh& mesh, const Conditions& conditions);

/// Which of these nodes a support holds or a prescribed curve moves, and on which curves they lie, for a
/// step that failed there; empty if there is none.
[[nodiscard]] std::string held_points_text(const Scene& scene,
                                           const Mesh& mesh,
                                           std::span<const PrescribedDof> held,
                                           std::span<const int> nodes);

}  // namespace stylet
