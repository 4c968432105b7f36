// The picture of a scene, its score, and what a plan proposes.
#include "stylet/simulation/picture.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/fingerprint.hpp"
#include "stylet/image/file.hpp"
#include "stylet/simulation/planned.hpp"
#include "stylet/simulation/score.hpp"

#include "support/scenes.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <unistd.h>

namespace stylet {
namespace {

std::string bytes_of(const Picture& picture) {
  return {picture.bytes.begin(), picture.bytes.end()};
}

double mean_of(const Picture& picture, ReferencePoint low, ReferencePoint high) {
  const Vector2 a = picture.texture_at(low);
  const Vector2 b = picture.texture_at(high);
  double sum = 0;
  int n = 0;
  for (int row = static_cast<int>(b.y * picture.height); row < a.y * picture.height; ++row) {
    for (int column = static_cast<int>(a.x * picture.width); column < b.x * picture.width;
         ++column) {
      sum += *picture.pixel(column, row);
      ++n;
    }
  }
  return sum / n;
}

TEST(Picture, ThatIsMadeHasTheSameBytesEverywhere) {
  const Simulation simulation(MPI_COMM_WORLD, reference_scene(), false);
  const Picture picture = picture_of(simulation.scene(), simulation.mesh());
  EXPECT_EQ(picture.width, 512);
  EXPECT_EQ(picture.height, 384);
  EXPECT_EQ(picture.channels, 1);
  EXPECT_EQ(picture.origin, (ReferencePoint{0, 0}));
  EXPECT_EQ(picture.size, (Vector2{0.08, 0.06}));
  EXPECT_EQ(fingerprint(bytes_of(picture)).substr(0, 16), "ee7c0d9e548c3b2e");
  // The gland is darker than what is around it, at the same distance from the probe.
  const double gland = mean_of(picture, {0.030, 0.028}, {0.045, 0.036});
  const double around = mean_of(picture, {0.066, 0.028}, {0.078, 0.036});
  EXPECT_LT(gland, 0.85 * around);
  EXPECT_GT(gland, 20);
}

TEST(Picture, FollowsItsKeys) {
  const auto made = [](const std::vector<std::string>& overrides) {
    const Simulation simulation(MPI_COMM_WORLD, reference_scene(overrides), false);
    return picture_of(simulation.scene(), simulation.mesh());
  };
  const Picture plain = made({});
  EXPECT_EQ(bytes_of(plain), bytes_of(made({"image.seed=1"})));
  EXPECT_NE(bytes_of(plain), bytes_of(made({"image.seed=2"})));
  const Picture dim = made({"image.attenuation=60 1/m"});
  const auto ratio = [](const Picture& p) {
    return mean_of(p, {0, 0.05}, {0.08, 0.06}) / mean_of(p, {0, 0}, {0.08, 0.01});
  };
  EXPECT_LT(ratio(dim), 0.5 * ratio(plain));
}

TEST(Picture, OfAFileIsThatFile) {
  const std::string folder = testing::TempDir() + "picture_" + std::to_string(::getpid());
  std::filesystem::create_directories(folder);
  Picture grey;
  grey.width = 3;
  grey.height = 2;
  grey.bytes = {0, 50, 100, 150, 200, 250};
  Picture colours = grey;
  colours.channels = 3;
  colours.bytes.assign(18, 7);
  colours.bytes[4] = 9;
  for (const Picture& given : {grey, colours}) {
    const std::string file = folder + "/p.png";
    std::ofstream(file, std::ios::binary) << png_of(given);
    const Scene scene = reference_scene(
        {"image.file=" + file, "image.origin=[1 cm, 2 cm]", "image.size=[3 cm, 2 cm]"});
    const Simulation simulation(MPI_COMM_WORLD, scene, false);
    const Picture read = picture_of(simulation.scene(), simulation.mesh());
    EXPECT_EQ(read.bytes, given.bytes);
    EXPECT_EQ(read.channels, given.channels);
    EXPECT_EQ(read.origin, (ReferencePoint{0.01, 0.02}));
    const auto refusal = [&](Scene bad) -> std::string {
      try {
        (void)picture_of(bad, simulation.mesh());
      } catch (const InputError& error) {
        return error.what();
      }
      return "";
    };
    Scene bad = scene;
    bad.image->origin = ReferencePoint{0.5, 0};
    EXPECT_THAT(refusal(bad), testing::HasSubstr("key 'image.origin'"));
    bad = scene;
    bad.image->size = Vector2{50, 50};
    EXPECT_THAT(refusal(bad), testing::HasSubstr("key 'image.size'"));
    bad = scene;
    bad.image->file = "nowhere.png";
    EXPECT_THAT(refusal(bad), testing::AllOf(testing::HasSubstr("key 'image.file'"),
                                             testing::HasSubstr("nowhere.png")));
    for (const std::size_t cut : {3U, 20U, 60U}) {
      std::ofstream(file, std::ios::binary) << png_of(given).substr(0, cut);
      EXPECT_THAT(refusal(scene), testing::HasSubstr("p.png"));
    }
  }
  std::filesystem::remove_all(folder);
  EXPECT_THROW((void)reference_scene({"image.file=p.png"}), InputError);
  EXPECT_THROW((void)reference_scene({"image.origin=[1 cm, 2 cm]"}), InputError);
}

TEST(Score, IsThatOfTheSeeds) {
  Simulation simulation(MPI_COMM_WORLD, reference_scene(), false);
  EXPECT_FALSE(score_of(simulation).mean_error);
  EXPECT_EQ(score_of(simulation).missed, std::vector<std::string>{"seed"});
  run_to_end(simulation);
  const Score score = score_of(simulation);
  ASSERT_EQ(score.seeds.size(), 1U);
  const double error = simulation.placement_errors().front();
  EXPECT_EQ(score.mean_error, error);
  EXPECT_EQ(score.largest_error, error);
  EXPECT_EQ(score.seeds[0].error_at_rest, error);
  EXPECT_NE(score.seeds[0].error_now, error);  // the needle still holds it
  EXPECT_EQ(score.largest_force, simulation.counts().peak_needle_force);
  EXPECT_EQ(score.time, simulation.time());
  EXPECT_TRUE(score.missed.empty());
  EXPECT_THAT(text_of(score), testing::HasSubstr("mm off"));
  EXPECT_EQ(json_of(score)["mean_error"], error);
}

TEST(PlannedWay, LeadsFromTheSkinToItsStops) {
  Scene scene = reference_scene();
  const Simulation simulation(MPI_COMM_WORLD, scene, false);
  const auto ways = ways_of(scene, simulation.mesh());
  ASSERT_EQ(ways.size(), 1U);
  EXPECT_NEAR(ways[0].skin.x, 0.08, 1e-9);
  EXPECT_EQ(ways[0].skin.y, 0.032);
  EXPECT_NEAR(ways[0].deepest.x, 0.035, 1e-15);
  ASSERT_EQ(ways[0].seeds.size(), 1U);
  EXPECT_EQ(ways[0].seeds[0].target, "seed");
  EXPECT_NEAR(ways[0].seeds[0].tip.x, 0.035, 1e-15);
}

}  // namespace
}  // namespace stylet
