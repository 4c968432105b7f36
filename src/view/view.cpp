#include "stylet/view/view.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/simulation/picture.hpp"
#include "stylet/view/live_session.hpp"
#include "stylet/view/offscreen.hpp"
#include "stylet/view/publish.hpp"

#include <cstdio>
#include <filesystem>
#include <utility>

namespace stylet {

namespace {

void play_script(MPI_Comm comm, LiveOptions live, const ViewOptions& options) {
  const auto lines = read_script(options.script, read_on_all(comm, options.script));
  LiveRun run(comm, std::move(live));
  std::error_code fault;
  std::filesystem::create_directories(options.frames, fault);
  if (fault) throw IoError(options.frames + ": " + fault.message());
  const OffscreenContext context;
  const OffscreenTarget target(options.size.width, options.size.height);
  const Interface interface;
  Display display(picture_of(run.simulation().scene(), run.simulation().mesh()));
  display.look.size = options.letters;
  display.planned = run.planned();
  Player(run, display, options.frames, options.size).play(lines);
  std::fputs(last_words(run).c_str(), stdout);
}

void open_window(MPI_Comm comm, LiveOptions live, const ViewOptions& options) {
  WindowOptions window;
  window.title = "Stylet: " + live.source.file;
  window.width = options.size.width;
  window.height = options.size.height;
  window.letters = options.letters;
  if (options.seconds > 0) window.seconds = options.seconds;
  LiveSession session(comm, std::move(live));
  const WindowReport report = show_window(session, window);
  std::fputs(session.end().c_str(), stdout);
  if (options.seconds <= 0) return;
  std::printf(
      "%.1f frames a second, real-time factor %.3f, steps take %.1f %% of the time, "
      "longest step %.0f ms, hand to picture %.1f ms\n",
      static_cast<double>(report.frames) / report.seconds, report.real_time_factor,
      100 * report.busy, 1e3 * report.longest, 1e3 * report.delay);
}

}  // namespace

void view(MPI_Comm comm, LiveOptions live, const ViewOptions& options) {
  if (size_of(comm) > 1) {
    throw InputError("view: runs on one rank; allowed: stylet view SCENE without mpirun");
  }
  if (options.script.empty()) {
    open_window(comm, std::move(live), options);
  } else {
    play_script(comm, std::move(live), options);
  }
}

}  // namespace stylet
