#include "stylet/app/stored_accuracy.hpp"
#include "stylet/app/verbs.hpp"
#include "stylet/base/errors.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/view/view.hpp"

#include <charconv>
#include <filesystem>
#include <map>
#include <utility>

namespace stylet {

namespace {

PictureSize size_of_text(const std::string& text) {
  constexpr int least = 64;  // pixels
  constexpr int most = 8192;
  PictureSize size;
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  if (width.ec == std::errc() && width.ptr != end && *width.ptr == 'x') {
    const auto height = std::from_chars(width.ptr + 1, end, size.height);
    const auto fits = [](int n) { return n >= least && n <= most; };
    if (height.ec == std::errc() && height.ptr == end && fits(size.width) && fits(size.height)) {
      return size;
    }
  }
  throw InputError("--size: '" + text +
                   "'; allowed: WIDTHxHEIGHT, each 64 to 8192, such as 1280x800");
}

/// Of the seeds that the scene's own needles leave, by target (m).
std::map<std::string, double> bands_of(const Scene& scene) {
  std::map<std::string, double> bands;
  const auto study = stored_accuracy(scene).study;
  if (!study) return bands;
  int seed = 0;
  for (const auto& needle : scene.needles) {
    for (const auto& action : needle.motion) {
      if (action.kind != ActionKind::implant) continue;
      const std::string quantity = "seeds." + std::to_string(seed++) + ".placement_error";
      if (const auto band = study->of(quantity, scene.mesh.refine, scene.time.step)) {
        bands[action.target] = band->total();
      }
    }
  }
  return bands;
}

}  // namespace

int view_verb(const SceneArguments& arguments, const ViewArguments& asked) {
  const auto source = [](const std::string& file, std::vector<std::string> overrides) {
    return SceneSource{file, read_on_all(MPI_COMM_WORLD, file), std::move(overrides)};
  };
  LiveOptions live{source(arguments.file, arguments.overrides)};
  live.bands = bands_of(live.source.load());
  if (!asked.plan.empty()) live.plan = source(asked.plan, {});
  if (asked.records) {
    live.record = asked.record.empty()
                      ? "out/view-" + std::filesystem::path(arguments.file).stem().string()
                      : asked.record;
  }
  ViewOptions options;
  options.script = asked.script;
  options.frames = asked.frames;
  options.size = size_of_text(asked.size);
  options.letters = asked.letters;
  options.seconds = asked.seconds;
  view(MPI_COMM_WORLD, std::move(live), options);
  return static_cast<int>(ExitCode::done);
}

}  // namespace stylet
