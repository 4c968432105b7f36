// Hands that do what no plan would: push, pull and hold at random, at random heights, leave seeds, change
// numbers, undo. Where the mesh bears no further cut the simulation says so and stops; that is undone and
// counted. Ends with 1 if any hand meets another error, or one that an undo does not mend.
//
// usage: random_hands SCENE [--method NAME] [--hands N] [--seconds T] [--first N] [--set KEY=VALUE]
#include "stylet/base/errors.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/view/live_run.hpp"
#include "stylet/view/publish.hpp"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <fstream>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace stylet;

struct Asked {
  std::string scene;
  std::string method;
  std::vector<std::string> overrides;
  int hands = 2;
  int first = 1;
  double seconds = 5;
};

struct Outcome {
  long steps = 0;
  int undos = 0;
  int changes = 0;
  int inverted_deformed = 0;  ///< most at a time
  double worst_quality = 1;
  int stops = 0;  ///< where the mesh bears no further cut
  std::string error;
};

bool is_limit_of_mesh(const std::string& message) {
  return message.find("refine the mesh") != std::string::npos;
}

/// Resident set (kB).
long memory() {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("VmRSS:")) return std::stol(line.substr(6));
  }
  return 0;
}

class Hand {
 public:
  Hand(LiveRun& run, unsigned seed) : run_(run), random_(seed) {}

  Outcome play(double seconds) {
    Outcome outcome;
    Frame frame;
    const auto n_steps = static_cast<long>(seconds / run_.step_length());
    for (long i = 0; i < n_steps; ++i) {
      if (i >= next_ || (i % 10 == 0 && was_in_ != run_.in_tissue())) decide(i, outcome);
      was_in_ = run_.in_tissue();
      try {
        run_.step();
      } catch (const NumericalError& error) {
        outcome.error = error.what();
        if (!is_limit_of_mesh(outcome.error) || !run_.undo()) break;
        outcome.error.clear();
        ++outcome.stops;
        next_ = 0;
        continue;
      }
      ++outcome.steps;
      outcome.worst_quality =
          std::min(outcome.worst_quality, run_.simulation().counts().worst_quality);
      if (i % 8 != 0) continue;
      publish(run_, i % 16 == 0 ? Colouring::von_mises : Colouring::none, frame);
      outcome.inverted_deformed = std::max(outcome.inverted_deformed, frame.inverted);
    }
    return outcome;
  }

 private:
  double draw(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  // What the hand does next, for a fifth of a second to two.
  void decide(long now, Outcome& outcome) {
    const double h = run_.step_length();
    next_ = now + static_cast<long>(draw(0.2, 2) / h);
    const double limit = run_.speed_limit();
    const double what = draw(0, 1);
    const auto [low, high] = heights();
    if (!run_.in_tissue()) {
      // In its own height it would go on where it has cut.
      run_.want(Push{what < 0.8 ? draw(low, high) : run_.height(), draw(0.4, 1) * limit});
      if (what < 0.3) change(outcome);
    } else if (what < 0.4) {
      run_.want(Push{run_.height(), draw(-0.2, 1) * limit});
    } else if (what < 0.55) {
      run_.want(Aim{run_.height(), run_.tip() + draw(-0.02, 0.02)});
    } else if (what < 0.65) {
      run_.want(Push{run_.height(), -draw(0.2, 1) * limit});
    } else if (what < 0.75) {
      run_.want(Push{run_.height(), -limit});
      next_ = now + static_cast<long>(4 / h);  // all the way out
    } else if (what < 0.9) {
      run_.seed();
      run_.want(Push{run_.height(), 0});
      next_ = now + static_cast<long>(0.2 / h);
    } else if (what < 0.97) {
      change(outcome);
    } else if (now < 2000 && run_.undo()) {
      ++outcome.undos;
    }
  }

  void change(Outcome& outcome) {
    const auto parameters = parameters_of(run_);
    if (parameters.empty()) return;
    const auto& one = parameters[static_cast<std::size_t>(
        draw(0, static_cast<double>(parameters.size()) - 1e-9))];
    if (one.high <= one.low) return;
    run_.change(one.key,
                draw(std::max(one.low, 0.5 * one.value), std::min(one.high, 2 * one.value)));
    ++outcome.changes;
  }

  std::pair<double, double> heights() const {
    const Mesh& mesh = run_.simulation().mesh();
    double low = 1e9;
    double high = -1e9;
    for (int node = 0; node < mesh.n_nodes(); ++node) {
      low = std::min(low, Axis::across(mesh.point(node)));
      high = std::max(high, Axis::across(mesh.point(node)));
    }
    return {low, high};
  }

  LiveRun& run_;
  std::mt19937_64 random_;
  long next_ = 0;
  bool was_in_ = false;
};

int program(const Asked& asked) {
  const SceneSource source{asked.scene, read_on_all(MPI_COMM_WORLD, asked.scene), asked.overrides};
  int failed = 0;
  std::vector<long> sizes;
  for (int i = 0; i < asked.hands; ++i) {
    const int seed = asked.first + i;
    LiveRun run(MPI_COMM_WORLD, {source});
    if (!asked.method.empty() && asked.method != run.method()) run.choose_method(asked.method);
    const Outcome outcome = Hand(run, static_cast<unsigned>(seed)).play(asked.seconds);
    sizes.push_back(memory());
    const bool bad = !outcome.error.empty();
    if (bad) ++failed;
    std::printf(
        "hand %d: %ld steps, %zu seeds, %d changes, %d undos, %d stops, quality %.3f, deformed "
        "inversions %d, %ld MB%s%s\n",
        seed, outcome.steps, run.simulation().seeds().size(), outcome.changes, outcome.undos,
        outcome.stops, outcome.worst_quality, outcome.inverted_deformed, sizes.back() / 1000,
        bad ? ": " : "", outcome.error.c_str());
    std::fflush(stdout);
  }
  std::printf("%d of %d hands failed; memory %ld kB after the first, %ld kB after the last\n",
              failed, asked.hands, sizes.front(), sizes.back());
  return failed == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Asked asked;
  CLI::App app;
  app.add_option("scene", asked.scene)->required();
  app.add_option("--method", asked.method);
  app.add_option("--hands", asked.hands);
  app.add_option("--first", asked.first);
  app.add_option("--seconds", asked.seconds);
  app.add_option("--set", asked.overrides)->allow_extra_args(false);
  CLI11_PARSE(app, argc, argv);
  const Session session(1, argv);
  return run_guarded([&] { return program(asked); });
}
