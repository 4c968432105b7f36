// history.csv: one row a step, at the price of formatting some numbers.
#pragma once

#include "stylet/base/archive.hpp"
#include "stylet/base/fingerprint.hpp"
#include "stylet/output/text_file.hpp"

#include <mpi.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace stylet {

struct Column {
  std::string name;
  std::string unit;  ///< empty for counts and states
};

/// How far the file is, to go on from there.
struct HistoryPlace {
  std::uint64_t bytes = 0;       ///< 0 without one
  std::string fingerprint = {};  ///< of these bytes
};

void archive(Archive& archive, HistoryPlace& place);

/// Rank 0 writes; numbers are the shortest text that reads back to the same bits, whole numbers
/// have no exponent. A row reaches the operating system at the latest with the first row that comes
/// a tenth of a second later, so a killed run loses no more than what it computed in that time.
class HistoryWriter {
 public:
  /// Collective. The header is `name [unit]`. kept: of a file that is there, to go on behind it;
  /// throws InputError where it does not begin with just that, or has another header.
  HistoryWriter(MPI_Comm comm,
                const std::string& path,
                std::vector<Column> columns,
                const HistoryPlace& kept = {});
  HistoryWriter(const HistoryWriter&) = delete;
  HistoryWriter& operator=(const HistoryWriter&) = delete;
  ~HistoryWriter();

  /// Not collective and no communication; the row of ranks other than 0 is not used. A failure is
  /// kept for the next flush.
  void write(std::span<const double> row);
  /// Not collective. Whether this rank knows of a failure, so that the next flush will throw.
  [[nodiscard]] bool failed() const { return failure_.has_value(); }
  /// Collective. All ranks throw exit code `io` if a write failed since the start.
  void flush();
  /// Collective. flush, then waits for the disk. Of rank 0.
  HistoryPlace settle();
  /// Collective. settle, and no more rows.
  void close();

 private:
  void hand_over() noexcept;

  MPI_Comm comm_;
  std::size_t n_columns_;
  std::optional<TextFile> file_;  // rank 0
  std::uint64_t n_bytes_ = 0;     // rank 0, handed over
  Fingerprint sum_;               // of them
  std::string buffer_;
  std::optional<std::string> failure_;
  std::chrono::steady_clock::time_point handed_over_;
};

}  // namespace stylet
