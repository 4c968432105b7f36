// results.csv of a study: rows that survive a kill, read back to resume.
#pragma once

#include "stylet/output/text_file.hpp"

#include <mpi.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace stylet {

struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::string plan = {};  ///< fingerprint of the plan that the rows are results of

  /// Number of a column. Throws InputError if there is none of that name.
  [[nodiscard]] std::size_t column(const std::string& name) const;
};

/// A line that the writer did not finish, at the end, is left out. Throws InputError for rows that
/// have not as many fields as the header.
[[nodiscard]] Table read_csv(const std::string& path, const std::string& text);

/// The rows of a ResultsFile by this plan. Throws InputError that names the row for one that is not as it was
/// written, or was written by another plan: rows are taken for results.
[[nodiscard]] Table read_results(const std::string& path,
                                 const std::string& text,
                                 const std::string& plan);

/// Appends rows, each with its fingerprint; rank 0's file. A row is with the operating system when
/// `append` returns.
class ResultsFile {
 public:
  /// Collective. `kept`: rows of an earlier run that stay. The file is replaced as a whole, so that
  /// a kill leaves either the old or the new one.
  ResultsFile(MPI_Comm comm, std::string path, Table kept);

  /// Not collective; on rank 0.
  void append(const std::vector<std::vector<std::string>>& rows);
  /// Rows so far, on rank 0.
  [[nodiscard]] const Table& table() const { return table_; }
  /// Collective. Sorts the rows by their first column and closes the file.
  void finish();

 private:
  [[nodiscard]] std::string text() const;

  MPI_Comm comm_;
  std::string path_;
  Table table_;
  std::optional<TextFile> file_;
};

}  // namespace stylet
