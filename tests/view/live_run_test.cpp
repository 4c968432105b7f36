#include "stylet/view/live_run.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/gather.hpp"
#include "stylet/view/publish.hpp"

#include "support/scenes.hpp"
#include "view/reference.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace stylet {
namespace {

LiveOptions reference(const std::vector<std::string>& overrides = {}) {
  std::vector<std::string> all{"time.step=10 ms"};
  all.insert(all.end(), overrides.begin(), overrides.end());
  return reference_options(all);
}

/// Until the tip stands there (m, as the scene's position), at the speed of the scene's own hand.
void push_to(LiveRun& run, double position) {
  run.want(Push{run.height(), 0.02});
  while (run.tip() < -position - 1e-9) run.step();
  run.want(Push{run.height(), 0});
}

std::vector<double> displacements(const LiveRun& run) {
  return gather_all(run.simulation().state().u.get());
}

TEST(LiveRun, LeavesTheSeedWhereTheScheduleDoes) {
  const double scheduled = placement_error(reference_scene());
  LiveRun run(MPI_COMM_WORLD, reference());
  EXPECT_FALSE(run.in_tissue());
  push_to(run, 0.035);
  EXPECT_TRUE(run.in_tissue());
  run.seed();
  run.step();
  Frame frame;
  publish(run, Colouring::none, frame);
  ASSERT_EQ(frame.seeds.size(), 1U);
  EXPECT_EQ(frame.seeds[0].target, "seed");
  // The two hands add up their steps in another way.
  EXPECT_NEAR(frame.seeds[0].error_at_rest.value(), scheduled, 1e-9);
  EXPECT_FALSE(frame.seeds[0].band);
  // Held where the target was, the needle has the seed there.
  EXPECT_LT(frame.seeds[0].error_now.value(), 1e-3);
}

TEST(LiveRun, UndoGoesBackToTheSameBits) {
  LiveRun run(MPI_COMM_WORLD, reference());
  push_to(run, 0.04);
  const auto before = displacements(run);
  const double time = run.simulation().time();
  run.seed();
  push_to(run, 0.037);
  EXPECT_EQ(run.simulation().seeds().size(), 1U);
  EXPECT_TRUE(run.undo());
  EXPECT_TRUE(run.simulation().seeds().empty());
  EXPECT_EQ(run.simulation().time(), time);
  EXPECT_EQ(displacements(run), before);
  EXPECT_TRUE(run.in_tissue());
  // Once more: the needle itself is undone.
  EXPECT_TRUE(run.undo());
  EXPECT_FALSE(run.in_tissue());
  for (const double u : displacements(run)) EXPECT_EQ(u, 0);
  EXPECT_FALSE(run.can_undo());
  EXPECT_FALSE(run.undo());
}

TEST(LiveRun, AfterAnUndoTheSameHandLeadsToTheSameBits) {
  LiveRun once(MPI_COMM_WORLD, reference());
  push_to(once, 0.04);
  once.seed();
  push_to(once, 0.038);
  LiveRun again(MPI_COMM_WORLD, reference());
  push_to(again, 0.04);
  again.seed();
  push_to(again, 0.035);
  again.undo();
  again.seed();
  push_to(again, 0.038);
  EXPECT_EQ(displacements(again), displacements(once));
}

TEST(LiveRun, TheHandIsNoFasterThanItsLimit) {
  LiveRun run(MPI_COMM_WORLD, reference());
  run.change("hand.speed_limit", 0.03);
  run.want(Aim{run.height(), -0.05});
  double last = run.tip();
  for (int i = 0; i < 200; ++i) {
    run.step();
    EXPECT_LE(std::abs(run.tip() - last), 0.03 * 0.01 * (1 + 1e-9));
    last = run.tip();
  }
  EXPECT_NEAR(run.tip(), -0.05, 1e-12);
}

TEST(LiveRun, StopsShortOfTheFarSide) {
  LiveRun run(MPI_COMM_WORLD, reference({"time.method=quasi_static"}));
  run.change("hand.speed_limit", 0.1);
  run.want(Aim{run.height(), 0.05});
  for (int i = 0; i < 200; ++i) run.step();
  EXPECT_LT(run.tip(), 0);
  EXPECT_THAT(run.notice(), testing::HasSubstr("far side"));
}

TEST(LiveRun, ASecondNeedleAtAnotherHeight) {
  LiveRun run(MPI_COMM_WORLD, reference({"time.method=quasi_static"}));
  push_to(run, 0.06);
  run.seed();
  run.want(Push{run.height(), -0.02});
  for (int i = 0; i < 300 && run.in_tissue(); ++i) run.step();
  ASSERT_FALSE(run.in_tissue());
  run.want(Push{0.027, 0.02});
  while (!run.in_tissue()) run.step();
  EXPECT_EQ(run.height(), 0.027);
  push_to(run, 0.06);
  run.seed();
  run.step();
  ASSERT_EQ(run.simulation().seeds().size(), 2U);
  EXPECT_EQ(run.simulation().seeds()[1].needle, "needle2");
  EXPECT_EQ(run.simulation().seeds()[1].target, "seed");  // the only one
}

TEST(LiveRun, ANeedleLeftBehindStaysOutside) {
  LiveRun run(MPI_COMM_WORLD, reference({"time.method=quasi_static"}));
  push_to(run, 0.065);
  run.want(Push{run.height(), -0.02});
  while (run.in_tissue()) run.step();
  for (int i = 0; i < 20; ++i) run.step();
  run.want(Push{run.height(), 0.02});  // back in, but
  run.step();
  ASSERT_FALSE(run.in_tissue());
  run.want(Push{0.027, 0.02});  // another one first
  for (int i = 0; i < 200; ++i) run.step();
  EXPECT_TRUE(run.in_tissue());
  EXPECT_EQ(run.simulation().needle()->parameters().name, "needle2");
}

TEST(LiveRun, ANumberChangesForThisNeedleAndTheNext) {
  LiveRun run(MPI_COMM_WORLD, reference({"time.method=quasi_static"}));
  const auto value = [&](const std::string& key) {
    const auto all = run.parameters();
    return std::ranges::find(all, key, &Changeable::key)->value;
  };
  run.change("needle.cutting.sharpness", 0.5);  // none has entered
  EXPECT_EQ(value("needle.cutting.sharpness"), 0.5);
  push_to(run, 0.06);
  EXPECT_EQ(run.simulation().needle()->parameters().cutting.sharpness, 0.5);
  run.change("needle.cutting.sharpness", 0.8);
  EXPECT_EQ(run.simulation().needle()->parameters().cutting.sharpness, 0.8);
  run.change("tissue.regions.prostate.youngs_modulus", 3e4);
  EXPECT_EQ(value("tissue.regions.prostate.youngs_modulus"), 3e4);
  run.change("needle.cutting.sharpness", 7);
  EXPECT_THAT(run.notice(), testing::HasSubstr("needle.cutting.sharpness"));
  EXPECT_EQ(value("needle.cutting.sharpness"), 0.8);
  run.restart();  // as the scene has it
  EXPECT_EQ(value("needle.cutting.sharpness"), 1);
  EXPECT_EQ(value("tissue.regions.prostate.youngs_modulus"), 6e4);
}

TEST(LiveRun, AnUndoneChangeIsNoMore) {
  LiveRun run(MPI_COMM_WORLD, reference({"time.method=quasi_static"}));
  push_to(run, 0.06);
  run.change("tissue.regions.prostate.youngs_modulus", 3e4);
  push_to(run, 0.055);
  const auto before = displacements(run);
  run.seed();
  run.change("tissue.regions.prostate.youngs_modulus", 9e4);
  push_to(run, 0.05);
  run.undo();
  EXPECT_EQ(displacements(run), before);
  EXPECT_EQ(run.simulation().scene().tissue.regions[0].material.youngs_modulus, 3e4);
}

TEST(LiveRun, HeightsStayWhileTheNeedleIsIn) {
  LiveRun run(MPI_COMM_WORLD, reference());
  const double height = run.height();
  push_to(run, 0.07);
  run.want(Push{height + 0.005, 0.02});
  run.step();
  EXPECT_EQ(run.height(), height);
}

TEST(LiveRun, RefusesWithoutAnError) {
  LiveRun run(MPI_COMM_WORLD, reference());
  run.seed();
  EXPECT_THAT(run.notice(), testing::HasSubstr("outside"));
  run.want(Push{0.2, 0.02});  // above the tissue
  for (int i = 0; i < 150; ++i) run.step();
  EXPECT_THAT(run.notice(), testing::HasSubstr("misses the tissue"));
  EXPECT_FALSE(run.in_tissue());
}

TEST(LiveRun, ExplicitStepsAreDampedByMass) {
  LiveRun run(MPI_COMM_WORLD, reference());
  run.choose_method("explicit");
  EXPECT_EQ(run.method(), "explicit");
  EXPECT_THAT(run.notice(), testing::HasSubstr("damped by mass"));
  push_to(run, 0.07);
  EXPECT_TRUE(run.in_tissue());
  run.choose_method("quasi_static");
  EXPECT_EQ(run.scene().tissue.damping->stiffness_factor, 0.05);
  EXPECT_FALSE(run.in_tissue());
}

TEST(LiveRun, NeedsANeedleToHold) {
  const std::string file = STYLET_SOURCE_DIR "/input/block.yaml";
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  EXPECT_THROW(LiveRun(MPI_COMM_WORLD, {{file, text.str()}}), InputError);
}

TEST(LiveRun, TraceStaysBounded) {
  Trace trace;
  for (int i = 0; i < 100000; ++i) trace.add({static_cast<double>(i)});
  EXPECT_LE(trace.samples().size(), 2048U);
  EXPECT_GT(trace.samples().size(), 1000U);
  EXPECT_EQ(trace.samples().front().time, 0);
  EXPECT_GT(trace.samples().back().time, 98000);
  // Evenly spaced, whatever was left out.
  const double gap = trace.samples()[1].time;
  for (std::size_t i = 1; i < trace.samples().size(); ++i) {
    EXPECT_EQ(trace.samples()[i].time - trace.samples()[i - 1].time, gap);
  }
}

}  // namespace
}  // namespace stylet
