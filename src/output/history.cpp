#include "stylet/output/history.hpp"

#include "stylet/output/csv.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"

#include <exception>

namespace stylet {

namespace {

constexpr auto longest_delay = std::chrono::milliseconds(100);
constexpr std::size_t largest_buffer = std::size_t{1} << 20;
std::string title_of(const Column& column) {
  return column.unit.empty() ? column.name : column.name + " [" + column.unit + "]";
}

}  // namespace

HistoryWriter::HistoryWriter(MPI_Comm comm, const std::string& path, std::vector<Column> columns)
    : comm_(comm), n_columns_(columns.size()), handed_over_(std::chrono::steady_clock::now()) {
  agree_after(comm, [&] {
    if (rank_of(comm) != 0) return;
    std::vector<std::string> titles;
    for (const Column& column : columns) titles.push_back(title_of(column));
    file_.emplace(path);
    file_->write(csv_line(titles));
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
