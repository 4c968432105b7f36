#include "stylet/output/folder.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/message.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/base/text.hpp"
#include "stylet/output/summary.hpp"
#include "stylet/output/text_file.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <unistd.h>

namespace stylet {

namespace fs = std::filesystem;

namespace {

/// Of a file that is being made, or room kept for one.
bool is_draft(const std::string& name) {
  return name == ".stylet.reserve" || (name.starts_with(".stylet.") && name.ends_with(".tmp"));
}

constexpr const char* parts = "parts";

/// What stands in the folder beside marks, locks and drafts.
std::vector<std::string> entries_of(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const auto name = entry.path().filename().string();
    const bool is_own =
        name == Manifest::file_name || name == FolderLock::file_name || is_draft(name);
    if (!is_own) names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

void create(const std::string& path) {
  if (fs::exists(path) && !fs::is_directory(path)) {
    throw IoError(path + ": cannot be used as output folder: there is a file of this name");
  }
  fs::create_directories(path);
  if (::access(path.c_str(), W_OK | X_OK) != 0) throw_io_error(path, "cannot be written to");
}

/// Before anything is written to it, the lock included.
void require_ours_or_empty(const std::string& path) {
  if (Manifest(path).exists()) return;
  auto entries = entries_of(path);
  if (fs::exists(fs::symlink_status(path + "/" + Manifest::file_name))) {
    entries.emplace_back(Manifest::file_name);
  }
  if (entries.empty()) return;
  throw InputError(path +
                   ": the output folder is not empty and was not made by this program: it "
                   "holds '" +
                   entries.front() +
                   "'; nothing in it is touched, with --force or without; use another folder with "
                   "--output");
}

/// Of runs that were killed.
void remove_drafts(const fs::path& folder) {
  std::vector<fs::path> drafts;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (is_draft(entry.path().filename().string())) drafts.push_back(entry.path());
  }
  for (const auto& draft : drafts) fs::remove(draft);
}

template <class Body>
void on_first(MPI_Comm comm, const std::string& path, Body&& body) {
  agree_after(comm, [&] {
    if (rank_of(comm) != 0) return;
    try {
      body();
    } catch (const fs::filesystem_error& error) {
      throw IoError(path + ": cannot be prepared as output folder: " + error.code().message());
    }
  });
}

void write_here(const std::string& path, const std::string& text, Durable durable) {
  TextFile file(path);
  file.write(text);
  if (durable == Durable::yes) file.sync();
  file.close();
  file.appear();
}

}  // namespace

OutputFolder::OutputFolder(
    MPI_Comm comm, std::string path, Contents contents, Earlier earlier, OnSignal on_signal)
    : comm_(comm), path_(std::move(path)), contents_(std::move(contents)) {
  contents_.names.emplace_back("summary.json");
  on_first(comm, path_, [&] { prepare(earlier); });
  status_.emplace(comm, path_ + "/summary.json", on_signal, lock_ ? lock_->path() : "");
}

void OutputFolder::prepare(Earlier earlier) {
  create(path_);
  require_ours_or_empty(path_);
  lock_.emplace(path_);
  manifest_.emplace(path_);
  const bool holds_results = !entries_of(path_).empty();
  if (holds_results && earlier == Earlier::refuse) {
    throw InputError(path_ +
                     ": the output folder is not empty; use --force to replace the results in it, "
                     "or another folder with --output");
  }
  if (earlier == Earlier::keep && manifest_->exists() && manifest_->what() != contents_.what &&
      manifest_->what() != parts) {
    throw InputError(path_ + ": holds the results of stylet " + manifest_->what() +
                     ", so there is nothing to go on with; use another folder with --output");
  }
  auto names = contents_.names;
  if (earlier == Earlier::replace) {
    const auto old = manifest_->names();
    names.insert(names.end(), old.begin(), old.end());
  } else {
    std::erase_if(names, [&](const auto& name) {
      return manifest_->owns(name) ||
             std::ranges::find(contents_.grows, name) != contents_.grows.end();
    });
  }
  std::vector<std::string> foreign;
  for (const auto& name : names) {
    if (fs::exists(fs::symlink_status(path_ + "/" + name)) && !manifest_->owns(name)) {
      foreign.push_back(name);
    }
  }
  for (const auto& name : contents_.names) {
    if (!name.ends_with("/") || !manifest_->owns(name)) continue;
    for (const auto& file : numbered_files(path_ + "/" + name)) {
      if (!manifest_->owns(name + file)) foreign.push_back(name + file);
    }
  }
  sort_unique(foreign);
  if (!foreign.empty()) {
    throw InputError(path_ + ": this program did not write '" + join(foreign, "', '") +
                     "', or it was changed since; nothing is replaced; move it away, or use "
                     "another folder with --output");
  }
  remove_drafts(path_);
  if (earlier == Earlier::replace) remove_own();
  if (manifest_->what() == contents_.what && earlier == Earlier::keep) {
    manifest_->open(contents_.names);
  } else {
    manifest_->begin(contents_.what, contents_.names);
  }
  for (const auto& name : contents_.names) {
    if (name.ends_with("/")) fs::create_directories(path_ + "/" + name);
  }
}

void OutputFolder::add(const std::string& name) {
  on_first(comm_, path_, [&] {
    const std::string path = path_ + "/" + name.substr(0, name.size() - 1);
    if (fs::exists(fs::symlink_status(path)) && !manifest_->owns(name)) {
      throw InputError(path +
                       ": this program did not write it; nothing is replaced; move it away, or use "
                       "another folder with --output");
    }
    manifest_->open({&name, 1});
    fs::create_directories(path);
    remove_drafts(path);
  });
}

void OutputFolder::remove_own() {
  const auto names = manifest_->names();
  for (const auto& name : names) {
    if (name.ends_with("/")) {
      for (const auto& file : numbered_files(path_ + "/" + name)) {
        if (manifest_->owns(name + file)) fs::remove(path_ + "/" + name + file);
      }
    } else if (manifest_->owns(name)) {
      fs::remove(path_ + "/" + name);
    }
  }
  for (const auto& name : names) {
    if (manifest_->owns(name) && fs::is_empty(path_ + "/" + name)) fs::remove(path_ + "/" + name);
  }
}

bool OutputFolder::is_lost() {
  using Clock = std::chrono::steady_clock;
  if (!lock_ || is_lost_ || Clock::now() - looked_ < std::chrono::seconds(1)) return is_lost_;
  looked_ = Clock::now();
  is_lost_ = !lock_->held();
  return is_lost_;
}

OutputFolder::~OutputFolder() {
  if (lock_ && !lock_->held()) {
    if (status_) status_->abandon();
    return;
  }
  status_.reset();
  if (!manifest_) return;
  try {
    manifest_->seal();
  } catch (const std::exception&) {  // a full disk: the files stay ours by their names
  }
}

void OutputFolder::go_on() {
  go_on({{"status", "running"}});
}

void OutputFolder::go_on(const nlohmann::ordered_json& summary) {
  write_summary(comm_, path_ + "/summary.json", summary);
}

void OutputFolder::finish(const nlohmann::ordered_json& summary) {
  agree_after(comm_, [&] {
    if (rank_of(comm_) != 0) return;
    for (const auto& name : contents_.names) {
      std::error_code not_empty;
      if (name.ends_with("/")) fs::remove(path_ + "/" + name.substr(0, name.size() - 1), not_empty);
    }
    status_->finish(summary);
  });
}

void OutputFolder::fail(const std::exception& error) noexcept {
  fail(error, nlohmann::ordered_json::object());
}

void OutputFolder::fail(const std::exception& error, nlohmann::ordered_json summary) noexcept {
  try {
    if (all_here(comm_) && rank_of(comm_) != 0) return;
    summary["status"] = dynamic_cast<const Stopped*>(&error) != nullptr ? "stopped" : "failed";
    summary["error"] = message_of(error);
    if (lock_ && !lock_->held()) {
      status_->abandon();
      return;
    }
    status_->finish(summary);
  } catch (const std::exception&) {  // the error itself is on its way
  }
}

void mark_parent(MPI_Comm comm, const std::string& path) {
  on_first(comm, path, [&] {
    create(path);
    require_ours_or_empty(path);
    if (Manifest(path).exists()) return;
    // Parts of a campaign begin at the same moment: each writes a draft of its own, all the same text.
    const std::string draft = draft_of(path + "/" + std::to_string(std::random_device{}()));
    std::ofstream file(draft, std::ios::binary);
    file << Manifest::first_line(parts);
    file.close();
    const std::string mark = path + "/" + Manifest::file_name;
    if (!file || std::rename(draft.c_str(), mark.c_str()) != 0) {
      throw_io_error(mark, "cannot be created");
    }
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
