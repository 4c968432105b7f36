#include "stylet/output/summary.hpp"

#include "fixture.hpp"
#include <nlohmann/json.hpp>

#include <cmath>

namespace stylet {

namespace {

using testing::contents;
using Json = nlohmann::ordered_json;

TEST(FindNumber, FollowsDots) {
  const Json summary = {{"seeds", {{{"name", "a"}, {"placement_error", 0.0065}}, {{"n", 3}}}},
                        {"settled", true}};
  EXPECT_EQ(find_number(summary, "seeds.0.placement_error"), 0.0065);
  EXPECT_EQ(find_number(summary, "seeds.1.n"), 3.0);
  EXPECT_EQ(find_number(summary, "settled"), 1.0);
  for (const char* nothing : {"", ".", "seeds", "seeds.2.n", "seeds.x", "seeds.-1", "seeds.0.name",
                              "seeds.0.", "seeds.0.placement_error.x", "other"}) {
    EXPECT_EQ(find_number(summary, nothing), std::nullopt) << nothing;
  }
}

class Summary : public testing::FolderTest {};

TEST(FindNumber, NamesWithDotsStandInQuotes) {
  const nlohmann::ordered_json summary = {{"probes", {{"a.b", {1.5, 2.5}}}}};
  EXPECT_EQ(find_number(summary, R"(probes."a.b".1)"), 2.5);
  EXPECT_FALSE(find_number(summary, "probes.a.b.1"));
}

TEST_F(Summary, KeepsOrderAndReadsBack) {
  const Json summary = {{"z", 1.0 / 3}, {"a", std::nan("")}, {"name", "\xff"}};
  write_summary(MPI_COMM_WORLD, path("summary.json"), summary);
  const Json read = Json::parse(contents(path("summary.json")));
  EXPECT_EQ(read.begin().key(), "z");
  EXPECT_EQ(find_number(read, "z"), 1.0 / 3);
  EXPECT_TRUE(read.at("a").is_null());
}

}  // namespace

}  // namespace stylet
