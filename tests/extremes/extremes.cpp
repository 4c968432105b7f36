// Runs scenes at the extremes. Each ends in a right answer, as far as invariants can tell, or in an
// error that names its cause. Anything else fails.
//   extremes [--long] [--only TEXT]
// Checks of an answer: all numbers finite; E, density and all forces times three leave the placement
// unchanged to 1e-9 m; explicit: energies are the work done to 1 %; quasi-static: supports and needle
// balance; a bar is as long as it must be.
#include "stylet/base/errors.hpp"
#include "stylet/petsc/session.hpp"

#include "cases.hpp"
#include "support/body.hpp"
#include "support/scenes.hpp"

#include <chrono>
#include <cstdio>
#include <cstring>
#include <variant>

namespace stylet {
namespace {

constexpr double base_modulus = 60e3;  // Pa, of the needle scene

void scale(Scene& scene, double factor) {
  for (auto& region : scene.tissue.regions) {
    region.material.youngs_modulus *= factor;
    region.material.density *= factor;
  }
  for (auto& traction : scene.tractions)
    traction.force = factor * Vector2{traction.force.x, traction.force.y};
  if (scene.membrane) scene.membrane->puncture_force *= factor;
  for (auto& needle : scene.needles) {
    needle.cutting.cutting_force *= factor;
    if (!needle.friction) continue;
    needle.friction->static_force *= factor;
    needle.friction->kinetic_force *= factor;
    needle.friction->viscous_coefficient *= factor;
  }
}

/// The scene of a case; "scale=E" gives the forces the proportion of E to the base scene's.
Scene scene_of_case(const char* base, const Extreme& what) {
  std::vector<std::string> overrides;
  bool in_proportion = false;
  for (const auto& change : what.overrides) {
    if (change.starts_with("scale=")) {
      in_proportion = true;
    } else {
      overrides.push_back(change);
    }
  }
  Scene scene = scene_of(base, overrides);
  if (in_proportion) {
    const double modulus = scene.tissue.regions[0].material.youngs_modulus;
    scene.tissue.regions[0].material.youngs_modulus = base_modulus;
    scale(scene, modulus / base_modulus);
  }
  return scene;
}

struct Answer {
  std::vector<double> places;  ///< m
  double support = 0;          ///< N, quasi-static: of supports and needle together
  double force = 0;            ///< N, largest of the needle
  int steps = 0;
  double unbalanced = 0;  ///< energy of explicit steps without origin or end, over the work done
};

Answer solve(const Scene& scene) {
  Simulation simulation(MPI_COMM_WORLD, scene, true);
  Answer answer;
  double last_force = 0;
  run_to_end(simulation, [&](const StepRecord& step) {
    last_force = step.needle.forces.total();
    answer.force = std::max(answer.force, std::abs(last_force));
  });
  answer.steps = simulation.counts().steps;
  answer.places = simulation.placement_errors();
  if (scene.time.method == TimeMethod::explicit_newmark) {
    const Energies& energies = simulation.energies();
    answer.unbalanced = energies.balance_error() / std::abs(energies.external);
  }
  for (const auto& probe : simulation.probes()) {
    const std::vector<EmbeddedPoint> one{probe};
    answer.places.push_back(simulation.body().world(one)[0].x - probe.x.x);
  }
  const bool still = scene.time.method == TimeMethod::quasi_static && !scene.needles.empty();
  if (still) {
    const auto force =
        product(simulation.tissue(), simulation.tissue().stiffness(), simulation.state().u.get());
    for (const int dof : dofs_of(simulation.mesh(), {"left", "top", "bottom"})) {
      if (dof % 2 == 0) answer.support += Axis::along_sign * force[static_cast<std::size_t>(dof)];
    }
    answer.support += last_force;
  }
  return answer;
}

/// What is wrong with an answer; empty if nothing.
std::string check_answer(const Scene& scene, const Answer& answer) {
  for (const double place : answer.places) {
    if (!std::isfinite(place)) return "a number is not finite";
  }
  char text[200];
  if (std::abs(answer.unbalanced) > 0.01) {
    std::snprintf(text, sizeof text, "%.3g of the work is not in the energies", answer.unbalanced);
    return text;
  }
  if (std::abs(answer.support) > 1e-8 * std::max(answer.force, 1e-300)) {
    std::snprintf(text, sizeof text, "supports and needle leave %.3g N of %.3g N", answer.support,
                  answer.force);
    return text;
  }
  if (scene.needles.empty()) {
    // Force per metre of curve, as wide as the bar; the thickness takes it.
    const double exact = scene.tractions[0].force.x * 0.1 /
                         (scene.tissue.regions[0].material.youngs_modulus * scene.tissue.thickness);
    if (std::abs(answer.places[0] / exact - 1) > 1e-9) {
      std::snprintf(text, sizeof text, "the bar grew by %.12g m, not by %.12g m", answer.places[0],
                    exact);
      return text;
    }
    return "";
  }
  Scene other = scene;
  scale(other, 3);
  const Answer scaled = solve(other);
  for (std::size_t i = 0; i < answer.places.size(); ++i) {
    const double moved = scaled.places[i] - answer.places[i];
    if (std::abs(moved) > 1e-9) {
      std::snprintf(text, sizeof text, "scaled forces and stiffness move the seed by %.3g m",
                    moved);
      return text;
    }
  }
  return "";
}

struct Counts {
  int answers = 0;
  int refusals = 0;
  int failures = 0;
};

void run(const char* base, const Extreme& what, Counts& counts) {
  const auto start = std::chrono::steady_clock::now();
  std::string outcome;
  bool failed = false;
  try {
    const Scene scene = scene_of_case(base, what);
    const Answer answer = solve(scene);
    const std::string wrong = check_answer(scene, answer);
    char text[200];
    std::snprintf(text, sizeof text, "%.6g mm, %.4g N in %d steps",
                  1e3 * (answer.places.empty() ? 0 : answer.places[0]), answer.force, answer.steps);
    outcome = text;
    if (!wrong.empty()) outcome += "; WRONG: " + wrong;
    failed = !wrong.empty() || what.wanted == Wanted::refusal;
    counts.answers += failed ? 0 : 1;
  } catch (const Error& error) {
    outcome = std::string("refused: ") + error.what();
    failed = what.wanted == Wanted::answer;
    counts.refusals += failed ? 0 : 1;
  } catch (const std::exception& error) {
    outcome = std::string("NO CAUSE NAMED: ") + error.what();
    failed = true;
  }
  counts.failures += failed ? 1 : 0;
  const double wall =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("%s| %s | %s | %.1f s\n", failed ? "FAILED " : "", what.name.c_str(), outcome.c_str(),
              wall);
  std::fflush(stdout);
}

int run_all(bool all, const std::string& only) {
  Counts counts;
  const auto each = [&](const char* base, const std::vector<Extreme>& cases) {
    for (const auto& what : cases) {
      if (what.is_long && !all) continue;
      if (what.name.find(only) == std::string::npos) continue;
      run(base, what, counts);
    }
  };
  each(bar_scene(), bar_extremes());
  each(needle_scene(), needle_extremes());
  std::printf("%d right answers, %d errors that name their cause, %d failures\n", counts.answers,
              counts.refusals, counts.failures);
  return counts.failures == 0 ? 0 : 1;
}

}  // namespace
}  // namespace stylet

int main(int argc, char** argv) {
  bool all = false;
  std::string only;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--long") == 0) {
      all = true;
    } else if (std::strcmp(argv[i], "--only") == 0 && i + 1 < argc) {
      only = argv[++i];
    } else {
      std::fprintf(stderr, "usage: extremes [--long] [--only TEXT]\n");
      return 2;
    }
  }
  const stylet::Session session(1, argv);
  return stylet::run_all(all, only);
}
