#include "stylet/simulation/start.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/fingerprint.hpp"
#include "stylet/base/text.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/scene/loader.hpp"
#include "stylet/scene/writer.hpp"
#include "stylet/simulation/checkpoint.hpp"
#include "stylet/simulation/model.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>

namespace stylet {

namespace {

/// A number of the state; 0 if there is none.
template <class T>
T stored(const Archive::Columns& state, const std::string& name) {
  const auto column = state.find(name);
  if (column == state.end()) return 0;
  const auto* numbers = std::get_if<std::vector<T>>(&column->second.values);
  return numbers == nullptr || numbers->empty() ? 0 : numbers->front();
}

/// The scene as far as it has happened, with all that may be another from there on left out.
Scene past_of(Scene scene, std::size_t n_entered, std::size_t n_actions) {
  for (auto& needle : scene.needles) {
    for (Action& action : needle.motion) {
      const bool implants = action.kind == ActionKind::implant && action.target.empty();
      if (implants && scene.targets.size() == 1) action.target = scene.targets.front().name;
    }
  }
  scene.start.reset();
  scene.output = {};
  scene.expect.clear();
  scene.targets.clear();
  scene.image.reset();
  const TimeParameters any;
  scene.time.step = any.step;
  scene.time.duration = any.duration;
  scene.time.until_implanted = any.until_implanted;
  if (scene.needles.size() > n_entered) scene.needles.resize(n_entered);
  if (n_entered == 0 || scene.needles.size() < n_entered) return scene;
  auto& motion = scene.needles.back().motion;
  if (motion.size() > n_actions) motion.resize(n_actions);
  return scene;
}

}  // namespace

StartState state_to_start_from(MPI_Comm comm, Scene scene, const std::string& mesh_fingerprint) {
  const std::string path = path_in(scene, scene.start->from);
  std::string fault;
  std::optional<LoadedCheckpoint> loaded;
  try {
    loaded = load_checkpoint(comm, path, fault);
  } catch (const Error& error) {
    if (error.code() != ExitCode::bad_input) throw;
    refuse_key(scene, "start.from", error.what());
  }
  if (!loaded) refuse_key(scene, "start.from", "is no whole checkpoint: " + fault);
  const Scene before = in_needle_frame(load_scene(path, loaded->about.scene, {}));
  if (scene.procedure || before.procedure) {
    refuse_key(scene, "start.from",
               "a recorded hand tells all of a procedure; allowed: two scenes with needles of "
               "their own, or without");
  }
  StartState start;
  start.other_step = before.time.step != scene.time.step;
  const std::size_t n_entered =
      before.needles.empty()
          ? 0
          : static_cast<std::size_t>(stored<std::int64_t>(loaded->state, "hand/n_entered"));
  std::size_t n_actions = 0;
  if (n_entered > 0) {
    const auto done = stored<std::int64_t>(loaded->state, "hand/motion/at");
    const bool has_begun = stored<double>(loaded->state, "hand/motion/elapsed") > 0;
    n_actions = std::min(static_cast<std::size_t>(done) + (has_begun ? 1 : 0),
                         before.needles[n_entered - 1].motion.size());
  }
  const std::string t = exact(loaded->about.time) + " s";
  if (scene.needles.empty() && scene.time.duration <= loaded->about.time) {
    refuse_key(scene, "time.duration",
               "allowed: more than " + t + ", where " + path + " leaves off");
  }
  const CheckpointAbout past{to_yaml(past_of(before, n_entered, n_actions)), loaded->about.mesh};
  const Scene now = past_of(std::move(scene), n_entered, n_actions);
  require_same_physics(past, path, now, {to_yaml(now), mesh_fingerprint},
                       "allowed where a scene starts from it: other targets, image, output, "
                       "expect, time.step and end, and other needles and actions after t = " +
                           t);
  start.state = std::move(loaded->state);
  start.fingerprint = fingerprint(read_on_all(comm, path));
  return start;
}

void require_start_kept(const Scene& scene, const std::string& folder) {
  if (!scene.start) return;
  std::error_code none;
  const auto from = std::filesystem::weakly_canonical(path_in(scene, scene.start->from), none);
  const auto below = std::filesystem::weakly_canonical(folder, none);
  if (std::mismatch(below.begin(), below.end(), from.begin(), from.end()).first != below.end())
    return;
  refuse_key(
      scene, "start.from",
      "lies in " + folder + ", whose results --force would replace; allowed: another folder");
}

}  // namespace stylet
