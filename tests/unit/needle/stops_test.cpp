// Lists of actions that go backwards or leave the tissue.
#include "stylet/needle/stops.hpp"

#include <gmock/gmock.h>

namespace stylet {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// The needle goes to -x from a skin at x = 8 cm: along = -x.
constexpr double skin = -0.08;

Action to_depth(ActionKind kind, double depth) {
  Action a;
  a.kind = kind;
  a.speed = 0.02;
  a.depth = depth;
  return a;
}
Action to_position(ActionKind kind, double position) {
  Action a = to_depth(kind, 0);
  a.depth.reset();
  a.position = position;
  return a;
}
Action only(ActionKind kind) {
  Action a;
  a.kind = kind;
  a.speed = 0.02;
  return a;
}

std::string fault_of(const std::vector<Action>& actions, bool skin_known = true) {
  const auto fault = find_fault(actions, -1, skin, skin_known);
  return fault ? std::to_string(fault->action) + ": " + fault->reason : "none";
}

using enum ActionKind;

TEST(Stops, GoodListsPass) {
  EXPECT_EQ(fault_of({to_depth(insert, 0.04), only(implant), to_depth(retract, 0.02), only(implant),
                      to_position(insert, 0.03), only(retract), only(settle)}),
            "none");
  // From the outside in again, and all of it in other words.
  EXPECT_EQ(fault_of({to_position(insert, 0.05), only(retract), to_depth(insert, 0.01),
                      to_position(retract, 0.09), to_position(insert, 0.04), only(implant)}),
            "none");
}

TEST(Stops, NoLengthIsNoMotion) {
  EXPECT_EQ(fault_of({to_depth(insert, 0.05), to_position(insert, 0.03), to_position(retract, 0.03),
                      to_depth(retract, 0.05), only(implant)}),
            "none");
  EXPECT_TRUE(is_no_motion(skin + 0.05, -0.03));
  EXPECT_FALSE(is_no_motion(skin, skin + 1e-9));
  EXPECT_TRUE(is_no_motion(0, 0));
}

TEST(Stops, InsertGoesInAndRetractOut) {
  EXPECT_THAT(fault_of({to_depth(insert, 0.04), to_depth(insert, 0.02)}),
              HasSubstr("1: ends at depth 0.02 m, and the tip is deeper already, at depth 0.04 m"));
  EXPECT_THAT(fault_of({to_depth(insert, 0.02), to_depth(retract, 0.04)}),
              HasSubstr("1: ends at depth 0.04 m, deeper than the tip is then, at depth 0.02 m"));
  EXPECT_THAT(fault_of({to_position(insert, 0.03), to_depth(insert, 0.04)}),
              HasSubstr("at position 0.03 m, depth 0.05 m"));
  EXPECT_THAT(fault_of({to_depth(insert, 0.04), only(retract), to_depth(retract, 0.01)}),
              HasSubstr("2: ends at depth 0.01 m"));
}

TEST(Stops, NeedlesStopInTheTissue) {
  EXPECT_THAT(fault_of({to_position(insert, 0.09)}),
              HasSubstr("0: ends at position 0.09 m, 0.01 m in front of the entry point"));
  EXPECT_THAT(fault_of({to_depth(insert, 0), only(implant)}), HasSubstr("1: the tip is not in"));
  EXPECT_THAT(fault_of({to_depth(insert, 0.04), only(retract), only(implant)}),
              HasSubstr("2: the tip is not in the tissue then"));
  EXPECT_THAT(fault_of({to_depth(insert, 0.04), to_position(retract, 0.085), only(implant)}),
              AllOf(HasSubstr("2: the tip is not in"), HasSubstr("0.005 m in front")));
}

TEST(Stops, WhatDependsOnTheSkinWaitsForIt) {
  EXPECT_EQ(fault_of({to_position(insert, 0.09)}, false), "none");
  EXPECT_EQ(fault_of({to_position(insert, 0.03), to_depth(insert, 0.04)}, false), "none");
  EXPECT_THAT(fault_of({to_position(insert, 0.03), to_position(insert, 0.04)}, false),
              HasSubstr("1: ends at position 0.04 m"));
  EXPECT_THAT(fault_of({to_depth(insert, 0.02), to_depth(retract, 0.04)}, false),
              HasSubstr("1: ends"));
}

}  // namespace
}  // namespace stylet
