// An HDF5 file that can be read whenever the program that writes it dies.
//
// HDF5 changes a group in place and by several writes: whoever is killed between two of them leaves a
// file of which nothing can be read. So this file has two root groups with the same links. What is new
// is linked into the one that the superblock does not name; then the superblock names that one, by a
// single small write; then the other one follows and is named again. Everything else is written to
// where nothing was. (HDF5 File Format Specification, II.A: version 0 of the superblock.)
#pragma once

#include "stylet/output/hdf5.hpp"

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace stylet {

/// Every failure throws an IoError with HDF5's reason. One process owns it.
class CommittedFile {
 public:
  /// anew: replaces an old file. go_on: with one that this class wrote. Others may read it at any time.
  enum class Open { anew, go_on };
  explicit CommittedFile(std::string path, Open how = Open::anew);
  CommittedFile(const CommittedFile&) = delete;
  CommittedFile& operator=(const CommittedFile&) = delete;
  ~CommittedFile();

  /// Of the root, where it has none of this name; before the first commit.
  template <class Value>
  void set_root_attribute(const std::string& name, const Value& value) {
    for (const hid_t root : {root_.get(), twin_.get()}) {
      if (H5Aexists(root, name.c_str()) <= 0) set_attribute(root, name, value);
    }
  }
  /// A group of the root, which nobody sees before `commit`; lent until then.
  [[nodiscard]] hid_t create_group(const std::string& name);
  /// Hands all to the operating system and shows the new groups, all at once.
  void commit();
  /// Of the groups of the root.
  [[nodiscard]] std::vector<std::string> names() const;
  /// What is there; path: without the root.
  [[nodiscard]] Hdf5Id open(const std::string& path) const;
  /// These groups of the root go, all at once.
  void remove(std::span<const std::string> names);
  /// Waits for the disk.
  void sync() const;
  void close();

 private:
  void link_as_root(hid_t twin) const;
  void link_pending(hid_t root);
  void unlink(hid_t root, std::span<const std::string> names) const;
  void flush();
  void name_root(hid_t root);

  std::string path_;
  Hdf5Id file_;
  Hdf5Id root_;  ///< HDF5's own
  Hdf5Id twin_;
  int descriptor_ = -1;
  std::vector<std::pair<std::string, Hdf5Id>> pending_;
};

}  // namespace stylet
