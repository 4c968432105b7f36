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
  std::string before;
  std::string now;
};

std::optional<Difference> first_difference(const Node& before, const Node& now) {
  const auto differ = [&]() -> std::optional<Difference> {
    return Difference{before.path, shown(before), shown(now)};
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
    if (old == nullptr && !may_change(child.path))
      return Difference{child.path, "nothing", shown(child)};
    if (old == nullptr) continue;
    if (auto found = first_difference(*old, child)) return found;
  }
  for (const Node& old : before.children) {
    if (child_of(now, old.key) == nullptr && !may_change(old.path)) {
      return Difference{old.path, shown(old), "nothing"};
    }
  }
  return std::nullopt;
}

}  // namespace

void CheckpointAbout::archive(Archive& archive) {
  archive("scene", scene);
  archive("mesh", mesh);
  archive("options", options);
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
    const auto tip = simulation.rotation().to_scene(needle->on_axis(needle->tip()));
    about.tip = {tip.x, tip.y, tip.z};
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

// A link would be taken for nothing, and the run begun anew.
void Checkpoints::require_own() const {
  const fs::file_status status = fs::symlink_status(folder_.substr(0, folder_.size() - 1));
  if (!fs::exists(status)) return;
  std::string other = fs::is_directory(status) ? "" : folder_;
  for (const auto& entry :
       other.empty() ? fs::directory_iterator(folder_) : fs::directory_iterator()) {
    if (entry.path().extension() == ".h5" && !fs::is_regular_file(entry.symlink_status())) {
      other = entry.path();
    }
  }
  if (other.empty()) return;
  throw InputError(other +
                   ": is a link or something else that this program did not write; put what it "
                   "leads to in its place, or begin anew with --force in another folder");
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
  agree_after(comm_, [&] {
    if (rank_of(comm_) != 0) return;
    require_own();
    all = files();
  });
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
                          const CheckpointAbout& now,
                          const std::string& allowed) {
  const auto refuse = [&](const std::string& what, const std::string& advice) {
    throw InputError(scene.file + ": " + what + " when " + path + " was written; " + advice +
                     allowed);
  };
  if (const auto difference =
          first_difference(parse_yaml(path, stored.scene), parse_yaml(scene.file, now.scene))) {
    refuse("key '" + difference->path + "': is '" + difference->now + "' and was '" +
               difference->before + "'",
           "");
  }
  if (stored.mesh != now.mesh) {
    refuse("key 'mesh.file': the bytes of the file are not those", "put the mesh back; ");
  }
  if (stored.options != now.options) {
    const auto text = [](const auto& all) { return all.empty() ? "none" : join(all); };
    refuse("PETSc options: are " + text(now.options) + " and were " + text(stored.options),
           "give the same ones behind --; ");
  }
}

void require_at(const Simulation& simulation, const LoadedCheckpoint& stored) {
  const auto& [time, steps] = std::pair(stored.about.time, stored.about.steps);
  if (simulation.time() == time && simulation.counts().steps == steps) return;
  throw InputError(stored.path + ": says t = " + exact(time) + " s after " + std::to_string(steps) +
                   " steps, and its state is one of t = " + exact(simulation.time()) + " s after " +
                   std::to_string(simulation.counts().steps) +
                   "; remove it, and go on with --resume from the one before");
}

void require_same_files(const LoadedCheckpoint& stored, const Scene& scene) {
  const auto require = [&](const char* key, bool before, bool now) {
    if (before == now) return;
    throw InputError(scene.file + ": key '" + key + "': " + stored.path + " was written by a run " +
                     (before ? "with" : "without") +
                     " it, and its file would have a gap; leave it so on --resume, or begin anew "
                     "with --force");
  };
  require("output.history", stored.place->history.bytes > 0, scene.output.history);
  require("output.snapshots", stored.place->snapshots.has_value(),
          scene.output.snapshots.has_value());
}

}  // namespace stylet
