#include "stylet/output/history.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/output/csv.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <exception>
#include <fstream>
#include <unistd.h>

namespace stylet {

namespace {

constexpr auto longest_delay = std::chrono::milliseconds(100);
constexpr std::size_t largest_buffer = std::size_t{1} << 20;

std::string title_of(const Column& column) {
  return column.unit.empty() ? column.name : column.name + " [" + column.unit + "]";
}

/// Cuts the file behind what is kept, which begins with this header. Returns the fingerprint of that.
Fingerprint cut_behind(const std::string& path,
                       const std::string& header,
                       const HistoryPlace& kept) {
  std::ifstream file(path, std::ios::binary);
  Fingerprint sum;
  std::string piece(header.size(), '\0');
  bool is_whole = kept.bytes >= header.size();
  for (std::uint64_t left = kept.bytes; left > 0 && is_whole; left -= piece.size()) {
    const bool is_first = left == kept.bytes;
    if (!is_first) piece.resize(std::min<std::uint64_t>(largest_buffer, left));
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    is_whole = file.good() && (!is_first || piece == header);
    sum.add(piece);
  }
  if (!is_whole || sum.text() != kept.fingerprint) {
    throw InputError(
        path +
        ": is not the history that the checkpoint goes on with: it was changed, replaced or cut "
        "short; put it back, or begin anew with --force");
  }
  if (::truncate(path.c_str(), static_cast<off_t>(kept.bytes)) != 0) {
    throw_io_error(path, "cannot be cut behind the rows of the checkpoint");
  }
  return sum;
}

}  // namespace

void archive(Archive& archive, HistoryPlace& place) {
  archive("bytes", place.bytes);
  archive("fingerprint", place.fingerprint);
}

HistoryWriter::HistoryWriter(MPI_Comm comm,
                             const std::string& path,
                             std::vector<Column> columns,
                             const HistoryPlace& kept)
    : comm_(comm), n_columns_(columns.size()), handed_over_(std::chrono::steady_clock::now()) {
  agree_after(comm, [&] {
    if (rank_of(comm) != 0) return;
    std::vector<std::string> titles;
    for (const Column& column : columns) titles.push_back(title_of(column));
    const std::string header = csv_line(titles);
    n_bytes_ = std::max<std::uint64_t>(kept.bytes, header.size());
    if (kept.bytes > 0) {
      sum_ = cut_behind(path, header, kept);
      file_.emplace(path, TextFile::Open::append);
      return;
    }
    file_.emplace(path);
    file_->write(header);
    sum_.add(header);
    file_->appear();
  });
}

HistoryWriter::~HistoryWriter() {
  hand_over();
}

void HistoryWriter::write(std::span<const double> row) {
  if (!file_ || failure_) return;
  if (row.size() != n_columns_) {
    throw Error(ExitCode::other, "history: a row of " + std::to_string(row.size()) +
                                     " numbers for " + std::to_string(n_columns_) + " columns");
  }
  append_csv_line(buffer_, row);
  if (buffer_.size() > largest_buffer ||
      std::chrono::steady_clock::now() - handed_over_ >= longest_delay) {
    hand_over();
  }
}

void HistoryWriter::hand_over() noexcept {
  if (!file_ || failure_ || buffer_.empty()) return;
  try {
    file_->write(buffer_);
    n_bytes_ += buffer_.size();
    sum_.add(buffer_);
  } catch (const std::exception& error) {
    failure_ = error.what();
  }
  buffer_.clear();
  handed_over_ = std::chrono::steady_clock::now();
}

void HistoryWriter::flush() {
  hand_over();
  agree_after(comm_, [&] {
    if (failure_) throw IoError(*failure_);
  });
}

HistoryPlace HistoryWriter::settle() {
  flush();
  agree_after(comm_, [&] {
    if (file_) file_->sync();
  });
  return {n_bytes_, sum_.text()};
}

void HistoryWriter::close() {
  settle();
  agree_after(comm_, [&] {
    if (!file_) return;
    file_->close();
    file_.reset();
  });
}

}  // namespace stylet
