#include "stylet/study/table.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/fingerprint.hpp"
#include "stylet/output/csv.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>

namespace stylet {

namespace {

/// The fields of one line starting at `at`, which moves behind it; none if the line has no end.
std::optional<std::vector<std::string>> next_line(const std::string& text, std::size_t& at) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = at; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c != '"') {
        fields.back() += c;
      } else if (i + 1 < text.size() && text[i + 1] == '"') {
        fields.back() += '"';
        ++i;
      } else {
        quoted = false;
      }
    } else if (c == '"') {
      quoted = true;
    } else if (c == ',') {
      fields.emplace_back();
    } else if (c == '\n') {
      at = i + 1;
      return fields;
    } else {
      fields.back() += c;
    }
  }
  return std::nullopt;
}

constexpr const char* fingerprint_column = "fingerprint";

/// Of a row and the plan it is a result of. So many digits tell any edit from what was written.
std::string seal_of(const std::string& plan, std::span<const std::string> row) {
  constexpr std::size_t digits = 16;
  return Fingerprint().add(plan).add(csv_line(row)).text().substr(0, digits);
}

std::string sealed_line(const std::string& plan, std::vector<std::string> row) {
  row.push_back(seal_of(plan, row));
  return csv_line(row);
}

}  // namespace

std::size_t Table::column(const std::string& name) const {
  const auto found = std::ranges::find(columns, name);
  if (found == columns.end()) throw InputError("the table has no column '" + name + "'");
  return static_cast<std::size_t>(found - columns.begin());
}

Table read_csv(const std::string& path, const std::string& text) {
  Table table;
  std::size_t at = 0;
  while (auto fields = next_line(text, at)) {
    if (table.columns.empty()) {
      table.columns = std::move(*fields);
    } else if (fields->size() == table.columns.size()) {
      table.rows.push_back(std::move(*fields));
    } else {
      throw InputError(path + ": row " + std::to_string(table.rows.size() + 2) + " has " +
                       std::to_string(fields->size()) + " fields; allowed: " +
                       std::to_string(table.columns.size()) + ", as in the header");
    }
  }
  return table;
}

Table read_results(const std::string& path, const std::string& text, const std::string& plan) {
  Table table = read_csv(path, text);
  table.plan = plan;
  if (table.columns.empty()) return table;
  if (table.columns.back() != fingerprint_column) {
    throw InputError(path + ": its last column is '" + table.columns.back() + "' instead of '" +
                     fingerprint_column + "': it was not written by this version");
  }
  table.columns.pop_back();
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    auto& row = table.rows[i];
    const std::string seal = std::move(row.back());
    row.pop_back();
    if (seal == seal_of(plan, row)) continue;
    throw InputError(path + ": row " + std::to_string(i + 2) + ", of run " + row.front() +
                     ", is not as this study wrote it; take the row out to compute it again, or "
                     "replace the study with --force");
  }
  return table;
}

ResultsFile::ResultsFile(MPI_Comm comm, std::string path, Table kept)
    : comm_(comm), path_(std::move(path)), table_(std::move(kept)) {
  write_text_atomically(comm_, path_, text());
  agree_after(comm_, [&] {
    if (rank_of(comm_) == 0) file_.emplace(path_, TextFile::Open::append);
  });
}

void ResultsFile::append(const std::vector<std::vector<std::string>>& rows) {
  std::string lines;  // one write, so that a kill cannot part the rows of one run
  for (const auto& row : rows) lines += sealed_line(table_.plan, row);
  file_->write(lines);
  table_.rows.insert(table_.rows.end(), rows.begin(), rows.end());
}

void ResultsFile::finish() {
  std::ranges::stable_sort(table_.rows, {}, [](const auto& row) { return row.front(); });
  if (file_) file_->close();
  write_text_atomically(comm_, path_, text());
}

std::string ResultsFile::text() const {
  std::vector<std::string> columns = table_.columns;
  columns.emplace_back(fingerprint_column);
  std::string lines = csv_line(columns);
  for (const auto& row : table_.rows) lines += sealed_line(table_.plan, row);
  return lines;
}

}  // namespace stylet
