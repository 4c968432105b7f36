#include "stylet/output/folder.hpp"

#include "stylet/output/text_file.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string_view>
#include <unistd.h>
#include <vector>

namespace stylet {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::string_view, 18> own_files = {
    "history.csv",      "snapshots.h5",
    "snapshots.xdmf",   "summary.json",
    "scene.yaml",       "snapshots_needle.xdmf",
    "stability.csv",    "stability_implicit.csv",
    "stability.png",    "plan.json",
    "results.csv",      "statistics.json",
    "report.md",        "study.png",
    "convergence.json", "planned.yaml",
    "plan.csv",         "tradeoff.json"};

bool is_numbered(std::string_view name, std::string_view start, std::string_view end) {
  if (!name.starts_with(start) || !name.ends_with(end)) return false;
  name.remove_prefix(start.size());
  name.remove_suffix(std::min(end.size(), name.size()));
  return !name.empty() &&
         std::ranges::all_of(name, [](unsigned char c) { return std::isdigit(c); });
}

/// frame_0012.png and the overview, as jobs/frames.py names them.
bool is_own_picture(std::string_view name) {
  if (name == "overview.png" || name == "overview.gif") return true;
  return is_numbered(name, "frame_", ".png");
}

void remove_file(const fs::path& path) {
  // A folder of one of our names is not ours.
  if (!fs::is_directory(fs::symlink_status(path))) fs::remove(path);
}

/// Files of a folder below that are ours, and the folder if nothing else is in it.
void remove_from(const fs::path& folder, const std::function<bool(std::string_view)>& is_own) {
  if (!fs::is_directory(fs::symlink_status(folder))) return;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (is_own(entry.path().filename().string())) found.push_back(entry.path());
  }
  for (const auto& path : found) remove_file(path);
  if (fs::is_empty(folder)) fs::remove(folder);
}

void remove_own_files(const fs::path& folder) {
  for (const std::string_view name : own_files) {
    remove_file(folder / name);
    remove_file(folder / (std::string(name) + ".tmp"));
  }
  remove_from(folder / "frames", is_own_picture);
  remove_from(folder / "fields",
              [](std::string_view name) { return is_numbered(name, "", ".cbor"); });
  remove_from(folder / "scenes",
              [](std::string_view name) { return is_numbered(name, "", ".yaml"); });
}

void prepare_here(const std::string& path, bool force) {
  try {
    if (fs::exists(path) && !fs::is_directory(path)) {
      throw IoError(path + ": cannot be used as output folder: there is a file of this name");
    }
    fs::create_directories(path);
    if (!fs::is_empty(path)) {
      if (!force) {
        throw InputError(path +
                         ": the output folder is not empty; use --force to replace the results in "
                         "it, or another folder with --output");
      }
      remove_own_files(path);
    }
  } catch (const fs::filesystem_error& error) {
    throw IoError(path + ": cannot be prepared as output folder: " + error.code().message());
  }
  if (::access(path.c_str(), W_OK | X_OK) != 0) throw_io_error(path, "cannot be written to");
}

void write_here(const std::string& path, const std::string& text, Durable durable) {
  const std::string draft = path + ".tmp";
  try {
    TextFile file(draft);
    file.write(text);
    if (durable == Durable::yes) file.sync();
    file.close();
    if (std::rename(draft.c_str(), path.c_str()) != 0) throw_io_error(path, "cannot be replaced");
  } catch (const Error&) {
    ::unlink(draft.c_str());
    throw;
  }
}

}  // namespace

void prepare_folder(MPI_Comm comm, const std::string& path, bool force) {
  agree_after(comm, [&] {
    if (rank_of(comm) == 0) prepare_here(path, force);
  });
}

void write_text_atomically(MPI_Comm comm,
                           const std::string& path,
                           const std::string& text,
                           Durable durable) {
  agree_after(comm, [&] {
    if (rank_of(comm) == 0) write_here(path, text, durable);
  });
}

}  // namespace stylet
