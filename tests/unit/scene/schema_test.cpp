#include "stylet/scene/schema.hpp"

#include <gmock/gmock.h>

#include <algorithm>

namespace stylet {
namespace {

using testing::Contains;
using testing::HasSubstr;

std::vector<std::string> paths() {
  std::vector<std::string> result;
  for (const SchemaRow& row : schema_rows()) result.push_back(row.path);
  return result;
}

TEST(Schema, EveryKeyIsDocumentedInOneLine) {
  for (const auto& [path, key] : schema_rows()) {
    EXPECT_FALSE(key->doc.empty()) << path;
    EXPECT_EQ(key->doc.find('\n'), std::string::npos) << path;
    EXPECT_FALSE(key->type.empty()) << path;
  }
}

TEST(Schema, KeysAreUniqueAndReachEveryDepth) {
  auto all = paths();
  EXPECT_THAT(all, Contains("needles[].cutting.tip_length"));
  EXPECT_THAT(all, Contains("needles[].motion[].insert.speed"));
  EXPECT_THAT(all, Contains("tissue.regions.REGION.youngs_modulus"));
  EXPECT_THAT(all, Contains("mesh.rectangle.inner_regions[].ellipse.centre"));
  EXPECT_THAT(all, Contains("loads.traction[].force"));
  std::ranges::sort(all);
  EXPECT_EQ(std::ranges::adjacent_find(all), all.end());
}

TEST(Schema, DefaultsAreThoseOfTheStructs) {
  const std::string text = schema_text();
  EXPECT_THAT(text, HasSubstr("tissue.thickness\n    Extent out of plane.\n    number in m: > 0 m; "
                              "default: 0.01 m\n"));
  EXPECT_THAT(text, HasSubstr("choice: stress, strain; default: required for triangles, "));
  EXPECT_THAT(text, HasSubstr("choice: implicit, explicit, quasi_static; default: implicit"));
}

TEST(Schema, MarkdownHasOneLineAKey) {
  const std::string table = schema_markdown();
  const auto n_lines = std::ranges::count(table, '\n');
  EXPECT_EQ(static_cast<std::size_t>(n_lines), schema_rows().size() + 2);
  EXPECT_THAT(table, HasSubstr("| `time.step` |"));
}

}  // namespace
}  // namespace stylet
