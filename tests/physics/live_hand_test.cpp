#include "stylet/base/errors.hpp"
#include "stylet/simulation/hand.hpp"
#include "stylet/simulation/simulation.hpp"

#include "support/scenes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

namespace stylet {
namespace {

/// The reference scene, and the needle that its schedule would enter.
struct Live {
  explicit Live(const std::vector<std::string>& overrides = {"time.step=20 ms"}) {
    Scene scene = reference_scene(overrides);
    needle = scene.needles.front();
    scene.needles.clear();
    scene.time.until_implanted = false;
    auto owned = std::make_unique<LiveHand>();
    hand = owned.get();
    simulation =
        std::make_unique<Simulation>(MPI_COMM_WORLD, std::move(scene), false, std::move(owned));
  }
  void pass(int steps) {
    for (int i = 0; i < steps; ++i) simulation->step();
  }

  NeedleParameters needle;
  LiveHand* hand = nullptr;
  std::unique_ptr<Simulation> simulation;
};

TEST(LiveHand, LeavesTheSeedWhereTheScheduleDoes) {
  const double scheduled = placement_error(reference_scene());
  Live live(std::vector<std::string>{});
  live.hand->enter(live.needle);
  live.hand->move(0.02);
  live.pass(225);  // 4.5 cm in steps of 10 ms at 2 cm/s
  EXPECT_FALSE(live.simulation->done());
  EXPECT_NEAR(live.simulation->needle()->tip(), -0.035, 1e-12);
  live.hand->implant();
  live.hand->finish();
  live.pass(1);
  EXPECT_TRUE(live.simulation->done());
  ASSERT_EQ(live.simulation->seeds().size(), 1U);
  const auto& seed = live.simulation->seeds().front();
  EXPECT_EQ(seed.target, "seed");
  const double error = distance(live.simulation->place_of(seed).x, {0.035, 0.032});
  EXPECT_NEAR(error, scheduled, 1e-9);  // a sum of steps against their number times h
}

TEST(LiveHand, ANeedleMayEnterAtAnyTime) {
  Live early;
  Live late;
  late.pass(7);
  EXPECT_EQ(late.simulation->needle(), nullptr);
  EXPECT_NEAR(late.simulation->time(), 0.14, 1e-15);
  for (Live* live : {&early, &late}) {
    live->hand->enter(live->needle);
    live->hand->move(0.02);
    live->pass(20);
  }
  // Tissue that rests is the same at any time.
  EXPECT_EQ(late.simulation->needle()->tip(), early.simulation->needle()->tip());
  EXPECT_NEAR(late.simulation->counts().peak_needle_force,
              early.simulation->counts().peak_needle_force, 1e-12);  // N; round-off
}

TEST(LiveHand, OneNeedleAtATime) {
  Live live;
  live.hand->enter(live.needle);
  live.hand->move(0.02);
  live.pass(30);
  NeedleParameters second = live.needle;
  second.name = "second";
  live.hand->enter(second);
  try {
    live.pass(1);
    FAIL();
  } catch (const NumericalError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("needle 'second' enters while needle"));
  }
}

TEST(LiveHand, ASecondNeedleEntersWhenTheFirstIsOut) {
  Live live;
  live.hand->enter(live.needle);
  live.hand->move(0.02);
  live.pass(30);
  live.hand->move(-0.02);
  int steps = 0;
  while (!live.simulation->needle()->released() && ++steps < 200) live.pass(1);
  EXPECT_LT(steps, 200);
  NeedleParameters second = live.needle;
  second.name = "second";
  second.height += 5e-3;
  live.hand->enter(second);
  live.hand->move(0.02);
  live.pass(30);
  EXPECT_EQ(live.simulation->needle()->parameters().name, "second");
  EXPECT_EQ(live.simulation->needle()->tip_contact(), TipContact::cut);
}

TEST(LiveHand, ASeedNeedsANeedle) {
  Live live;
  live.hand->implant();
  EXPECT_THROW(live.pass(1), NumericalError);
}

// A scene's needles have been checked with it.
TEST(LiveHand, ANeedleOfItsOwnIsCheckedWhenItEnters) {
  const auto refused = [](auto&& fault) {
    Live live;
    fault(live.needle);
    live.hand->enter(live.needle);
    live.hand->move(0.02);
    try {
      live.pass(1);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  using testing::HasSubstr;
  using N = NeedleParameters;
  EXPECT_EQ(refused([](N& n) { n.motion.clear(); }), "no error");
  EXPECT_THAT(refused([](N& n) { n.cutting.sharpness = 2; }),
              HasSubstr("key 'needles.0.cutting.sharpness': value '2'; allowed: "));
  EXPECT_THAT(refused([](N& n) { n.diameter = -1e-3; }), HasSubstr("needles.0.diameter"));
  EXPECT_THAT(refused([](N& n) { n.friction->kinetic_force = 1e4; }),
              HasSubstr("key 'needles.0.friction.static_force'"));
}

}  // namespace
}  // namespace stylet
