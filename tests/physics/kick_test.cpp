// Kick test: velocities disturbed once in mid-insertion must not change where the needle ends up. A
// friction force whose sign is taken from the last step would stay wrong for ever after a kick.
#include "support/body.hpp"
#include "support/scenes.hpp"
#include <gtest/gtest.h>

#include <ostream>

namespace stylet {
namespace {

struct KickCase {
  std::string law;
  std::string scheme;
  std::string step;
  double outwards;  ///< added to velocities in the middle of the tissue, along +x (m/s)
  double inwards;
  friend std::ostream& operator<<(std::ostream& out, const KickCase& c) {
    return out << c.law << " " << c.scheme;
  }
};

struct Outcome {
  double error = 0;           ///< m
  double least_friction = 0;  ///< N; of the tenth of a second after the kick
};

Outcome outcome_of(const KickCase& c, double kick) {
  const auto scene = reference_scene(
      {"needles.0.cutting.law=" + c.law, "time.scheme=" + c.scheme, "time.step=" + c.step});
  Simulation simulation(MPI_COMM_WORLD, scene, false);
  Outcome outcome;
  constexpr double middle_of_insertion = 1.1;
  bool kicked = false;
  run_to_end(simulation, [&](const StepRecord& record) {
    if (kicked && record.t < middle_of_insertion + 0.1) {
      outcome.least_friction = std::min(outcome.least_friction, record.needle.forces.friction);
    }
    if (kicked || record.t < middle_of_insertion) return;
    kicked = true;
    const OwnedVec field = nodal(simulation.tissue(), simulation.mesh(), [&](ReferencePoint x) {
      return Vector2{kick * x.x * x.y * (0.06 - x.y) / (0.04 * 0.03 * 0.03), 0};  // 0 where held
    });
    check(VecAXPY(simulation.state().v.get(), 1, field.get()));
  });
  outcome.error = simulation.placement_errors().at(0);
  return outcome;
}

class Kick : public testing::TestWithParam<KickCase> {};

// The strong stiffness damping lets backward Euler forget small kicks within a step, so they are
// large. Generalised-alpha forgets them as quickly, and shows friction at the ends of its steps: what an
// outward kick of 1 m/s leaves there is 0.19, -0.68 and -2.07 N in steps of 20, 10 and 5 ms, with lumped
// mass the same to 0.01 N. Steps of 5 ms see that friction was reversed. The scheme turns a velocity that it does not resolve into a displacement of about
// the step times it; an outward kick of 3 m/s already makes the needle cut more than it would have
// in the rest of its way, and cuts do not heal.
INSTANTIATE_TEST_SUITE_P(Laws,
                         Kick,
                         testing::Values(KickCase{"consistent", "backward_euler", "10 ms", 20, -20},
                                         KickCase{"consistent", "generalised_alpha", "5 ms", 1, -5},
                                         KickCase{"lagged", "backward_euler", "10 ms", 20, -20},
                                         KickCase{"lagged", "generalised_alpha", "5 ms", 1, -5}));

TEST_P(Kick, DoesNotChangeThePlacement) {
  const double undisturbed = outcome_of(GetParam(), 0).error;
  const Outcome out = outcome_of(GetParam(), GetParam().outwards);
  const Outcome in = outcome_of(GetParam(), GetParam().inwards);
  RecordProperty("undisturbed_mm", std::to_string(1e3 * undisturbed));
  RecordProperty("after_out_um", std::to_string(1e6 * (out.error - undisturbed)));
  RecordProperty("after_in_um", std::to_string(1e6 * (in.error - undisturbed)));
  // The kick was felt: friction, 1.3 N before it, was reversed.
  RecordProperty("least_friction_N",
                 std::to_string(std::min(out.least_friction, in.least_friction)));
  EXPECT_LT(std::min(out.least_friction, in.least_friction), -1);
  // Seen: 0.3 um with the consistent law, 0.1 to 3 um with the lagged one, which cuts a step later by
  // what the kick did to the tip. Both are below the 12 um by which the error jitters with depth
  // anyway; a wrong sign that stays moves it by millimetres. (Where two nodes ahead are as good, the
  // least kick can decide which one becomes the tip: 20 hand-overs instead of 19, and 3 um, in this scene
  // in steps of 10 ms.)
  const double tolerance = GetParam().law == "consistent" ? 2e-6 : 1e-5;
  EXPECT_NEAR(out.error, undisturbed, tolerance);
  EXPECT_NEAR(in.error, undisturbed, tolerance);
}

}  // namespace
}  // namespace stylet
