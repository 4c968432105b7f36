#include "stylet/view/hand_input.hpp"

#include <gtest/gtest.h>

#include <array>
#include <numbers>

namespace stylet {
namespace {

/// 10 x 8 cm in a pane of 1000 x 800 pixels: 0.115 mm a pixel with the margin.
struct Screen {
  Screen() {
    constexpr std::array<float, 4> corners{0, 0, 0.1F, 0.08F};
    camera.show_in({0, 0, 1000, 800});
    camera.fit(corners);
    frame.needle_angle = std::numbers::pi;
    frame.height = 0.04;
    frame.tip = -0.11;
    frame.speed_limit = 0.04;
    frame.epoch = 1;
  }
  Camera camera;
  Frame frame;
  HandInput input;
};

TEST(Camera, GoesThereAndBack) {
  Screen screen;
  for (const Pixel p : {Pixel{0, 0}, Pixel{999, 3}, Pixel{500, 400}}) {
    const Pixel back = screen.camera.pixel_of(screen.camera.point_at(p));
    EXPECT_NEAR(back.x, p.x, 1e-9);
    EXPECT_NEAR(back.y, p.y, 1e-9);
  }
  EXPECT_NEAR(screen.camera.point_at(screen.camera.middle()).x, 0.05, 1e-8);
  // Up on the screen is up in the plane.
  EXPECT_GT(screen.camera.point_at({500, 0}).y, screen.camera.point_at({500, 800}).y);
}

TEST(Camera, ZoomKeepsThePointUnderTheMouse) {
  Screen screen;
  const Pixel mouse{200, 700};
  const WorldPoint before = screen.camera.point_at(mouse);
  const double scale = screen.camera.metres_per_pixel();
  screen.camera.zoom(2, mouse);
  EXPECT_NEAR(distance(screen.camera.point_at(mouse), before), 0, 1e-12);
  EXPECT_NEAR(screen.camera.metres_per_pixel(), 0.5 * scale, 1e-15);
}

TEST(Camera, DragTakesThePlaneAlong) {
  Screen screen;
  const WorldPoint x = screen.camera.point_at({100, 100});
  screen.camera.drag({100, 100}, {340, 60});
  EXPECT_NEAR(screen.camera.pixel_of(x).x, 340, 1e-9);
  EXPECT_NEAR(screen.camera.pixel_of(x).y, 60, 1e-9);
}

TEST(HandInput, ChoosesAHeightOutside) {
  Screen screen;
  screen.input.move(screen.camera.pixel_of({0.08, 0.031}), screen.frame, screen.camera);
  const auto wanted = screen.input.take();
  ASSERT_TRUE(wanted);
  EXPECT_NEAR(std::get<Push>(*wanted).height, 0.031, 1e-9);
  EXPECT_EQ(std::get<Push>(*wanted).speed, 0);
  EXPECT_FALSE(screen.input.take());
}

TEST(HandInput, TheTipGoesAsFarAsTheMouse) {
  Screen screen;
  const Pixel start{800, 300};
  screen.input.press(start, screen.frame, screen.camera);
  screen.input.move({700, 320}, screen.frame, screen.camera);
  const auto wanted = std::get<Aim>(*screen.input.take());
  // A hundred pixels to the left is as far into the tissue; the height stays that of the grip.
  EXPECT_NEAR(wanted.tip, -0.11 + 100 * screen.camera.metres_per_pixel(), 1e-12);
  EXPECT_NEAR(wanted.height, screen.camera.point_at(start).y, 1e-12);
  screen.input.release(screen.frame);
  EXPECT_EQ(std::get<Push>(*screen.input.take()).speed, 0);
  EXPECT_FALSE(screen.input.holds());
}

TEST(HandInput, ANeedleInTheTissueKeepsItsHeight) {
  Screen screen;
  screen.frame.needle.in_tissue = true;
  screen.input.move({500, 100}, screen.frame, screen.camera);
  EXPECT_FALSE(screen.input.take());
  screen.input.press({500, 100}, screen.frame, screen.camera);
  EXPECT_EQ(std::get<Aim>(*screen.input.take()).height, 0.04);
}

TEST(HandInput, AnUndoTakesTheNeedleOutOfTheHand) {
  Screen screen;
  screen.input.press({500, 100}, screen.frame, screen.camera);
  ++screen.frame.epoch;
  screen.frame.needle.in_tissue = true;
  (void)screen.input.take();
  screen.input.move({400, 100}, screen.frame, screen.camera);
  EXPECT_FALSE(screen.input.holds());
  EXPECT_FALSE(screen.input.take());
}

TEST(HandInput, TheArrowThatPointsIntoTheTissuePushes) {
  struct Case {
    double angle;
    HeldKeys push;
    HeldKeys higher;  ///< across, in the needle's coordinates
  };
  const HeldKeys left{.left = true};
  const HeldKeys right{.right = true};
  const HeldKeys up{.up = true};
  const HeldKeys down{.down = true};
  constexpr double pi = std::numbers::pi;
  for (const Case& c : {Case{pi, left, up}, Case{0, right, down}, Case{pi / 2, up, right},
                        Case{-pi / 2, down, left}}) {
    Screen screen;
    screen.frame.needle_angle = c.angle;
    screen.input.keys(c.push, screen.frame, 0.02);
    EXPECT_GT(std::get<Push>(*screen.input.take()).speed, 0) << c.angle;
    screen.input.keys({}, screen.frame, 0.02);  // let go: it stops
    EXPECT_EQ(std::get<Push>(*screen.input.take()).speed, 0) << c.angle;
    screen.input.keys(c.higher, screen.frame, 0.02);
    EXPECT_GT(std::get<Push>(*screen.input.take()).height, screen.frame.height) << c.angle;
  }
}

TEST(HandInput, PlacesAreThoseOfTheNeedle) {
  EXPECT_NEAR(place_of({0.03, 0.02}, std::numbers::pi).along, -0.03, 1e-15);
  EXPECT_NEAR(place_of({0.03, 0.02}, std::numbers::pi).height, 0.02, 1e-15);
  // From below: it advances along +y, and +x is across.
  const NeedlePlace below = place_of({0.03, 0.02}, std::numbers::pi / 2);
  EXPECT_NEAR(below.along, 0.02, 1e-15);
  EXPECT_NEAR(below.height, 0.03, 1e-15);
}

}  // namespace
}  // namespace stylet
