#include "stylet/simulation/dry_run.hpp"

#include "stylet/output/manifest.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/simulation/accuracy.hpp"
#include "stylet/simulation/checkpoint.hpp"
#include "stylet/simulation/notes.hpp"
#include "stylet/simulation/overview.hpp"
#include "stylet/simulation/picture.hpp"
#include "stylet/simulation/point_text.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <sys/resource.h>

namespace stylet {

namespace {

namespace fs = std::filesystem;

/// Collective. Seconds on rank 0's clock, the same on all ranks.
class SharedClock {
 public:
  explicit SharedClock(MPI_Comm comm) : comm_(comm) {}
  double operator()() const {
    double now = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    MPI_Bcast(&now, 1, MPI_DOUBLE, 0, comm_);
    return now;
  }

 private:
  MPI_Comm comm_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Collective. Bytes of all ranks.
double peak_memory(MPI_Comm comm) {
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
  constexpr double kibi = 1024;
  double bytes = kibi * static_cast<double>(usage.ru_maxrss);
  MPI_Allreduce(MPI_IN_PLACE, &bytes, 1, MPI_DOUBLE, MPI_SUM, comm);
  return bytes;
}

/// Collective. What stands in the folder, and what the run would do about it. Throws InputError where it would
/// not go on.
std::string folder_text(MPI_Comm comm,
                        const Simulation& simulation,
                        const Scene& scene,
                        const RunOptions& options) {
  const std::string folder = output_folder(scene, options);
  std::error_code none;
  if (!fs::exists(folder, none) || fs::is_empty(folder, none)) return folder + ", which is new";
  if (!options.resume) {
    return folder + (options.force ? ", replacing the results in it"
                                   : ", which is not empty: the run would be refused without "
                                     "--force or --resume");
  }
  auto names = numbered_files(folder + "/" + Checkpoints::folder_name);
  std::ranges::sort(names, std::greater(), [](const auto& n) { return std::pair(n.size(), n); });
  for (const auto& name : names) {
    std::string fault;
    const std::string path = folder + "/" + Checkpoints::folder_name + name;
    const auto loaded = load_checkpoint(comm, path, fault);
    if (!loaded) continue;
    require_same_physics(
        loaded->about, path, scene,
        {resolved_text(scene), simulation.numbered().file_fingerprint, deciding_options()});
    return folder + ", going on after step " + std::to_string(loaded->about.steps) +
           ", at t = " + brief(loaded->about.time) + " s; what it takes is of the whole run";
  }
  return folder + ", from the beginning: it holds no whole checkpoint";
}

}  // namespace

Timing time_steps(MPI_Comm comm, const Scene& scene, double budget) {
  constexpr std::size_t fewest = 5;
  const SharedClock now(comm);
  Timing timing;
  Simulation simulation(comm, scene, scene.output.history);
  const long long before = simulation.counts().steps;
  std::vector<double> times{now()};
  while (!simulation.done() && (times.size() <= fewest || times.back() < budget)) {
    simulation.step();
    times.push_back(now());
  }
  timing.steps = simulation.counts().steps - before;
  timing.whole = simulation.done();
  timing.memory = peak_memory(comm);
  // The first steps factorise, and meet what later ones keep.
  const std::size_t last = times.size() - 1;
  const std::size_t first = last / 2;
  timing.so_far = times[last];
  if (last > first)
    timing.a_step = (times[last] - times[first]) / static_cast<double>(last - first);
  return timing;
}

std::string dry_run(MPI_Comm comm, const Scene& scene, const RunOptions& options) {
  constexpr double budget = 3;  // s
  const Timing timing = time_steps(comm, scene, budget);
  const Simulation simulation(comm, scene, false);
  if (simulation.scene().image) (void)picture_of(simulation.scene(), simulation.mesh());
  std::string text = scene.file + " would be run on " + std::to_string(size_of(comm)) +
                     (size_of(comm) == 1 ? " rank\n" : " ranks\n") +
                     overview(simulation, size_of(comm), &timing) + "writes      to " +
                     folder_text(comm, simulation, scene, options) + "\n";
  if (options.until) text += "note: --until ends it sooner than what is told here\n";
  for (const auto& note : notes_of(simulation)) text += "note: " + note + "\n";
  return text;
}

}  // namespace stylet
