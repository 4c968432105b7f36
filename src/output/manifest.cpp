#include "stylet/output/manifest.hpp"

#include "stylet/base/fingerprint.hpp"
#include "stylet/output/text_file.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace stylet {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t largest_end = 256 * 1024;  // bytes; as in jobs/own_files.py

/// 00012.yaml, 00012.h5, frame_0012.png.
bool is_numbered(std::string name) {
  if (name.starts_with("frame_")) name.erase(0, 6);
  const auto digits =
      std::ranges::find_if_not(name, [](unsigned char c) { return std::isdigit(c); });
  const std::string end(digits, name.end());
  return digits - name.begin() >= 4 &&
         (end == ".yaml" || end == ".cbor" || end == ".png" || end == ".h5");
}

/// summary.json, scenes/, frames/overview.png: nothing that leads out of the folder.
bool is_inside(const std::string& name) {
  const auto slash = name.find('/');
  const auto is_plain = [](const std::string& part) {
    return !part.empty() && !part.starts_with(".") && part.find('/') == std::string::npos;
  };
  if (slash == std::string::npos) return is_plain(name);
  const std::string rest = name.substr(slash + 1);
  return is_plain(name.substr(0, slash)) && (rest.empty() || is_plain(rest));
}

bool is_file(const std::string& path) {
  return fs::is_regular_file(fs::symlink_status(path));
}

}  // namespace

std::vector<std::string> numbered_files(const std::string& folder) {
  std::vector<std::string> names;
  if (!fs::is_directory(fs::symlink_status(folder))) return names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const auto name = entry.path().filename().string();
    if (is_numbered(name) && is_file(entry.path())) names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

std::string seal_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return {};
  const auto size = static_cast<std::size_t>(file.tellg());
  Fingerprint seal;
  std::string bytes;
  const auto add = [&](std::size_t from, std::size_t to) {
    bytes.resize(to - from);
    file.seekg(static_cast<std::streamoff>(from));
    file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    seal.add(bytes);
  };
  if (size <= 2 * largest_end) {
    add(0, size);
  } else {
    add(0, largest_end);
    add(size - largest_end, size);
    seal.add(std::to_string(size));
  }
  return file ? seal.text() : std::string();
}

Manifest::Manifest(std::string folder) : folder_(std::move(folder)) {
  if (!is_file(path(file_name))) return;
  std::ifstream file(path(file_name));
  if (!file) throw_io_error(path(file_name), "cannot be read");
  std::string line;
  std::getline(file, line);
  exists_ = line.starts_with("stylet ");
  if (exists_) what_ = line.substr(line.rfind(' ') + 1);
  while (exists_ && std::getline(file, line)) {
    std::istringstream words(line);
    std::string state;
    std::string name;
    std::string seal;
    words >> state >> name >> seal;
    const bool is_entry = state == "open" || (state == "sealed" && !seal.empty());
    if (is_entry && is_inside(name)) entries_[name] = seal;
  }
}

bool Manifest::owns(const std::string& name) const {
  const auto entry = entries_.find(name);
  if (name.ends_with("/")) {
    return entry != entries_.end() &&
           fs::is_directory(fs::symlink_status(path(name.substr(0, name.size() - 1))));
  }
  if (!is_file(path(name))) return false;
  if (entry != entries_.end()) return entry->second.empty() || entry->second == seal_of(path(name));
  // A numbered file counts as long as its folder is open.
  const auto slash = name.find('/');
  if (slash == std::string::npos || !is_numbered(name.substr(slash + 1))) return false;
  const auto holder = entries_.find(name.substr(0, slash + 1));
  return holder != entries_.end() && holder->second.empty();
}

std::vector<std::string> Manifest::names() const {
  std::vector<std::string> names;
  for (const auto& [name, seal] : entries_) names.push_back(name);
  return names;
}

std::string Manifest::first_line(const std::string& what) {
  return std::string("stylet ") + STYLET_VERSION + " " + what + "\n";
}

void Manifest::begin(const std::string& what, std::span<const std::string> names) {
  entries_.clear();
  std::string text = first_line(what);
  for (const auto& name : names) {
    text += "open " + name + "\n";
    entries_[name].clear();
  }
  TextFile file(path(file_name));
  file.write(text);
  file.close();
  file.appear();
  exists_ = true;
  what_ = what;
}

void Manifest::open(std::span<const std::string> names) {
  std::string lines;
  for (const auto& name : names) {
    lines += "open " + name + "\n";
    entries_[name].clear();
  }
  add(lines);
}

void Manifest::seal() {
  std::string lines;
  for (auto& [name, seal] : std::map(entries_)) {
    if (!seal.empty()) continue;
    std::vector<std::string> files{name};
    if (name.ends_with("/")) {
      files = numbered_files(path(name));
      for (auto& file : files) file = name + file;
      lines += "sealed " + name + " -\n";
      entries_[name] = "-";
    }
    for (const auto& file : files) {
      if (!is_file(path(file))) continue;
      entries_[file] = seal_of(path(file));
      if (!entries_[file].empty()) lines += "sealed " + file + " " + entries_[file] + "\n";
    }
  }
  add(lines);
}

void Manifest::add(const std::string& lines) const {
  if (lines.empty()) return;
  TextFile file(path(file_name), TextFile::Open::append);
  file.write(lines);
  file.close();
}

}  // namespace stylet
