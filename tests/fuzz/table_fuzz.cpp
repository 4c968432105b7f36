#include "stylet/output/csv.hpp"
#include "stylet/study/table.hpp"

#include "fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stylet;
  fuzz::may_refuse([&] {
    const Table table = read_csv("t", fuzz::text_of(data, size));
    if (table.columns.empty()) return;
    std::string text = csv_line(table.columns);
    for (const auto& row : table.rows) text += csv_line(row);
    const Table again = read_csv("t", text);
    fuzz::require(again.columns == table.columns && again.rows == table.rows, "a table reads back");
    (void)table.column("status");
  });
  return 0;
}
