#include "stylet/study/study_run.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/simulation/recorder.hpp"

#include <algorithm>
#include <chrono>

namespace stylet {

StudyRun run_in_study(MPI_Comm comm, const Scene& scene, const Poll& poll, const Inspect& inspect) {
  const auto start = std::chrono::steady_clock::now();
  StudyRun run;
  try {
    Simulation simulation(comm, scene, false);
    while (!simulation.done()) {
      simulation.step();
      if (inspect) inspect(simulation);
      poll(simulation.fraction());
    }
    run.summary = summarise(comm, simulation, "completed", {});
  } catch (const Error& error) {
    if (error.code() != ExitCode::bad_input && error.code() != ExitCode::numerical) throw;
    run.error = one_line(error.what());
  }
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return run;
}

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

}  // namespace stylet
