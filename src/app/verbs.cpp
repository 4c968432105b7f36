#include "stylet/app/verbs.hpp"

#include "stylet/app/stored_accuracy.hpp"
#include "stylet/base/errors.hpp"
#include "stylet/base/memory.hpp"
#include "stylet/base/text.hpp"
#include "stylet/base/units.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/scene/loader.hpp"
#include "stylet/scene/schema.hpp"
#include "stylet/simulation/inspect.hpp"
#include "stylet/simulation/notes.hpp"
#include "stylet/simulation/overview.hpp"
#include "stylet/simulation/picture.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/simulation/simulation.hpp"
#include "stylet/solvers/modes.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

namespace stylet {

namespace {

bool prints() {
  return rank_of(MPI_COMM_WORLD) == 0;
}

Scene load(const SceneArguments& arguments) {
  return load_scene(arguments.file, read_on_all(MPI_COMM_WORLD, arguments.file),
                    arguments.overrides);
}

}  // namespace

int run_verb(SceneArguments arguments, RunOptions options, const std::string& accuracy) {
  Scene scene = load(arguments);
  auto stored = stored_accuracy(scene);
  options.accuracy = std::move(stored.study);
  options.accuracy_missing = stored.missing;
  if (!accuracy.empty()) {
    if (!options.accuracy) {
      const std::string reason =
          stored.missing.empty()
              ? "there is no convergence study of this scene (" + accuracy_path(scene.file) + ")"
              : stored.missing;
      throw InputError("--accuracy " + accuracy + ": " + reason +
                       "; stylet converge --store makes one");
    }
    const StudiedLevel level = options.accuracy->cheapest(to_si(accuracy, "m"));
    arguments.overrides.push_back("mesh.refine=" + std::to_string(level.refine));
    arguments.overrides.push_back("time.step=" + exact(level.step) + " s");
    scene = load(arguments);
    if (prints() && !options.quiet) {
      std::printf("for %s: mesh.refine %d, time.step %g ms (%.3g s in the study)\n",
                  accuracy.c_str(), level.refine, 1e3 * level.step, level.seconds);
    }
  }
  const RunOutcome outcome = run(MPI_COMM_WORLD, scene, options);
  if (outcome.failed_expectations == 0) return static_cast<int>(ExitCode::done);
  throw NumericalError(std::to_string(outcome.failed_expectations) +
                       " of the scene's expectations are not met, see " + outcome.folder +
                       "/summary.json");
}

int check_verb(const SceneArguments& arguments) {
  const Simulation simulation(MPI_COMM_WORLD, load(arguments), false);
  if (simulation.scene().image) (void)picture_of(simulation.scene(), simulation.mesh());
  if (prints()) {
    std::printf("%s is valid\n%s", arguments.file.c_str(),
                overview(simulation, size_of(MPI_COMM_WORLD)).c_str());
    for (const auto& note : notes_of(simulation)) std::printf("note: %s\n", note.c_str());
  }
  return static_cast<int>(ExitCode::done);
}

int inspect_verb(const std::string& checkpoint, const std::string& snapshot) {
  const std::string text = inspect(MPI_COMM_WORLD, checkpoint, snapshot);
  if (prints()) std::fputs(text.c_str(), stdout);
  return static_cast<int>(ExitCode::done);
}

int modes_verb(const SceneArguments& arguments, int n) {
  const Scene scene = in_needle_frame(load(arguments));
  if (scene.start) {
    refuse_key(scene, "start",
               "modes are of tissue that no needle has cut; allowed: a scene without");
  }
  NumberedMesh numbered = make_mesh(MPI_COMM_WORLD, scene);
  check_against_mesh(scene, numbered.mesh);
  const auto tissue = make_tissue(MPI_COMM_WORLD, scene, numbered);
  std::vector<int> held;
  for (const auto& dof : Conditions(scene, numbered.mesh).prescribed(0)) held.push_back(dof.dof);
  const int n_free = tissue->n_dofs() - static_cast<int>(held.size());
  if (n < 1 || n > n_free) {
    throw InputError("modes: " + std::to_string(n) + " modes asked for; this scene has 1 to " +
                     std::to_string(n_free));
  }
  // Two vectors of its Krylov space for each mode, shared by the ranks.
  const double bytes = 2.0 * n * tissue->n_dofs() * sizeof(double);
  if (bytes > memory_here()) {
    throw InputError("modes: " + std::to_string(n) + " modes of " + std::to_string(n_free) +
                     " unknowns need about " + brief(std::ceil(1e-9 * bytes)) +
                     " GB of memory; allowed here: up to " +
                     brief(std::floor(n * memory_here() / bytes)));
  }
  const auto frequencies = natural_frequencies(*tissue, held, n);
  check_unused_options();
  if (prints()) {
    std::printf("mode  omega (rad/s)      frequency (Hz)\n");
    for (std::size_t i = 0; i < frequencies.size(); ++i) {
      std::printf("%4zu  %-17.10g  %.10g\n", i + 1, frequencies[i],
                  frequencies[i] / (2 * std::numbers::pi));
    }
  }
  return static_cast<int>(ExitCode::done);
}

int stability_verb(const SceneArguments& arguments, const StabilityOptions& options) {
  stability(MPI_COMM_WORLD, load(arguments), options);
  return static_cast<int>(ExitCode::done);
}

int converge_verb(const SceneArguments& arguments, const ConvergeOptions& options) {
  std::string note;
  converge(MPI_COMM_WORLD, with_procedure(MPI_COMM_WORLD, load(arguments), note), options);
  if (prints() && !note.empty()) std::printf("note: %s\n", note.c_str());
  return static_cast<int>(ExitCode::done);
}

int plan_verb(const SceneArguments& arguments, PlanOptions options) {
  const Scene scene = load(arguments);
  options.accuracy = stored_accuracy(scene).study;
  plan(MPI_COMM_WORLD, scene, options);
  return static_cast<int>(ExitCode::done);
}

int tradeoff_verb(const SceneArguments& arguments, const TradeoffOptions& options) {
  tradeoff(MPI_COMM_WORLD, arguments.file, read_on_all(MPI_COMM_WORLD, arguments.file),
           arguments.overrides, options);
  return static_cast<int>(ExitCode::done);
}

int sweep_verb(const SceneArguments& arguments, const SweepOptions& options) {
  const Campaign campaign = load_campaign(
      arguments.file, read_on_all(MPI_COMM_WORLD, arguments.file), arguments.overrides);
  sweep(MPI_COMM_WORLD, campaign, options);
  return static_cast<int>(ExitCode::done);
}

int schema_verb(bool markdown) {
  if (prints()) std::fputs((markdown ? schema_markdown() : schema_text()).c_str(), stdout);
  return static_cast<int>(ExitCode::done);
}

}  // namespace stylet
