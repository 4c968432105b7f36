// The same procedure on any number of ranks: the same decisions, and the same numbers up to the
// round-off of sums in another order. `scenes_mpi FILE` on one rank writes the results to the file;
// on more ranks it compares.
#include "stylet/petsc/session.hpp"
#include "stylet/scene/loader.hpp"
#include "stylet/simulation/simulation.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace stylet {

namespace {

// 192 triangles and few, long steps: ranks that share a core are slow. The outline of the core is a membrane in some scenes.
const std::string base = R"(mesh:
  rectangle:
    size: [8 cm, 6 cm]
    columns: 12
    rows: 8
    jitter: 0.1
    inner_regions: [{name: core, polygon: [[2 cm, 1.5 cm], [4 cm, 1.5 cm], [4 cm, 4.5 cm], [2 cm, 4.5 cm]]}]
tissue:
  plane: stress
  regions:
    tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}
    core: {youngs_modulus: 120 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}
  damping: {stiffness_factor: 0.05 s}
supports: {left: fixed, top: fixed, bottom: fixed}
needles:
  - height: 3.17 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}
    motion:
      - insert: {speed: 2 cm/s, depth: 4.2 cm}
      - implant
      - retract: {speed: 2 cm/s}
      - settle: {duration: 0.1 s}
targets: {seed: [3.5 cm, 3.2 cm]}
time: {method: quasi_static, step: 100 ms}
)";

struct NamedScene {
  std::string name;
  std::vector<std::string> overrides;
};

const std::string reversals =
    "needles.0.motion=[insert: {speed: 2 cm/s, depth: 1.5 cm}, retract: {speed: 2 cm/s, depth: 1.2 "
    "cm}, insert: {speed: 2 cm/s, depth: 2.6 cm}, retract: {speed: 2 cm/s, depth: 0.8 cm}, insert: "
    "{speed: 2 cm/s, depth: 3 cm}, implant: {}, retract: {speed: 2 cm/s}]";
const std::string two_needles =
    "needles=[{height: 3.17 cm, cutting: {cutting_force: 1.7 N}, motion: [insert: {speed: 2 cm/s, "
    "depth: 3 cm}, implant: {}, retract: {speed: 2 cm/s}]}, {height: 2.87 cm, cutting: "
    "{cutting_force: 1.7 N}, motion: [insert: {speed: 2 cm/s, depth: 3.4 cm}, implant: {}, "
    "retract: "
    "{speed: 2 cm/s}]}]";

const std::vector<NamedScene> scenes = {
    {"distributed tip", {}},
    {"point tip", {"needles.0.cutting.tip_length=0 mm"}},
    // Nothing but position breaks the ties of a needle on a line of nodes of a symmetric mesh.
    {"symmetric",
     {"mesh.rectangle.jitter=0", "needles.0.height=3 cm", "needles.0.cutting.tip_length=0 mm"}},
    {"implicit", {"time.method=implicit"}},
    {"implicit point tip",
     {"time.method=implicit", "needles.0.cutting.tip_length=0 mm", reversals}},
    {"membrane", {"membrane={region: core, puncture_force: 2.5 N}"}},
    {"reversals", {reversals}},
    {"two needles", {two_needles}},
    {"lagged", {"needles.0.cutting.law=lagged"}},
    {"explicit",
     {"time.method=explicit", "time.step=20 ms", "tissue.damping={mass_factor: 100 1/s}",
      "needles.0.motion=[insert: {speed: 5 cm/s, depth: 1.2 cm}, implant: {}, retract: {speed: 5 "
      "cm/s}]"}},
};

/// Decisions are integers and must be equal; quantities may differ by round-off.
struct Result {
  std::string decisions;
  std::vector<double> quantities;
};

Result run(const NamedScene& named) {
  Simulation simulation(MPI_COMM_WORLD, load_scene("scene.yaml", base, named.overrides), true);
  std::ostringstream decisions;
  Result result;
  while (!simulation.done()) {
    const StepRecord step = simulation.step();
    const Needle& needle = *simulation.needle();
    decisions << step.needle.n_stick << '/' << step.needle.n_slip << '/'
              << static_cast<int>(needle.tip_contact()) << '/'
              << simulation.counts().needle.hand_overs << '/' << simulation.counts().edge_flips
              << ' ';
  }
  const auto& counts = simulation.counts();
  decisions << "punctures " << counts.needle.punctures;
  result.decisions = decisions.str();
  for (const double error : simulation.placement_errors()) result.quantities.push_back(error);
  result.quantities.push_back(counts.peak_needle_force);
  result.quantities.push_back(counts.worst_quality);
  result.quantities.push_back(simulation.energies().external);
  return result;
}

void write(const std::string& file, const std::map<std::string, Result>& results) {
  std::ofstream out(file);
  out.precision(17);
  for (const auto& [name, result] : results) {
    out << name << '\n' << result.decisions << '\n' << result.quantities.size();
    for (const double value : result.quantities) out << ' ' << value;
    out << '\n';
  }
}

std::map<std::string, Result> read(const std::string& file) {
  std::ifstream in(file);
  std::map<std::string, Result> results;
  for (std::string name; std::getline(in, name);) {
    Result result;
    std::getline(in, result.decisions);
    std::string line;
    std::getline(in, line);
    std::istringstream numbers(line);
    std::size_t n = 0;
    numbers >> n;
    result.quantities.resize(n);
    for (double& value : result.quantities) numbers >> value;
    results[name] = result;
  }
  return results;
}

int compare(const std::string& name, const Result& mine, const Result& one_rank) {
  // The solver stops at 1e-11 of its residual, and a step's cut at 1e-4 of its length after the
  // same number of solves; 100 steps add up to less than this.
  constexpr double tolerance = 1e-8;
  int wrong = 0;
  if (mine.decisions != one_rank.decisions) {
    std::size_t at = 0;
    while (at < mine.decisions.size() && mine.decisions[at] == one_rank.decisions[at]) ++at;
    const std::size_t from = at > 60 ? at - 60 : 0;
    std::printf(
        "%s: other decisions (stick/slip/tip/hand-overs/flips):\n  here     ...%s\n  one rank "
        "...%s\n",
        name.c_str(), mine.decisions.substr(from, 120).c_str(),
        one_rank.decisions.substr(from, 120).c_str());
    ++wrong;
  }
  for (std::size_t i = 0; i < one_rank.quantities.size(); ++i) {
    const double difference = std::abs(mine.quantities.at(i) / one_rank.quantities[i] - 1);
    if (difference <= tolerance) continue;
    std::printf("%s: quantity %zu is %.17g, on one rank %.17g\n", name.c_str(), i,
                mine.quantities[i], one_rank.quantities[i]);
    ++wrong;
  }
  return wrong;
}

int run_all(const std::string& file) {
  const int n_ranks = size_of(MPI_COMM_WORLD);
  const bool first = rank_of(MPI_COMM_WORLD) == 0;
  std::map<std::string, Result> results;
  for (const auto& scene : scenes) results[scene.name] = run(scene);
  if (n_ranks == 1) {
    write(file, results);
    return 0;
  }
  int wrong = 0;
  if (first) {
    const auto one_rank = read(file);
    for (const auto& scene : scenes) {
      const auto found = one_rank.find(scene.name);
      if (found == one_rank.end()) {
        std::printf("%s: no result of one rank in %s\n", scene.name.c_str(), file.c_str());
        ++wrong;
      } else {
        wrong += compare(scene.name, results.at(scene.name), found->second);
      }
    }
  }
  MPI_Bcast(&wrong, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return wrong == 0 ? 0 : 1;
}

}  // namespace

}  // namespace stylet

int main(int argc, char** argv) {
  if (argc != 2) return 1;
  const std::string file = argv[1];
  const stylet::Session session(1, argv);
  return stylet::run_guarded([&] { return stylet::run_all(file); });
}
