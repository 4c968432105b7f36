#include "stylet/simulation/notes.hpp"

#include "stylet/petsc/check.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/simulation/space_way.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace stylet {

namespace {

constexpr double most_strain = 0.3;  // small-strain theory is off by about the strain itself

void note_strain(const Simulation& simulation, std::vector<std::string>& notes) {
  const StrainPeak& peak = simulation.largest_strain().widespread;
  if (!(peak.value > most_strain)) return;
  notes.push_back("strain exceeded " + brief(std::round(100 * peak.value)) +
                  " % on a thousandth of the tissue" +
                  (simulation.pierces() ? " away from the needle" : "") + ", such as at " +
                  point_text(simulation.scene(), peak.place) + " at t = " + brief(peak.time) +
                  " s; linear elasticity is good for small strain, up to some 10 %");
}

std::string rough(double value) {
  char text[20];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// Such triangles are no large error of small-strain theory but its end: no tissue can be there.
void note_turned_over(const Simulation& simulation, std::vector<std::string>& notes) {
  const TurnedOver& most = simulation.turned_over();
  if (most.triangles == 0) return;
  const Mesh& mesh = simulation.mesh();
  double area = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) area += mesh.cell_measure(c);
  std::string doubtful;
  for (const Seed& seed : simulation.seeds()) {
    if (seed.turned_over == 0) continue;
    doubtful += (doubtful.empty() ? "" : ", ") + ("needle '" + seed.needle + "'") +
                (seed.target.empty() ? "" : " for '" + seed.target + "'");
  }
  const std::string cells = simulation.scene().cells();
  notes.push_back("beyond small strain: " + std::to_string(most.triangles) +
                  (most.triangles == 1 ? " of the " + cells + " was" : " " + cells + " were") +
                  " turned over by the deformation at t = " + brief(most.time) + " s, " +
                  rough(100 * most.area / area) + " % of the tissue, such as at " +
                  point_text(simulation.scene(), most.place) +
                  "; forces since t = " + brief(most.first) + " s cannot be trusted" +
                  (doubtful.empty() ? "" : ", nor can the seeds of " + doubtful));
}

/// A placement error is that of a seed at rest.
void note_motion(const Simulation& simulation, std::vector<std::string>& notes) {
  if (!simulation.done() || simulation.seeds().empty()) return;
  if (simulation.scene().time.until_implanted) return;
  const Needle* needle = simulation.needle();
  if (needle != nullptr && !needle->released()) {
    notes.push_back(
        "needle '" + needle->parameters().name +
        (hides_places(simulation.scene())
             ? "' is still in: the mesh's displacement is smoothed around it, so where seeds are "
               "is not told; they "
               "come to rest after a retract all the way out"
             : "' is still in: seeds are where it holds them, not where they come to rest"));
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
  if (scene.tissue.plane == Plane::stress || scene.tissue.formulation != Formulation::p1) return;
  for (const RegionTissue& region : scene.tissue.regions) {
    if (!locks(region.material)) continue;
    notes.push_back(std::string("formulation p1 locks in ") +
                    (scene.dim() == 2 ? "plane strain" : "space") + " at Poisson's ratio " +
                    brief(region.material.poisson_ratio) + " (region '" + region.region +
                    "'): forces come out too high; p1_averaged does not lock");
    return;
  }
}

/// Of the scene, of a recorded procedure, or those that a hand has let in.
std::vector<NeedleParameters> needles_of(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  if (!scene.procedure) return simulation.is_live() ? simulation.entered() : scene.needles;
  std::vector<NeedleParameters> needles;
  for (const ProcedureRow& row : scene.procedure->rows) {
    if (row.kind == ProcedureRow::Kind::enter) needles.push_back(row.needle);
  }
  return needles;
}

void note_point_tips(const Simulation& simulation, std::vector<std::string>& notes) {
  for (const NeedleParameters& needle : needles_of(simulation)) {
    if (needle.cutting.tip_length > 0) continue;
    notes.push_back("needle '" + needle.name +
                    "' has a point tip (tip_length 0): its answer depends on the mesh");
  }
}

/// True once nothing is to be expected of a needle: a hand may push it on.
bool has_acted(const Simulation& simulation, const Pushing& pushing) {
  return simulation.done() || pushing.needle != simulation.needle()->parameters().name ||
         std::ranges::find(simulation.seeds(), pushing.needle, &Seed::needle) !=
             simulation.seeds().end();
}

/// Hands may be as short as a step; scenes with needles are refused where that is so.
void note_few_steps(const Simulation& simulation, std::vector<std::string>& notes) {
  const Scene& scene = simulation.scene();
  const bool is_known = scene.procedure.has_value();
  for (const Pushing& pushing : is_known ? pushings_of(scene) : simulation.pushings()) {
    if (pushing.duration == 0 || (!is_known && !has_acted(simulation, pushing))) continue;
    if (scene.time.step <= pushing.duration / fewest_steps * (1 + 1e-9)) continue;
    notes.push_back("needle '" + pushing.needle + "' is pushed in " + brief(pushing.duration) +
                    " s, fewer than four steps of time.step, " + brief(scene.time.step) +
                    " s: its answer depends on them");
  }
}

/// A hand hears of what it does at the end of a step.
void note_long_ways(const Simulation& simulation, std::vector<std::string>& notes) {
  for (std::size_t i = 0; i < simulation.pushings().size(); ++i) {
    const Pushing& pushing = simulation.pushings()[i];
    const double most = longest_way(simulation.mesh(), simulation.entered()[i]);
    if (!(pushing.furthest > most * (1 + 1e-9))) continue;
    notes.push_back("needle '" + pushing.needle + "' went up to " + brief(1e3 * pushing.furthest) +
                    " mm in a step of time.step, " + brief(simulation.scene().time.step) +
                    " s, further than " + brief(1e3 * most) +
                    " mm, its tip_length, or the length of an element if that is 0: what a hand "
                    "would have felt on the way, such as a membrane that breaks, is not seen; a "
                    "smaller time.step or slower pushes");
  }
}

// Measured on one mesh with increments of 0.02 to 2 mm and steps of 0.5 to 20 ms: 3.5 to 5.5 mm, where
// the consistent law gives 5.2.
void note_increments(const Simulation& simulation, std::vector<std::string>& notes) {
  for (const NeedleParameters& needle : needles_of(simulation)) {
    if (needle.cutting.law != CuttingLaw::increment) continue;
    notes.push_back("needle '" + needle.name +
                    "' cuts by increments: between cuts its tip force falls below the cutting "
                    "force, so its answer depends on increment and time.step; cutting.law "
                    "consistent does not");
  }
}

/// The end of a run with needles is not known before, so a late load is not refused.
void note_late(const Simulation& simulation, std::vector<std::string>& notes) {
  if (!simulation.done()) return;
  const Scene& scene = simulation.scene();
  const double end = simulation.time();
  const auto note = [&](bool acts, double start, const std::string& list, std::size_t i) {
    if (!acts || start <= end) return;
    notes.push_back(list + "." + std::to_string(i) + " begins at t = " + brief(start) +
                    " s, after the end of the run at " + brief(end) + " s: it has never acted");
  };
  for (std::size_t i = 0; i < scene.body_forces.size(); ++i) {
    const BodyForce& body = scene.body_forces[i];
    note(norm(body.force.vector()) != 0, body.start, "loads.body", i);
  }
  for (std::size_t i = 0; i < scene.tractions.size(); ++i) {
    const Traction& traction = scene.tractions[i];
    note(norm(traction.force.vector()) != 0, traction.start, "loads.traction", i);
  }
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i) {
    const PrescribedCurve& p = scene.prescribed[i];
    note(moves(p), p.start, "prescribed", i);
  }
}

// What a concentrated force of the tip would move itself, in metres per newton and logarithm of its
// width: Kelvin's solution in the plane (Timoshenko and Goodier, Theory of Elasticity, art. 42).
double kelvin(const Scene& scene, const LinearElastic& material) {
  const double nu = material.poisson_ratio;
  const double shear = material.youngs_modulus / (2 * (1 + nu));
  const double kappa = scene.tissue.plane == Plane::strain ? 3 - 4 * nu : (3 - nu) / (1 + nu);
  return kappa / (2 * std::numbers::pi * shear * (kappa + 1) * scene.tissue.thickness);
}

std::string seed_text(const Seed& seed) {
  return "needle '" + seed.needle + "' left the seed" +
         (seed.target.empty() ? "" : " for '" + seed.target + "'");
}

// The increment law cuts a length once a step, however much more force there is.
void note_excess(const Simulation& simulation, std::vector<std::string>& notes) {
  const RunCounts& counts = simulation.counts();
  constexpr double worth_a_word = 0.1;
  if (counts.tip_excess <= worth_a_word * counts.peak_needle_force) return;
  notes.push_back("increment law: a tip bore up to " + brief(counts.tip_excess) +
                  " N more than it cuts at, and the peak needle force of " +
                  brief(counts.peak_needle_force) +
                  " N is off by about as much; another increment or time.step, or cutting.law "
                  "consistent");
}

// Where a small error of mesh or step decides whether a membrane has broken, the seed lies here or there.
void note_membranes(const Simulation& simulation, std::vector<std::string>& notes) {
  constexpr double nearly = 0.9;   // of the force that breaks it
  constexpr double barely = 0.05;  // of the needle's way
  for (const Seed& seed : simulation.seeds()) {
    if (seed.tip.at_membrane && seed.tip.force > nearly * seed.tip.needed) {
      notes.push_back(
          "membrane: when " + seed_text(seed) + ", its tip stood at a membrane with " +
          brief(seed.tip.force) + " N of the " + brief(seed.tip.needed) +
          " N that break it; on another mesh or step it may have broken before, and the "
          "seed would lie deeper");
    } else if (seed.tip.at_membrane) {
      notes.push_back("membrane: when " + seed_text(seed) +
                      ", its tip stood at a membrane that it had not broken, with " +
                      brief(seed.tip.force) + " N of the " + brief(seed.tip.needed) +
                      " N that break it");
    } else if (seed.tip.since_puncture < barely) {
      notes.push_back("membrane: " + seed_text(seed) + " when it had just broken a membrane, " +
                      brief(100 * seed.tip.since_puncture) +
                      " % of its way before; on another mesh or step it may not have broken yet, "
                      "and the seed would lie less deep");
    }
  }
}

const NeedleParameters* needle_of(const Scene& scene, const Seed& seed) {
  const auto found = std::ranges::find(scene.needles, seed.needle, &NeedleParameters::name);
  return found == scene.needles.end() ? nullptr : &*found;
}

// On the first meshes of a needle in a cylinder: 4 % of the tip's displacement where elements are as large as
// the kernel, 1 % where they are half as large.
void note_mesh_in_space(const Simulation& simulation,
                        const Seed& seed,
                        std::vector<std::string>& notes) {
  constexpr double as_kernel = 0.04;
  constexpr double worth_a_word = 0.1e-3;  // m
  const NeedleParameters* needle = needle_of(simulation.scene(), seed);
  if (needle == nullptr) return;
  const double ratio = seed.tip.element / needle->space.kernel_radius;
  const double error = as_kernel * ratio * ratio * norm(seed.displacement);
  if (error < worth_a_word) return;
  notes.push_back("mesh: when " + seed_text(seed) + ", elements at the tip were " +
                  brief(1e3 * seed.tip.element) + " mm for a kernel_radius of " +
                  brief(1e3 * needle->space.kernel_radius) +
                  " mm, which leaves an error of about " + rough(1e3 * error) +
                  " mm; mesh.refine takes three quarters of it");
}

// Neo-Hookean tissue is dragged along less than linear tissue: 0.26 mm less where that is 6 mm, 0.12 mm where it
// is 4 mm, for a needle in a cylinder; about the square.
void note_small_strain(const Simulation& simulation, std::vector<std::string>& notes) {
  if (simulation.scene().dim() == 2) return;
  constexpr double per_square = 7.5;       // 1/m
  constexpr double worth_a_word = 0.1e-3;  // m
  const Seed* furthest = nullptr;
  for (const Seed& seed : simulation.seeds()) {
    if (furthest == nullptr || norm(seed.displacement) > norm(furthest->displacement)) {
      furthest = &seed;
    }
  }
  if (furthest == nullptr) return;
  const double moved = norm(furthest->displacement);
  const double excess = per_square * moved * moved;
  if (excess < worth_a_word) return;
  notes.push_back("small strain: when " + seed_text(*furthest) + ", tissue was dragged along by " +
                  rough(1e3 * moved) + " mm, about " + rough(1e3 * excess) +
                  " mm more than in tissue of large strain (neo-Hookean)");
}

// What the near field in closed form does not know of.
void note_ways(const Simulation& simulation, std::vector<std::string>& notes) {
  const Scene& scene = simulation.scene();
  if (scene.dim() == 2) return;
  constexpr double worth_a_word = 0.02;
  for (const NeedleParameters& needle : scene.needles) {
    const NeedlePath path = find_way(scene, simulation.mesh(), needle);
    if (!has_plane_skin(simulation.mesh(), needle, path)) {
      notes.push_back("the skin within kernel_radius of the entry of needle '" + needle.name +
                      "' is no plane, or the needle is more than 40 degrees from its normal: what "
                      "sticks there is up to 7 % too stiff; a smaller kernel_radius tells");
    }
    const double held = distance_to_held(scene, simulation.mesh(), needle, path);
    if (held < 2 * needle.space.kernel_radius) {
      notes.push_back(
          "needle '" + needle.name + "' passes what is held at " + brief(1e3 * held) +
          " mm, less than twice its kernel_radius: the near field does not know that it "
          "is; a smaller kernel_radius tells what that costs");
    }
    const double other = share_in_other_tissue(scene, simulation.mesh(), needle, path);
    if (other > worth_a_word) {
      notes.push_back("around needle '" + needle.name + "' " + rough(100 * other) +
                      " % of its kernel's edge lies in stiffer or softer tissue than the needle, "
                      "which moves seeds by up to 9 % of their displacement where it runs along; a "
                      "smaller kernel_radius tells");
    }
  }
  constexpr double far_aside = 0.1e-3;  // m
  if (const double aside = simulation.counts().largest_aside; aside > far_aside) {
    notes.push_back("tissue ahead of a tip had moved aside by up to " + rough(1e3 * aside) +
                    " mm, where the needle cuts straight on: seeds are off by as much at most");
  }
}

void note_cuts(const Simulation& simulation, std::vector<std::string>& notes) {
  const Scene& scene = simulation.scene();
  constexpr double worth_a_word = 0.1e-3;  // m
  constexpr double coarse = 0.5e-3;        // m
  constexpr double far_above = 1.5;
  // kelvin * force * element / tip_length: on the first three meshes of two scenes the error is 0.8 to 1.2
  // of it where the needle stops near the skin, and half of it deep in the tissue.
  for (const Seed& seed : simulation.seeds()) {
    const CuttingParameters& cutting = seed.cutting;
    if (seed.tip.lag > worth_a_word) {
      notes.push_back("lagged cutting: when " + seed_text(seed) + ", its tip was " +
                      brief(1e3 * seed.tip.lag) +
                      " mm late, and the seed is off by about as much, and forces with it; a "
                      "smaller time.step, or "
                      "cutting.law consistent");
    }
    if (cutting.law == CuttingLaw::increment && seed.tip.force > far_above * seed.tip.needed) {
      notes.push_back(
          "increment law: when " + seed_text(seed) + ", its tip bore " + brief(seed.tip.force) +
          " N, and cuts at " + brief(seed.tip.needed) +
          " N: its cuts have not kept up; another increment or time.step, or cutting.law "
          "consistent");
    }
    if (cutting.tip_length == 0) continue;
    const int region = simulation.mesh().region(simulation.place_of(seed).cell);
    const auto& name = simulation.mesh().data().region_names[static_cast<std::size_t>(region)];
    const auto tissue = std::ranges::find(scene.tissue.regions, name, &RegionTissue::region);
    if (scene.dim() == 3) {
      note_mesh_in_space(simulation, seed, notes);
      continue;
    }
    const double error =
        kelvin(scene, tissue->material) * seed.tip.needed * seed.tip.element / cutting.tip_length;
    if (error < coarse) continue;
    notes.push_back("mesh: when " + seed_text(seed) + ", elements at the tip were " +
                    brief(1e3 * seed.tip.element) + " mm for a tip_length of " +
                    brief(1e3 * cutting.tip_length) + " mm, which leaves an error of about " +
                    brief(1e3 * error) + " mm; mesh.refine halves it");
  }
}

void note_held_corners(const Simulation& simulation, std::vector<std::string>& notes) {
  for (const HeldCorner& corner : simulation.body().conditions().held_corners()) {
    const Scene& scene = simulation.scene();
    notes.push_back("a support holds " + point_text(scene, simulation.mesh().place(corner.node)) +
                    (scene.dim() == 2 ? ", a point of curve '" : ", a point of surface '") +
                    scene.prescribed[corner.prescribed].curve +
                    "', which is moved: prescribed has no effect there");
  }
}

}  // namespace

double longest_way(const Mesh& mesh, const NeedleParameters& needle) {
  if (needle.cutting.tip_length > 0) return needle.cutting.tip_length;
  double area = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) area += mesh.cell_measure(c);
  return std::sqrt(4 / std::numbers::sqrt3 * area / mesh.n_cells());  // equilateral triangles
}

std::vector<std::string> notes_of(const Simulation& simulation) {
  std::vector<std::string> notes;
  if (const auto& note = simulation.procedure_note(); !note.empty()) notes.push_back(note);
  note_turned_over(simulation, notes);
  note_motion(simulation, notes);
  note_strain(simulation, notes);
  note_locking(simulation.scene(), notes);
  note_point_tips(simulation, notes);
  note_increments(simulation, notes);
  note_few_steps(simulation, notes);
  note_long_ways(simulation, notes);
  note_late(simulation, notes);
  note_cuts(simulation, notes);
  note_excess(simulation, notes);
  note_membranes(simulation, notes);
  note_held_corners(simulation, notes);
  note_ways(simulation, notes);
  note_small_strain(simulation, notes);
  return notes;
}

}  // namespace stylet
