#include "stylet/simulation/checkpoint.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/geometry/archive.hpp"
#include "stylet/output/manifest.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/document.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>
#include <utility>

namespace stylet {

namespace fs = std::filesystem;

namespace {

constexpr double default_wall_time = 600;  // s

std::string now_utc() {
  std::array<char, 40> text{};
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S UTC", &utc);
  return text.data();
}

std::string numbered(long long steps) {
  constexpr std::size_t digits = 8;
  const std::string text = std::to_string(steps);
  return std::string(digits - std::min(digits, text.size()), '0') + text + ".h5";
}

/// Output and end; of files the bytes are compared.
bool may_change(const std::string& path) {
  const auto within = [&](const std::string& key) {
    return path == key || path.starts_with(key + ".");
  };
  return within("output") || within("expect") || within("time.until") || within("time.duration") ||
         within("image") || within("mesh.file") || within("procedure.file");
}

/// The first path at which two documents differ, with both values.
struct Difference {
  std::string path;
  const Node* before;  ///< null where it was not written
  const Node* now;
};

std::optional<Difference> first_difference(const Node& before, const Node& now) {
  const auto differ = [&]() -> std::optional<Difference> {
    return Difference{before.path, &before, &now};
  };
  if (may_change(now.path)) return std::nullopt;
  if (before.kind != now.kind || before.text != now.text) return differ();
  if (now.kind == Node::Kind::list && before.children.size() != now.children.size()) {
    return differ();
  }
  const auto child_of = [](const Node& parent, const std::string& key) -> const Node* {
    const auto found = std::ranges::find(parent.children, key, &Node::key);
    return found == parent.children.end() ? nullptr : &*found;
  };
  for (const Node& child : now.children) {
    const Node* old = child_of(before, child.key);
    if (old == nullptr && !may_change(child.path)) return Difference{child.path, nullptr, &child};
    if (old == nullptr) continue;
    if (auto found = first_difference(*old, child)) return found;
  }
  for (const Node& old : before.children) {
    if (child_of(now, old.key) == nullptr && !may_change(old.path)) {
      return Difference{old.path, &old, nullptr};
    }
  }
  return std::nullopt;
}

}  // namespace

void CheckpointAbout::archive(Archive& archive) {
  archive("scene", scene);
  archive("mesh", mesh);
  archive("program", program);
  archive("written", written);
  archive("n_ranks", n_ranks);
  archive("time", time);
  archive("steps", steps);
  archive("phase", phase);
  archive("tip", tip);
  archive("summary", summary);
  std::vector<std::string> phases;
  std::vector<double> seconds;
  for (const auto& [of, wall] : wall_times) {
    phases.push_back(of);
    seconds.push_back(wall);
  }
  archive("phases", phases);
  archive("wall_times", seconds);
  if (!archive.loads()) return;
  for (std::size_t i = 0; i < std::min(phases.size(), seconds.size()); ++i) {
    wall_times[phases[i]] = seconds[i];
  }
}

bool CheckpointPace::due(long long steps) const {
  if (steps == last_steps_) return false;
  if (parameters_.steps && steps % *parameters_.steps == 0) return true;
  if (parameters_.steps && !parameters_.wall_time) return false;
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - last_time_;
  return since.count() >= parameters_.wall_time.value_or(default_wall_time);
}

void CheckpointPace::written(long long steps) {
  last_steps_ = steps;
  last_time_ = std::chrono::steady_clock::now();
}

Checkpoint checkpoint_of(MPI_Comm comm, Simulation& simulation, CheckpointAbout about) {
  about.program = STYLET_VERSION;
  about.written = now_utc();
  about.n_ranks = size_of(comm);
  about.time = simulation.time();
  about.steps = simulation.counts().steps;
  if (const Needle* needle = simulation.needle(); needle != nullptr) {
    about.phase = name_of(needle->phase());
    const auto tip = simulation.rotation().to_scene(needle->axis().at<WorldFrame>(needle->tip()));
    about.tip = {tip.x, tip.y};
  }
  Checkpoint checkpoint;
  Archive described({});
  described("run", about);
  checkpoint["about"] = described.columns();
  checkpoint["state"] = simulation.store();
  return checkpoint;
}

Checkpoints::Checkpoints(MPI_Comm comm, OutputFolder& folder, const OutputParameters& output)
    : comm_(comm),
      output_(folder),
      folder_(folder.path() + "/" + folder_name),
      keep_(output.checkpoint.value_or(CheckpointParameters{}).keep) {
  if (output.checkpoint) pace_.emplace(*output.checkpoint);
}

bool Checkpoints::due(long long steps) const {
  return pace_ && pace_->due(steps);
}

void Checkpoints::write(Simulation& simulation,
                        Recorder& recorder,
                        CheckpointAbout about,
                        bool goes_on) {
  static const LogEvent event("StyletCheckpoint");
  const LogScope scope(event);
  const long long steps = simulation.counts().steps;
  RecorderPlace place = recorder.settle();
  Checkpoint checkpoint = checkpoint_of(comm_, simulation, std::move(about));
  Archive output({});
  output("files", place);
  checkpoint["output"] = output.columns();
  if (!std::exchange(added_, true)) output_.add(folder_name);
  write_checkpoint(comm_, folder_ + numbered(steps), checkpoint);
  agree_after(comm_, [&] {
    if (rank_of(comm_) != 0) return;
    const auto all = files();
    const auto keep = static_cast<std::size_t>(keep_);
    for (std::size_t i = 0; i + keep < all.size(); ++i) remove(all[i]);
  });
  if (goes_on) simulation.restore(std::move(checkpoint["state"]));
  if (pace_) pace_->written(steps);
}

// Oldest first.
std::vector<std::string> Checkpoints::files() const {
  auto names = numbered_files(folder_);
  for (auto& name : names) name = folder_ + name;
  std::ranges::sort(names, {},
                    [](const std::string& name) { return std::pair(name.size(), name); });
  return names;
}

void Checkpoints::remove(const std::string& path) const {
  std::error_code error;
  fs::remove(path, error);
  if (error) throw IoError(path + ": cannot be removed: " + error.message());
}

std::optional<LoadedCheckpoint> Checkpoints::newest(std::vector<std::string>& notes) {
  int n = 0;
  std::vector<std::string> all;
  if (rank_of(comm_) == 0) all = files();
  n = static_cast<int>(all.size());
  MPI_Bcast(&n, 1, MPI_INT, 0, comm_);
  all.resize(static_cast<std::size_t>(n));
  for (; n > 0; --n) {
    const std::string& path = all[static_cast<std::size_t>(n - 1)];
    std::string fault;
    if (auto loaded = load_checkpoint(comm_, path, fault)) {
      if (pace_) pace_->written(loaded->about.steps);
      return loaded;
    }
    notes.push_back(path + " is not whole, and was removed: " + fault);
    agree_after(comm_, [&] {
      if (rank_of(comm_) == 0) remove(path);
    });
  }
  return std::nullopt;
}

std::optional<LoadedCheckpoint> load_checkpoint(MPI_Comm comm,
                                                const std::string& path,
                                                std::string& fault) {
  auto checkpoint = read_checkpoint(comm, path, fault);
  if (!checkpoint) return std::nullopt;
  LoadedCheckpoint loaded;
  loaded.path = path;
  Archive about({}, std::move((*checkpoint)["about"]));
  about("run", loaded.about);
  about.finish();
  if (const auto output = checkpoint->find("output"); output != checkpoint->end()) {
    Archive files({}, std::move(output->second));
    files("files", loaded.place.emplace());
    files.finish();
  }
  loaded.study = std::move((*checkpoint)["study"]);
  loaded.state = std::move((*checkpoint)["state"]);
  return loaded;
}

void require_same_physics(const CheckpointAbout& stored,
                          const std::string& path,
                          const Scene& scene,
                          const std::string& resolved,
                          const std::string& mesh_fingerprint,
                          const std::string& allowed) {
  const Node before = parse_yaml(path, stored.scene);
  const Node now = parse_yaml(scene.file, resolved);
  if (const auto difference = first_difference(before, now)) {
    const auto text = [](const Node* node) { return node ? shown(*node) : std::string("nothing"); };
    throw InputError(scene.file + ": key '" + difference->path + "': is '" + text(difference->now) +
                     "' and was '" + text(difference->before) + "' when " + path +
                     " was written; " + allowed);
  }
  if (stored.mesh != mesh_fingerprint) {
    throw InputError(scene.file + ": key 'mesh.file': the bytes of the file are not those when " +
                     path + " was written; put the mesh back; " + allowed);
  }
}

}  // namespace stylet
