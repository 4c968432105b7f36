#include "stylet/needle/motion.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace stylet {

namespace {

Action moving(ActionKind kind, double speed, std::optional<double> depth) {
  Action a;
  a.kind = kind;
  a.speed = speed;
  a.depth = depth;
  return a;
}

Action waiting(ActionKind kind, std::optional<double> duration) {
  Action a;
  a.kind = kind;
  a.duration = duration;
  return a;
}

/// The skin stands at x = 8 cm and the needle goes to -x: along = -x.
Motion entered(std::vector<Action> actions) {
  Motion motion(std::move(actions));
  motion.enter(-0.08, -1);
  return motion;
}

std::vector<NeedleStep> all_steps(Motion& motion, double longest) {
  std::vector<NeedleStep> steps;
  while (!motion.finished() && steps.size() < 1000) {
    steps.push_back(motion.next(longest));
    motion.taken(steps.back());
  }
  return steps;
}

TEST(Motion, EqualStepsThatHitTheEnd) {
  Motion motion = entered({moving(ActionKind::insert, 0.02, 0.01)});
  const auto steps = all_steps(motion, 0.03);
  ASSERT_EQ(steps.size(), 17U);  // 0.5 s in steps of at most 0.03 s
  for (const auto& step : steps) EXPECT_EQ(step.h, steps[0].h);
  EXPECT_NEAR(steps[0].h, 0.5 / 17, 1e-16);  // the depth is a difference of positions
  EXPECT_EQ(steps.back().to, -0.08 + 0.01);  // exactly, whatever the sum of the steps
  EXPECT_EQ(motion.tip(), -0.08 + 0.01);
  for (std::size_t i = 1; i < steps.size(); ++i) EXPECT_EQ(steps[i].from, steps[i - 1].to);
  // The last step makes up for the round-off of the others.
  for (const auto& step : steps) EXPECT_NEAR(step.speed(), 0.02, 1e-14);
}

TEST(Motion, MoreStepsThanAnIntCounts) {
  Motion motion = entered({moving(ActionKind::insert, 0.02, 0.06), waiting(ActionKind::hold, 3)});
  const NeedleStep step = motion.next(1e-9);  // 3e9 of them
  EXPECT_NEAR(step.h, 1e-9, 1e-18);
  motion.taken(step);
  EXPECT_EQ(motion.index(), 0U);
  EXPECT_NEAR(motion.next(1e-9).h, 1e-9, 1e-18);
}

TEST(Motion, WholeNumberOfStepsIsNotSplit) {
  Motion motion = entered({moving(ActionKind::insert, 0.02, 0.03)});
  EXPECT_EQ(all_steps(motion, 0.05).size(), 30U);  // 1.5 / 0.05 is a bit above 30 in binary
}

TEST(Motion, PositionIsACoordinateOfTheScene) {
  Action insert = moving(ActionKind::insert, 0.02, std::nullopt);
  insert.position = 0.035;
  Motion motion = entered({insert});
  EXPECT_EQ(all_steps(motion, 0.1).back().to, -0.035);
}

TEST(Motion, RetractToADepthAndOut) {
  Motion motion =
      entered({moving(ActionKind::insert, 0.02, 0.02), moving(ActionKind::retract, 0.01, 0.005),
               moving(ActionKind::retract, 0.04, std::nullopt)});
  while (motion.index() == 0) motion.taken(motion.next(0.1));
  EXPECT_EQ(motion.tip(), -0.06);
  const NeedleStep back = motion.next(0.1);
  EXPECT_NEAR(back.speed(), -0.01, 1e-15);
  while (motion.index() == 1) motion.taken(motion.next(0.1));
  EXPECT_EQ(motion.tip(), -0.075);
  // All the way out has no end of its own.
  EXPECT_EQ(motion.awaits(), Awaited::withdrawal);
  for (int i = 0; i < 50; ++i) {
    const NeedleStep out = motion.next(0.1);
    EXPECT_EQ(out.h, 0.1);
    motion.taken(out);
  }
  EXPECT_FALSE(motion.finished());
  motion.taken(motion.next(0.1), true);
  EXPECT_TRUE(motion.finished());
}

TEST(Motion, InsertToWhereTheTipIsIsOverAtOnce) {
  const Action nothing = moving(ActionKind::insert, 0.02, 0.0);
  const Motion motion = entered({nothing, nothing, moving(ActionKind::insert, 0.02, 0.01)});
  EXPECT_EQ(motion.index(), 2U);
  EXPECT_TRUE(entered({nothing}).finished());
}

TEST(Motion, ImplantsTakeNoTime) {
  const Action implant = waiting(ActionKind::implant, std::nullopt);
  Motion motion = entered({moving(ActionKind::insert, 0.02, 0.01), implant, implant});
  while (motion.action().kind == ActionKind::insert) motion.taken(motion.next(0.1));
  EXPECT_TRUE(motion.will_implant());
  motion.implanted();
  EXPECT_FALSE(motion.will_implant());
  motion.implanted();
  EXPECT_TRUE(motion.finished());
}

TEST(Motion, HoldAndSettle) {
  Motion motion = entered({waiting(ActionKind::hold, 0.25), waiting(ActionKind::settle, 0.1),
                           waiting(ActionKind::settle, std::nullopt)});
  double held = 0;
  while (motion.index() == 0) {
    const NeedleStep step = motion.next(0.1);
    EXPECT_EQ(step.to, step.from);
    held += step.h;
    motion.taken(step);
  }
  EXPECT_NEAR(held, 0.25, 1e-16);
  motion.taken(motion.next(0.1));
  EXPECT_EQ(motion.index(), 2U);
  for (int i = 0; i < 10; ++i) motion.taken(motion.next(0.1));
  EXPECT_EQ(motion.index(), 2U);  // until the tissue is still
  EXPECT_EQ(motion.awaits(), Awaited::rest);
  motion.taken(motion.next(0.1), true);
  EXPECT_TRUE(motion.finished());
}

TEST(Motion, ShorterStepsOnTheWay) {
  // An explicit method may ask for less in the middle; the rest is divided again.
  Motion motion = entered({moving(ActionKind::insert, 0.02, 0.01)});
  motion.taken(motion.next(0.1));
  motion.taken(motion.next(0.1));
  std::vector<double> rest;
  while (!motion.finished()) {
    const NeedleStep step = motion.next(0.07);
    rest.push_back(step.h);
    motion.taken(step);
  }
  EXPECT_EQ(rest.size(), 5U);  // 0.3 s in steps of at most 0.07 s
  EXPECT_EQ(motion.tip(), -0.08 + 0.01);
}

}  // namespace

}  // namespace stylet
