#include "stylet/base/text.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

namespace stylet {
namespace {

TEST(Text, EditDistanceCountsChanges) {
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("plane", "plane"), 0u);
}

TEST(Text, NearestPicksTheFirstOfEquals) {
  const std::vector<std::string> keys = {"thickness", "plane", "plant"};
  EXPECT_EQ(nearest("plan", keys), "plane");
  EXPECT_EQ(nearest("thicknes", keys), "thickness");
  EXPECT_EQ(nearest("x", {}), "");
}

TEST(Text, JoinPutsCommas) {
  const std::vector<std::string> words = {"a", "b"};
  EXPECT_EQ(join(words), "a, b");
  EXPECT_EQ(join({}), "");
}

TEST(Text, ExactNumbersReadBackAsTheSameBits) {
  for (const double value : {0.1, 1.0 / 3, 5e-324, 1.7976931348623157e308, -0.0035, 60000.0}) {
    EXPECT_EQ(std::strtod(exact(value).c_str(), nullptr), value);
  }
  EXPECT_EQ(exact(0.06), "0.06");
}

TEST(Text, WhatIsRoundOffBesideItsSizeIsNothing) {
  EXPECT_EQ(cleared(-3.67e-18, 0.06), 0);
  EXPECT_EQ(cleared(6e-17, 1), 0);
  EXPECT_EQ(cleared(-1e-9, 1), -1e-9);
  EXPECT_EQ(cleared(5e-18, 1e-17), 5e-18);
  EXPECT_EQ(cleared(0.1, 0), 0.1);
}

}  // namespace
}  // namespace stylet
