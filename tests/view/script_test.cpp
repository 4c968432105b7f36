#include "stylet/view/script.hpp"

#include "stylet/base/errors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stylet {
namespace {

std::string refusal(const std::string& text) {
  try {
    (void)read_script("hand.txt", text);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(Script, ReadsTimesCommandsAndArguments) {
  const auto lines = read_script(
      "hand.txt", "# a hand\n0 s: height 3.2 cm\n\n250 ms:insert 2 cm/s # in\n1 s: seed\n");
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0].command, "height");
  EXPECT_EQ(lines[0].argument, "3.2 cm");
  EXPECT_EQ(lines[1].time, 0.25);
  EXPECT_EQ(lines[1].argument, "2 cm/s");
  EXPECT_EQ(lines[1].where, "hand.txt:4");
  EXPECT_EQ(lines[2].argument, "");
}

TEST(Script, RefusesWithItsPlace) {
  EXPECT_THAT(refusal("0 s height 1 cm"), testing::HasSubstr("hand.txt:1"));
  EXPECT_THAT(refusal("0: seed"), testing::HasSubstr("unit"));
  EXPECT_THAT(refusal("0 s: fly"), testing::HasSubstr("'fly' is no command; allowed: height"));
  EXPECT_THAT(refusal("1 s: seed\n0.5 s: seed"), testing::HasSubstr("goes back"));
}

}  // namespace
}  // namespace stylet
