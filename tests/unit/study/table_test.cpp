#include "stylet/study/table.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/output/csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stylet {
namespace {

using Row = std::vector<std::string>;

TEST(Table, RowsComeBackWhateverIsInThem) {
  const Row header{"run", "error"};
  const Row row{"1", "a comma, a \"quote\"\nand a second line"};
  const Table table = read_csv("t.csv", csv_line(header) + csv_line(row));
  EXPECT_EQ(table.columns, header);
  EXPECT_THAT(table.rows, testing::ElementsAre(row));
  EXPECT_EQ(table.column("error"), 1U);
  EXPECT_THROW((void)table.column("other"), InputError);
}

// A killed program leaves a line without its end.
TEST(Table, UnfinishedLastLineIsLeftOut) {
  EXPECT_EQ(read_csv("t.csv", "a,b\n1,2\n3,").rows.size(), 1U);
  EXPECT_EQ(read_csv("t.csv", "a,b\n1,2\n3,4").rows.size(), 1U);
  EXPECT_EQ(read_csv("t.csv", "a,b\n1,2\n3,\"x\n").rows.size(), 1U);
  EXPECT_TRUE(read_csv("t.csv", "").columns.empty());
}

TEST(Table, ShortRowIsRefused) {
  EXPECT_THROW((void)read_csv("t.csv", "a,b\n1\n2,3\n"), InputError);
}

}  // namespace
}  // namespace stylet
