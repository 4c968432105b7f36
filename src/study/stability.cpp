#include "stylet/study/stability.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/needle/advance.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/output/progress.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/simulation/simulation.hpp"
#include "stylet/solvers/modes.hpp"
#include "stylet/study/identity.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numeric>

namespace stylet {

namespace {

constexpr std::array schemes{ImplicitScheme::average_acceleration,
                             ImplicitScheme::generalised_alpha, ImplicitScheme::backward_euler};
constexpr std::array factors{0.01, 0.1, 1.0, 10.0, 100.0, 1000.0};
constexpr std::array insertion_factors{10.0, 100.0};
constexpr int growth_steps = 500;

/// A scene run as long as needles go in.
class Insertion {
 public:
  Insertion(MPI_Comm comm, const Scene& scene, bool track_energy)
      : simulation_(comm, scene, track_energy) {
    for (const auto& needle : scene.needles) {
      const double skin =
          Axis::along(find_entry(simulation_.mesh(), {needle.height}, needle.name).x);
      double depth = 0;
      for (const auto& action : needle.motion) {
        if (action.kind != ActionKind::insert && action.kind != ActionKind::retract) continue;
        double end = 0;
        if (action.depth) end = *action.depth;
        if (action.position) end = Axis::along_sign * *action.position - skin;
        const double way = std::max(0.0, end - depth);
        total_ += way;
        n_steps_ += std::ceil(way / (action.speed * scene.time.step));
        depth = end;
      }
    }
  }

  [[nodiscard]] const Simulation& simulation() const { return simulation_; }
  [[nodiscard]] double depth() const { return depth_; }
  /// Of time.step, with a needle going in.
  [[nodiscard]] double n_steps() const { return n_steps_; }
  /// Of all travel into the tissue, 0 to 1.
  [[nodiscard]] double share() const { return total_ > 0 ? travelled_ / total_ : 1; }
  [[nodiscard]] bool done() const {
    constexpr double round_off = 1e-9;
    return simulation_.done() || share() > 1 - round_off;
  }

  StepRecord step() {
    const StepRecord record = simulation_.step();
    if (const Needle* needle = simulation_.needle(); needle != nullptr) {
      const double depth = needle->tip() - needle->skin();
      travelled_ += std::max(0.0, depth - depth_);
      depth_ = depth;
    }
    return record;
  }

 private:
  Simulation simulation_;
  double total_ = 0;
  double n_steps_ = 0;
  double travelled_ = 0;
  double depth_ = 0;
};

double smallest_height(const Mesh& mesh) {
  double smallest = std::numeric_limits<double>::infinity();
  for (int c = 0; c < mesh.n_cells(); ++c) {
    if (mesh.dim() == 3) {
      const auto t = mesh.tetrahedron(c);
      double largest = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        const ReferencePlace a = t[(i + 1) % 4];
        const Vector3 twice = cross(t[(i + 2) % 4] - a, t[(i + 3) % 4] - a);
        largest = std::max(largest, 0.5 * norm(twice));
      }
      smallest = std::min(smallest, 3 * mesh.cell_measure(c) / largest);
      continue;
    }
    const auto n = mesh.cell(c);
    double longest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      longest = std::max(longest, distance(mesh.point(n[i]), mesh.point(n[(i + 1) % 3])));
    }
    smallest = std::min(smallest, 2 * mesh.cell_measure(c) / longest);
  }
  return smallest;
}

/// All measurements of one study, in the order in which they are made.
class Study {
 public:
  Study(MPI_Comm comm, const Scene& scene, const StabilityOptions& options, Stability& result)
      : comm_(comm),
        scene_(scene),
        options_(options),
        result_(result),
        insertion_(comm, scene, false),
        original_(insertion_.simulation().numbered()),
        progress_(comm, options.quiet) {
    const double most = insertion_.n_steps() + 1;
    if (options.samples <= std::max(most, double(StabilityOptions{}.samples))) return;
    throw InputError("stability: --samples " + std::to_string(options.samples) +
                     ": the insertion takes " + brief(most - 1) +
                     " steps of time.step; allowed: at most one moment a step and the start, " +
                     brief(most));
  }

  void measure() {
    const int last = scene_.needles.empty() ? 0 : options_.samples - 1;
    const int middle = (last + 1) / 2;
    for (int sample = 0; sample <= last; ++sample) {
      const double wanted = last == 0 ? 0 : static_cast<double>(sample) / last;
      while (!insertion_.done() && insertion_.share() < wanted) {
        const StepRecord step = insertion_.step();
        end_ = step.t;
        show("insertion, t " + std::to_string(step.t) + " s");
      }
      explicit_limits();
      if (sample == middle) implicit_growth();
    }
    if (!scene_.needles.empty()) balances();
  }

 private:
  // The insertion with its measurements takes most of the time.
  void show(const std::string& text) {
    constexpr double of_all = 0.7;
    progress_.update(of_all * insertion_.share(), text);
  }

  void explicit_limits() {
    const Mesh& mesh = insertion_.simulation().mesh();
    const ConstraintSet held = homogeneous(insertion_.simulation().constraints());
    std::vector<int> all(static_cast<std::size_t>(mesh.n_cells()));
    std::iota(all.begin(), all.end(), 0);
    ExplicitLimit limit;
    limit.time = insertion_.simulation().time();
    limit.tip_depth = insertion_.depth();
    limit.worst_quality = mesh.worst_quality(all);
    limit.smallest_height = smallest_height(mesh);
    TissueParameters parameters = scene_.tissue;
    parameters.mass = MassKind::lumped;
    parameters.damping.reset();
    const double squared =
        largest_frequency_squared(*tissue_at(comm_, original_, mesh, parameters), held);
    if (result_.dampings.empty()) choose_dampings(squared);
    for (const auto& damping : result_.dampings) {
      parameters.damping = damping;
      const auto tissue = tissue_at(comm_, original_, mesh, parameters);
      const OwnedVec v = random_velocities(*tissue, original_, held);
      limit.damping = damping;
      limit.spectral = stable_step(squared, damping.stiffness_factor);
      const MeasuredLimit found = measured_limit(*tissue, mesh, held, v.get());
      limit.predicted = found.predicted;
      limit.measured = found.step;
      result_.limits.push_back(limit);
      show("stable step at " + std::to_string(limit.tip_depth) + " m");
    }
  }

  // The scene's own factors where explicit stepping can bear them, else ones that are felt: as shares
  // of the largest frequency, 2 % by mass and xi = 0.1 by stiffness.
  void choose_dampings(double omega_squared) {
    const double omega = std::sqrt(omega_squared);
    constexpr double by_mass = 0.02;
    constexpr double by_stiffness = 0.2;
    constexpr double bearable = 0.5;
    const auto own = scene_.tissue.damping.value_or(RayleighDamping{});
    result_.mass_of_scene = own.mass_factor > 0;
    result_.stiffness_of_scene =
        own.stiffness_factor > 0 &&
        stable_step(omega_squared, own.stiffness_factor) > bearable * stable_step(omega_squared, 0);
    result_.dampings = {
        {},
        {result_.mass_of_scene ? own.mass_factor : by_mass * omega, 0},
        {0, result_.stiffness_of_scene ? own.stiffness_factor : by_stiffness / omega}};
  }

  void implicit_growth() {
    const Mesh& mesh = insertion_.simulation().mesh();
    const ConstraintSet held = homogeneous(insertion_.simulation().constraints());
    TissueParameters parameters = scene_.tissue;
    parameters.damping.reset();
    const auto tissue = tissue_at(comm_, original_, mesh, parameters);
    const OwnedVec v = random_velocities(*tissue, original_, held);
    result_.middle_limit = result_.limits[result_.limits.size() - result_.dampings.size()].measured;
    result_.middle_depth = insertion_.depth();
    result_.growth_steps = growth_steps;
    for (const auto scheme : schemes) {
      for (const double factor : factors) {
        TimeParameters time = scene_.time;
        time.method = TimeMethod::implicit_newmark;
        time.scheme = scheme;
        const double h = factor * result_.middle_limit;
        result_.growths.push_back(
            {scheme, factor, h,
             energy_growth(*tissue, mesh, held, v.get(), time, h, growth_steps)});
        show(std::string("energy of ") + name_of(scheme));
      }
    }
    check_unused_options();
  }

  void balances() {
    constexpr double most_steps = 5000;
    int done = 0;
    for (const auto scheme : schemes) {
      for (const double factor : insertion_factors) {
        Scene scene = scene_;
        scene.time.method = TimeMethod::implicit_newmark;
        scene.time.scheme = scheme;
        scene.time.step = factor * result_.middle_limit;
        if (end_ < most_steps * scene.time.step) result_.balances.push_back(balance(scene, factor));
        constexpr double before = 0.7;
        constexpr double rest = 0.3 / (schemes.size() * insertion_factors.size());
        progress_.update(before + rest * ++done, std::string("insertion by ") + name_of(scheme));
      }
    }
  }

  InsertionBalance balance(const Scene& scene, double factor) {
    InsertionBalance balance{scene.time.scheme, factor, scene.time.step, 0, 0, 0, 0, {}};
    try {
      Insertion insertion(comm_, scene, true);
      double lowest = 0;
      while (!insertion.done()) {
        insertion.step();
        ++balance.steps;
        const Energies& energies = insertion.simulation().energies();
        lowest = std::min(lowest, energies.balance_error());
        balance.external = energies.external;
        balance.balance_error = energies.balance_error() / energies.external;
      }
      balance.lowest_balance_error = lowest / balance.external;
    } catch (const NumericalError& error) {
      balance.failure = error.what();
    }
    return balance;
  }

  MPI_Comm comm_;
  const Scene& scene_;
  const StabilityOptions& options_;
  Stability& result_;
  Insertion insertion_;
  NumberedMesh original_;
  Progress progress_;
  double end_ = 0;  ///< of the insertion (s)
};

void check_scene(const Scene& scene, const StabilityOptions& options) {
  if (scene.start) {
    refuse_key(scene, "start", "stability changes methods; allowed: scenes that begin at rest");
  }
  if (options.samples < 1) {
    throw InputError("stability: --samples " + std::to_string(options.samples) +
                     " is not at least 1");
  }
  for (const auto& region : scene.tissue.regions) {
    if (region.material.density > 0) continue;
    throw InputError(scene.file + ": key 'tissue.regions." + region.region +
                     ".density': 0; without mass no step is too long, so there is no stability to "
                     "measure");
  }
}

}  // namespace

const char* name_of(ImplicitScheme scheme) {
  switch (scheme) {
    case ImplicitScheme::average_acceleration:
      return "average_acceleration";
    case ImplicitScheme::generalised_alpha:
      return "generalised_alpha";
    case ImplicitScheme::backward_euler:
      break;
  }
  return "backward_euler";
}

Stability stability(MPI_Comm comm, const Scene& scene, const StabilityOptions& options) {
  check_scene(scene, options);
  Stability result;
  result.folder = options.output;
  if (result.folder.empty()) {
    result.folder = "out/stability-" + std::filesystem::path(scene.file).stem().string();
  }
  if (scene.procedure) {
    refuse_key(scene, "procedure", "stability takes other steps; allowed: a scene with needles");
  }
  if (scene.dim() == 3 && !scene.needles.empty()) {
    refuse_key(scene, "needles",
               "in space they leave mesh and operator as they are, and the stable step with them; "
               "allowed: the scene without needles");
  }
  Study study(comm, scene, options, result);
  OutputFolder folder(comm, result.folder,
                      {"stability", {"stability.csv", "stability_implicit.csv"}, {}},
                      options.force ? Earlier::replace : Earlier::refuse, OnSignal::end);
  in_folder(folder, [&] {
    folder.go_on();
    study.measure();
    auto summary = report(comm, scene, result, options.quiet);
    add_identity(summary, mesh_files(comm, std::span(&scene, 1)));
    folder.finish(summary);
  });
  return result;
}

}  // namespace stylet
