// .stylet in a folder: says that the folder is this program's, and which files in it.
//
//   stylet 0.1.0 run
//   open history.csv            is being written, so what is there is ours
//   sealed history.csv 4f0c...  ours as long as it has this fingerprint
//
// Lines are only added, the last one of a name counts; the scripts in jobs read and write it too
// (jobs/own_files.py). A name that ends with / is a folder whose files have numbers for names.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

namespace stylet {

class Manifest {
 public:
  /// Of what stands in the folder; empty if that is nothing. Throws an IoError if it cannot be read.
  explicit Manifest(std::string folder);

  /// Whether this program has marked the folder.
  [[nodiscard]] bool exists() const { return exists_; }
  /// What it holds; empty if it is not marked.
  [[nodiscard]] const std::string& what() const { return what_; }
  /// Whether this program wrote what stands under this name. False where nothing stands.
  [[nodiscard]] bool owns(const std::string& name) const;
  /// Names that were written here, also those that are gone.
  [[nodiscard]] std::vector<std::string> names() const;

  /// A new one: the folder holds `what` and these names are about to be written.
  void begin(const std::string& what, std::span<const std::string> names);
  /// These names too.
  void open(std::span<const std::string> names);
  /// Fingerprints of everything that is open and there.
  void seal();

  static constexpr const char* file_name = ".stylet";
  /// Of a manifest; all of it where the folder holds no files of its own.
  [[nodiscard]] static std::string first_line(const std::string& what);

 private:
  void add(const std::string& lines) const;
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }

  std::string folder_;
  bool exists_ = false;
  std::string what_;
  std::map<std::string, std::string> entries_;  ///< name and fingerprint, which is empty if open
};

/// Names of files in a folder of numbered files that the manifest's names may stand for.
[[nodiscard]] std::vector<std::string> numbered_files(const std::string& folder);

/// SHA-256 of a file; of a large one, of its size, its first and its last bytes. Empty if it cannot
/// be read.
[[nodiscard]] std::string seal_of(const std::string& path);

}  // namespace stylet
