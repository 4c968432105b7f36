// Notes: what they name, and that good runs have none.
#include "stylet/simulation/notes.hpp"

#include "stylet/base/errors.hpp"

#include "pierced.hpp"
#include "support/scenes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace stylet {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

TEST(Notes, NameTheStrainWhereItIsLarge) {
  // 4 mm on 4 cm: 10 % everywhere.
  const auto peak_of = [](const std::string& displacement) {
    Simulation simulation(MPI_COMM_WORLD,
                          scene_of(stretched, {"prescribed.0.displacement.0=" + displacement}),
                          false);
    run_to_end(simulation);
    return std::pair(simulation.largest_strain().anywhere.value, notes_of(simulation));
  };
  const auto [small, none] = peak_of("4 mm");
  EXPECT_NEAR(small, 0.1, 1e-9);
  EXPECT_THAT(none, IsEmpty());
  const auto [large, one] = peak_of("20 mm");
  EXPECT_NEAR(large, 0.5, 1e-9);
  EXPECT_THAT(
      one, testing::ElementsAre(AllOf(HasSubstr("strain exceeded 50 % on"), HasSubstr("at t = "))));
}

TEST(Notes, NameTrianglesThatAreTurnedOver) {
  // A block of 4 cm, pushed together evenly: by less than its length none, by more all.
  const auto of = [](const std::string& displacement) {
    Simulation simulation(MPI_COMM_WORLD,
                          scene_of(stretched, {"prescribed.0.displacement.0=" + displacement}),
                          false);
    run_to_end(simulation);
    return std::pair(simulation.turned_over(), notes_of(simulation));
  };
  const auto [none, before] = of("-39 mm");
  EXPECT_EQ(none.triangles, 0);
  EXPECT_THAT(before, Not(testing::Contains(HasSubstr("turned over"))));
  const auto [all, after] = of("-41 mm");
  EXPECT_EQ(all.triangles, 16);
  EXPECT_NEAR(all.area, 8e-4, 1e-12);
  EXPECT_THAT(after, testing::Contains(AllOf(HasSubstr("16 triangles were turned over"),
                                             HasSubstr("100 % of the tissue"))));
}

TEST(Notes, AreRare) {
  Simulation reference(MPI_COMM_WORLD, reference_scene(), false);
  run_to_end(reference);
  EXPECT_THAT(notes_of(reference), IsEmpty());
  // Elements at the tip are strained, and would be more so on a finer mesh.
  EXPECT_GT(reference.largest_strain().anywhere.value, 0.3);
  EXPECT_LT(reference.largest_strain().widespread.value, 0.3);
  // Tissue that is as soft as jelly under the same needle.
  Simulation soft(MPI_COMM_WORLD, scene_of(pierced, {"tissue.regions.tissue.youngs_modulus=4 kPa"}),
                  false);
  while (soft.seeds().empty()) {
    try {
      soft.step();
    } catch (const NumericalError&) {
      break;
    }
  }
  EXPECT_THAT(notes_of(soft), testing::Contains(HasSubstr("away from the needle")));
}

TEST(Notes, SeedsAtAMembraneThatASmallErrorBreaks) {
  Simulation reference(MPI_COMM_WORLD, reference_scene(), false);
  while (reference.counts().needle.punctures == 0) reference.step();
  const double broken = -reference.needle()->tip();  // x of the tip
  const auto notes_at = [&](double x) {
    Simulation simulation(
        MPI_COMM_WORLD,
        reference_scene({"needles.0.motion.0.insert.position=" + std::to_string(x) + " m"}), false);
    run_to_end(simulation);
    return notes_of(simulation);
  };
  EXPECT_THAT(notes_at(broken + 3e-4), testing::Contains(HasSubstr("that break it")));
  EXPECT_THAT(notes_at(broken - 3e-4), testing::Contains(HasSubstr("just broken a membrane")));
  EXPECT_THAT(notes_at(broken - 5e-3), Not(testing::Contains(HasSubstr("membrane"))));
  // On the way out, in front of where it broke.
  Scene scene = reference_scene();
  Action back = scene.needles[0].motion[0];
  back.kind = ActionKind::retract;
  back.position = broken + 2e-3;
  scene.needles[0].motion.insert(scene.needles[0].motion.begin() + 1, back);
  Simulation simulation(MPI_COMM_WORLD, scene, false);
  run_to_end(simulation);
  ASSERT_EQ(simulation.seeds().size(), 1U);
  EXPECT_THAT(notes_of(simulation), Not(testing::Contains(HasSubstr("membrane"))));
}

TEST(Notes, SeedsThatAreNotAtRest) {
  const auto notes = [](const std::string& end) {
    Simulation simulation(
        MPI_COMM_WORLD,
        scene_of(pierced, {motion("insert: {speed: 4 cm/s, depth: 2.5 cm}, implant: {}" + end),
                           "mesh.refine=1"}),
        false);
    run_to_end(simulation);
    return notes_of(simulation);
  };
  EXPECT_THAT(notes(""), testing::Contains(HasSubstr("is still in")));
  EXPECT_THAT(notes(", retract: {speed: 2 m/s}"), testing::Contains(HasSubstr("still moves")));
  EXPECT_THAT(notes(", retract: {speed: 4 cm/s}, settle: {}"), IsEmpty());
}

// Notes of a run of the pierced tissue with these changes.
std::vector<std::string> notes_with(const std::vector<std::string>& overrides) {
  Simulation simulation(MPI_COMM_WORLD, scene_of(pierced, overrides), false);
  run_to_end(simulation);
  return notes_of(simulation);
}

TEST(Notes, SayHowLateALaggedCutIs) {
  const std::string law = "needles.0.cutting.law=lagged";
  // 2 cm/s in steps of 40 ms: 0.8 mm.
  EXPECT_THAT(notes_with({law, "time.step=40 ms"}), testing::Contains(HasSubstr("mm late")));
  EXPECT_THAT(notes_with({law, "time.step=1 ms"}), Not(testing::Contains(HasSubstr("mm late"))));
  EXPECT_THAT(notes_with({"time.step=40 ms"}), Not(testing::Contains(HasSubstr("mm late"))));
}

TEST(Notes, SayWhatIncrementsCost) {
  const auto increments = testing::Contains(HasSubstr("cuts by increments"));
  EXPECT_THAT(notes_with({"needles.0.cutting.law=increment", "needles.0.cutting.increment=2 mm"}),
              increments);
  EXPECT_THAT(notes_with({}), Not(increments));
}

// The run ends as soon as the tissue is still.
TEST(Notes, NameWhatBeginsAfterTheEnd) {
  const auto never = [](const std::string& what) {
    return testing::Contains(AllOf(HasSubstr(what), HasSubstr("it has never acted")));
  };
  EXPECT_THAT(notes_with({"loads={body: [{force: [0 N/m^3, -9810 N/m^3], start: 1e3 s}]}"}),
              never("loads.body.0 begins at t = 1000 s"));
  EXPECT_THAT(
      notes_with({"loads={traction: [{curve: right, force: [1 N/m, 0 N/m], start: 1e3 s}]}"}),
      never("loads.traction.0"));
  EXPECT_THAT(notes_with({"supports.left=free",
                          "prescribed=[{curve: left, displacement: [1 mm, 0 mm], start: 1e3 s}]"}),
              never("prescribed.0"));
  EXPECT_THAT(notes_with({"loads={body: [{force: [0 N/m^3, -9810 N/m^3], start: 0.1 s}]}"}),
              Not(never("")));
}

TEST(Notes, SayWhatCoarseElementsAtTheTipCost) {
  const auto coarse = testing::Contains(HasSubstr("elements at the tip were"));
  EXPECT_THAT(notes_with({}), coarse);
  EXPECT_THAT(notes_with({"mesh.refine=2"}), Not(coarse));
}

TEST(Notes, PlainTrianglesLock) {
  const auto notes = [](const std::string& nu, const std::string& formulation) {
    const Simulation simulation(
        MPI_COMM_WORLD,
        scene_of(stretched, {"tissue.plane=strain", "tissue.regions.tissue.poisson_ratio=" + nu,
                             "tissue.formulation=" + formulation}),
        false);
    return notes_of(simulation);
  };
  EXPECT_THAT(notes("0.46", "p1"), testing::ElementsAre(HasSubstr("locks in plane strain")));
  EXPECT_THAT(notes("0.45", "p1"), IsEmpty());
  EXPECT_THAT(notes("0.49", "p1_averaged"), IsEmpty());
}

}  // namespace
}  // namespace stylet
