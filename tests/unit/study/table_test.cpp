#include "stylet/study/table.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/fingerprint.hpp"
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

// As ResultsFile writes it.
std::string sealed(const std::string& plan, Row row) {
  row.push_back(Fingerprint().add(plan).add(csv_line(row)).text().substr(0, 16));
  return csv_line(row);
}

TEST(Table, AnEditedRowIsRefusedByName) {
  const std::string header = "run,status,value,fingerprint\n";
  const std::string good = sealed("plan", {"00000", "done", "1.5"});
  const Row row{"00001", "done", "2.5"};
  const std::string text = header + good + sealed("plan", row);
  const Table table = read_results("r.csv", text, "plan");
  EXPECT_EQ(table.columns, (Row{"run", "status", "value"}));
  EXPECT_EQ(table.rows.at(1), row);
  const auto refused = [](const std::string& changed, const std::string& plan) {
    try {
      (void)read_results("r.csv", changed, plan);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  // Any byte of the second row: its number, its status, its value, its fingerprint.
  for (std::size_t at = header.size() + good.size(); at + 1 < text.size(); ++at) {
    if (text[at] == ',') continue;
    std::string changed = text;
    changed[at] = changed[at] == '7' ? '8' : '7';
    EXPECT_THAT(refused(changed, "plan"),
                testing::AllOf(testing::StartsWith("r.csv: row 3, of run "),
                               testing::HasSubstr("is not as this study wrote it")))
        << changed;
  }
  // A row may be taken out; one of another study may not be put in.
  EXPECT_EQ(read_results("r.csv", header + sealed("plan", row), "plan").rows.size(), 1U);
  EXPECT_THAT(refused(text, "other"), testing::StartsWith("r.csv: row 2, of run 00000"));
  EXPECT_THAT(refused("run,value\n0,1\n", "plan"), testing::HasSubstr("'fingerprint'"));
  EXPECT_TRUE(read_results("r.csv", "", "plan").rows.empty());
}

}  // namespace
}  // namespace stylet
