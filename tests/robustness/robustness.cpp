// Many meshes, heights and motions: no inverted element, no plausible number after a failure.
//
// robustness [--full | --random N [--seed S]] [--list] [--only TEXT] [--number N] [--part I/N] [--gmsh FOLDER] [--verbose]
// prints a table, one line a case. Exit code 1 if a check failed, if a run ended in a way that names
// no cause, or if one was refused that used to complete. STYLET_FULL_ROBUSTNESS=1 means --full.
#include "stylet/base/errors.hpp"
#include "stylet/petsc/session.hpp"

#include "cases.hpp"
#include "checks.hpp"
#include "meshes.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace stylet::robustness {

namespace {

struct Options {
  bool full = std::getenv("STYLET_FULL_ROBUSTNESS") != nullptr;
  bool list = false;
  bool verbose = false;
  std::string only;
  std::string gmsh_folder;
  int number = -1;
  int random = 0;
  unsigned seed = 1;
  int part = 0;
  int parts = 1;
};

Options read(int argc, char** argv) {
  Options options;
  const std::vector<std::string> words(argv + 1, argv + argc);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto value = [&]() -> std::string { return i + 1 < words.size() ? words[++i] : ""; };
    if (words[i] == "--full") options.full = true;
    if (words[i] == "--list") options.list = true;
    if (words[i] == "--verbose") options.verbose = true;
    if (words[i] == "--only") options.only = value();
    if (words[i] == "--gmsh") options.gmsh_folder = value();
    if (words[i] == "--number") options.number = std::stoi(value());
    if (words[i] == "--random") options.random = std::stoi(value());
    if (words[i] == "--seed") options.seed = static_cast<unsigned>(std::stoul(value()));
    if (words[i] == "--part") std::sscanf(value().c_str(), "%d/%d", &options.part, &options.parts);
  }
  return options;
}

struct Outcome {
  RunCounts counts;
  int n_triangles = 0;
  double excess = 0;
  double balance = 0;
  std::string text;
  int turned_over = 0;  ///< most triangles at a time
  std::string breach;
  enum class Kind { completed, refused, broken } kind = Kind::completed;
};

void run(const Case& what, bool verbose, Outcome& outcome) {
  Simulation simulation(MPI_COMM_SELF, scene_of(what), true);
  outcome.n_triangles = simulation.mesh().n_cells();
  Watch watch(simulation);
  try {
    while (!simulation.done()) {
      const StepRecord step = simulation.step();
      const auto breaches = watch.look(simulation, step);
      outcome.counts = simulation.counts();
      outcome.turned_over = simulation.turned_over().triangles;
      outcome.excess = simulation.body().ledger().worst_excess();
      outcome.balance =
          simulation.energies().balance_error() / std::max(1e-300, simulation.energies().external);
      if (verbose && simulation.needle() != nullptr) {
        const auto& n = *simulation.needle();
        std::printf(
            "  t %.4f tip %.3f mm %s contact %d hand-overs %lld passes %lld tip %.3f N friction "
            "%.3f N worst %.4f\n",
            step.t, 1e3 * (n.tip() - n.skin()), stylet::name_of(n.phase()),
            static_cast<int>(n.tip_contact()), outcome.counts.needle.hand_overs, step.passes,
            step.needle.forces.tip, step.needle.forces.friction, outcome.counts.worst_quality);
      }
      if (breaches.empty() || !outcome.breach.empty()) continue;
      outcome.breach = "t = " + std::to_string(step.t) + " s: " + breaches.front();
    }
  } catch (...) {
    outcome.counts = simulation.counts();
    outcome.turned_over = simulation.turned_over().triangles;
    throw;
  }
}

Outcome outcome_of(const Case& what, bool verbose) {
  Outcome outcome;
  try {
    run(what, verbose, outcome);
    outcome.text = "completed";
  } catch (const NumericalError& error) {
    outcome.kind = Outcome::Kind::refused;
    outcome.text = error.what();
  } catch (const InputError& error) {
    outcome.kind = Outcome::Kind::refused;
    outcome.text = error.what();
  } catch (const std::exception& error) {
    outcome.kind = Outcome::Kind::broken;
    outcome.text = error.what();
  }
  if (!outcome.breach.empty()) {
    outcome.kind = Outcome::Kind::broken;
    outcome.text = "BREACH " + outcome.breach + "; " + outcome.text;
  }
  return outcome;
}

std::string heights_of(const Case& what) {
  std::string text;
  for (const double height : what.heights) {
    char piece[40];
    std::snprintf(piece, sizeof piece, "%s%.5g", text.empty() ? "" : " ", 1e3 * height);
    text += piece;
  }
  return text;
}

std::string variant_of(const Case& what) {
  std::string text = name_of(what.method);
  text += what.tip_length > 0 ? " spread" : " point";
  if (what.law != CuttingLaw::consistent) {
    text += what.law == CuttingLaw::lagged ? " lagged" : " increment";
  }
  if (what.membrane) text += " membrane";
  if (!what.friction) text += " smooth";
  char step[60];
  std::snprintf(step, sizeof step, " %g ms %g N", 1e3 * what.step, what.cutting_force);
  return text + step;
}

int run_all(const Options& options) {
  const auto meshes = all_meshes(options.gmsh_folder);
  const auto cases = options.random > 0 ? random_cases(meshes, options.random, options.seed)
                     : options.full     ? full_cases(meshes)
                                        : quick_cases(meshes);
  int completed = 0;
  int refused = 0;
  int broken = 0;
  int unexpected = 0;
  std::printf(
      "no | mesh | triangles | height (mm) | motion | variant | hand-overs | flips | worst "
      "quality | inverted deformed | wall (s) | outcome\n");
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Case& what = cases[i];
    if (options.number >= 0 && static_cast<int>(i) != options.number) continue;
    if (static_cast<int>(i) % options.parts != options.part) continue;
    if (what.name.find(options.only) == std::string::npos) continue;
    const auto start = std::chrono::steady_clock::now();
    if (options.list) {
      std::printf("%zu | %s | %s | %s | %s\n", i, what.name.c_str(), heights_of(what).c_str(),
                  name_of(what.motion), variant_of(what).c_str());
      continue;
    }
    const Outcome outcome = outcome_of(what, options.verbose);
    const double wall =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const auto& counts = outcome.counts;
    std::printf("%zu | %s | %d | %s | %s | %s | %lld | %lld | %.3f | %d | %.1f | %s\n", i,
                what.name.c_str(), outcome.n_triangles, heights_of(what).c_str(),
                name_of(what.motion), variant_of(what).c_str(), counts.needle.hand_overs,
                counts.edge_flips, counts.worst_quality, outcome.turned_over, wall,
                outcome.text.c_str());
    std::printf("EX %zu %.3g %.3g\n", i, outcome.excess, outcome.balance);
    std::fflush(stdout);
    unexpected += outcome.kind == Outcome::Kind::refused && !what.may_be_refused ? 1 : 0;
    completed += outcome.kind == Outcome::Kind::completed ? 1 : 0;
    refused += outcome.kind == Outcome::Kind::refused ? 1 : 0;
    broken += outcome.kind == Outcome::Kind::broken ? 1 : 0;
  }
  std::printf(
      "%d completed, %d refused with an error that names its cause (%d unexpected), %d broken\n",
      completed, refused, unexpected, broken);
  return broken + unexpected == 0 ? 0 : 1;
}

}  // namespace

}  // namespace stylet::robustness

int main(int argc, char** argv) {
  const auto options = stylet::robustness::read(argc, argv);
  const stylet::Session session(1, argv);
  return stylet::run_guarded([&] { return stylet::robustness::run_all(options); });
}
