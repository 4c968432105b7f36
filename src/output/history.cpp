#include "stylet/output/history.hpp"

#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <exception>

namespace stylet {

namespace {

constexpr auto longest_delay = std::chrono::milliseconds(100);
constexpr std::size_t largest_buffer = std::size_t{1} << 20;
constexpr double largest_whole = 9007199254740992.0;  // 2^53: all whole numbers below are exact

void append_title(std::string& text, const Column& column) {
  const std::string title =
      column.unit.empty() ? column.name : column.name + " [" + column.unit + "]";
  if (title.find_first_of(",\"\n") == std::string::npos) {
    text += title;
    return;
  }
  text += '"';
  for (const char c : title) text.append(c == '"' ? 2 : 1, c);
  text += '"';
}

}  // namespace

void append_number(std::string& text, double value) {
  std::array<char, 32> digits;  // the longest double has 24 characters
  const bool whole = std::abs(value) < largest_whole && value == std::trunc(value);
  const auto end = whole
                       ? std::to_chars(digits.begin(), digits.end(), static_cast<long long>(value))
                       : std::to_chars(digits.begin(), digits.end(), value);
  text.append(digits.data(), end.ptr);
}

HistoryWriter::HistoryWriter(MPI_Comm comm, const std::string& path, std::vector<Column> columns)
    : comm_(comm), n_columns_(columns.size()), handed_over_(std::chrono::steady_clock::now()) {
  agree_after(comm, [&] {
    if (rank_of(comm) != 0) return;
    std::string header;
    for (const Column& column : columns) {
      if (!header.empty()) header += ',';
      append_title(header, column);
    }
    file_.emplace(path);
    file_->write(header + '\n');
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
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (i > 0) buffer_ += ',';
    append_number(buffer_, row[i]);
  }
  buffer_ += '\n';
  if (buffer_.size() > largest_buffer ||
      std::chrono::steady_clock::now() - handed_over_ >= longest_delay) {
    hand_over();
  }
}

void HistoryWriter::hand_over() noexcept {
  if (!file_ || failure_ || buffer_.empty()) return;
  try {
    file_->write(buffer_);
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

void HistoryWriter::close() {
  hand_over();
  agree_after(comm_, [&] {
    if (failure_) throw IoError(*failure_);
    if (!file_) return;
    file_->sync();
    file_->close();
    file_.reset();
  });
}

}  // namespace stylet
