#include "stylet/base/archive.hpp"

#include "stylet/base/errors.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <vector>

namespace stylet {
namespace {

using ::testing::HasSubstr;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

Archive::Columns stored(std::vector<double> field) {
  Archive archive({});
  archive.array("body/u", field, 2);
  return archive.columns();
}

TEST(Archive, StoresNumbersOnly) {
  EXPECT_NO_THROW((void)stored({1, 2}));
  EXPECT_THROW((void)stored({1, nan}), NumericalError);
  EXPECT_THROW((void)stored({-infinity, 1}), NumericalError);
  Archive archive({});
  double limit = infinity;  // of what has none
  EXPECT_NO_THROW(archive("limit", limit));
  double force = nan;
  EXPECT_THROW(archive("force", force), NumericalError);
}

TEST(Archive, LoadsNumbersOnly) {
  for (const double wrong : {nan, infinity}) {
    auto columns = stored({1, 2});
    std::get<std::vector<double>>(columns["body/u"].values)[1] = wrong;
    Archive archive({}, columns);
    std::vector<double> field(2);
    try {
      archive.array("body/u", field, 2);
      FAIL() << wrong;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("'body/u'"));
    }
  }
}

}  // namespace
}  // namespace stylet
