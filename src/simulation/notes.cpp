#include "stylet/simulation/notes.hpp"

#include "stylet/petsc/check.hpp"
#include "stylet/simulation/point_text.hpp"

#include <cmath>

namespace stylet {

namespace {

constexpr double most_strain = 0.3;  // small-strain theory is off by about the strain itself

void note_strain(const Simulation& simulation, std::vector<std::string>& notes) {
  const StrainPeak& peak = simulation.largest_strain().widespread;
  if (!(peak.value > most_strain)) return;
  notes.push_back("strain exceeded " + brief(std::round(100 * peak.value)) +
                  " % on a thousandth of the tissue" +
                  (simulation.scene().needles.empty() ? "" : " away from the needle") +
                  ", such as at " + point_text(simulation.scene(), peak.place) +
                  " at t = " + brief(peak.time) +
                  " s; linear elasticity is good for small strain, up to some 10 %");
}

/// A placement error is that of a seed at rest.
void note_motion(const Simulation& simulation, std::vector<std::string>& notes) {
  if (!simulation.done() || simulation.seeds().empty()) return;
  if (simulation.scene().time.until_implanted) return;
  const Needle* needle = simulation.needle();
  if (needle != nullptr && !needle->released()) {
    notes.push_back("needle '" + needle->parameters().name +
                    "' is still in: seeds are where it holds them, not where they come to rest");
    return;
  }
  // A quasi-static step ends at rest, however far it went.
  if (simulation.scene().time.method == TimeMethod::quasi_static) return;
  constexpr double at_rest = 1e-5;  // m/s
  PetscReal speed = 0;
  check(VecNorm(simulation.state().v.get(), NORM_INFINITY, &speed));
  if (speed <= at_rest) return;
  notes.push_back("the tissue still moves, by up to " + brief(1e3 * speed) +
                  " mm/s: seeds are not at rest; end with settle");
}

void note_locking(const Scene& scene, std::vector<std::string>& notes) {
  if (scene.tissue.plane != Plane::strain || scene.tissue.formulation != Formulation::p1) return;
  for (const RegionTissue& region : scene.tissue.regions) {
    if (!locks_in_plane_strain(region.material)) continue;
    notes.push_back("formulation p1 locks in plane strain at Poisson's ratio " +
                    brief(region.material.poisson_ratio) + " (region '" + region.region +
                    "'): forces come out too high; p1_averaged does not lock");
    return;
  }
}

void note_point_tips(const Scene& scene, std::vector<std::string>& notes) {
  for (const NeedleParameters& needle : scene.needles) {
    if (needle.cutting.tip_length > 0) continue;
    notes.push_back("needle '" + needle.name +
                    "' has a point tip (tip_length 0): its answer depends on the mesh");
  }
}

void note_held_corners(const Simulation& simulation, std::vector<std::string>& notes) {
  for (const HeldCorner& corner : simulation.conditions().held_corners()) {
    const Scene& scene = simulation.scene();
    notes.push_back("a support holds " + point_text(scene, simulation.mesh().point(corner.node)) +
                    ", a point of curve '" + scene.prescribed[corner.prescribed].curve +
                    "', which is moved: prescribed has no effect there");
  }
}

}  // namespace

std::vector<std::string> notes_of(const Simulation& simulation) {
  std::vector<std::string> notes;
  note_motion(simulation, notes);
  note_strain(simulation, notes);
  note_locking(simulation.scene(), notes);
  note_point_tips(simulation.scene(), notes);
  note_held_corners(simulation, notes);
  return notes;
}

}  // namespace stylet
