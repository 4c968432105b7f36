#include "stylet/view/live_session.hpp"

#include "stylet/base/errors.hpp"

#include "view/reference.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace stylet {
namespace {

LiveOptions reference(const std::vector<std::string>& overrides = {}) {
  std::vector<std::string> all{"time.method=quasi_static"};
  all.insert(all.end(), overrides.begin(), overrides.end());
  return reference_options(all);
}

/// Takes frames until one is so; none after a minute, however slow the machine.
template <class Condition>
std::optional<Frame> wait_for(LiveSession& session, Condition&& is_so) {
  constexpr double patience = 60;  // s
  Frame frame;
  for (const double start = clock_seconds(); clock_seconds() - start < patience;) {
    if (session.take(frame) && is_so(frame)) return frame;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return std::nullopt;
}

TEST(LiveSession, TheNeedleFollowsTheHandWhileTimePasses) {
  LiveSession session(MPI_COMM_WORLD, reference());
  const auto first = wait_for(session, [](const Frame&) { return true; });
  ASSERT_TRUE(first);
  EXPECT_EQ(first->reference.size(), first->displacement.size());
  EXPECT_EQ(first->triangles.size(), 3U * 1226);
  session.want(Aim{0.03, -0.06});
  const auto there =
      wait_for(session, [](const Frame& frame) { return std::abs(frame.tip + 0.06) < 1e-9; });
  ASSERT_TRUE(there);
  EXPECT_TRUE(there->needle.in_tissue);
  EXPECT_EQ(there->height, 0.03);
  EXPECT_GT(there->largest_displacement, 1e-4);
  EXPECT_GT(there->time, first->time);
  EXPECT_GT(there->number, first->number);
}

TEST(LiveSession, StandsStillWhilePaused) {
  LiveSession session(MPI_COMM_WORLD, reference());
  session.pause(true);
  // A frame made after the pause was heard of.
  (void)wait_for(session, [](const Frame& frame) { return frame.number > 3; });
  const auto early = wait_for(session, [](const Frame&) { return true; });
  ASSERT_TRUE(early);
  const auto late =
      wait_for(session, [&](const Frame& frame) { return frame.number > early->number + 5; });
  ASSERT_TRUE(late);
  EXPECT_EQ(late->time, early->time);
  session.pause(false);
  EXPECT_TRUE(wait_for(session, [&](const Frame& frame) { return frame.time > late->time + 0.1; }));
}

TEST(LiveSession, AnErrorIsShownAndUndone) {
  LiveSession session(MPI_COMM_WORLD, reference());
  session.want(Push{0.032, 0.04});
  ASSERT_TRUE(wait_for(session, [](const Frame& frame) { return frame.needle.in_tissue; }));
  session.order([](LiveRun&) { throw NumericalError("the step has no answer"); });
  const auto stopped = wait_for(session, [](const Frame& frame) { return !frame.error.empty(); });
  ASSERT_TRUE(stopped);
  EXPECT_EQ(stopped->error, "the step has no answer");
  EXPECT_TRUE(stopped->can_undo);
  session.order([](LiveRun& run) { run.undo(); });
  const auto undone = wait_for(session, [](const Frame& frame) { return frame.error.empty(); });
  ASSERT_TRUE(undone);
  EXPECT_FALSE(undone->needle.in_tissue);
  EXPECT_GT(undone->epoch, stopped->epoch);
  // It goes on.
  EXPECT_TRUE(wait_for(session, [&](const Frame& frame) { return frame.time > undone->time; }));
}

TEST(LiveSession, TellsWhatCannotBegin) {
  EXPECT_THROW(LiveSession(MPI_COMM_WORLD, reference({"supports.left=null", "supports.top=null",
                                                      "supports.bottom=null"})),
               InputError);
}

TEST(LiveSession, EndsWithTheScore) {
  LiveSession session(MPI_COMM_WORLD, reference());
  session.order([](LiveRun& run) {
    run.want(Push{run.height(), 0.04});
    for (int i = 0; i < 200; ++i) run.step();
    run.seed();
    run.step();
  });
  ASSERT_TRUE(wait_for(session, [](const Frame& frame) { return frame.seeds.size() == 1; }));
  EXPECT_THAT(session.end(), testing::HasSubstr("seed"));
}

}  // namespace
}  // namespace stylet
