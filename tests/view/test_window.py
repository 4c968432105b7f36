#!/usr/bin/python3
"""A needle in the hand of xdotool: heights, pushes, seeds, undo, and where the picture looks."""
from xdotool_hand import Hand, main, x


class Window(Hand):
    OPTIONS = ("--set", "time.method=quasi_static", "--set", "time.step=20 ms", "--size", "1000x700")

    def test_a_seed_by_hand(self):
        places = self.wait("a first picture", lambda p: p["needle"]["phase"] == "outside")
        # A height by moving the mouse.
        x("mousemove", *self.pixel(places, (0.06, 0.03)))
        places = self.wait("a height", lambda p: abs(p["needle"]["tip"][1] - 0.03) < 5e-4)
        scale = places["camera"]["metres_per_pixel"]
        # Push: the tip follows the mouse, as far as it went.
        start = self.pixel(places, (0.075, 0.03))
        end = (start[0] - round(0.05 / scale), start[1])
        tip = places["needle"]["tip"]
        self.drag(start, end)
        places = self.wait("the tip under the mouse",
                           lambda p: abs(p["needle"]["tip"][0] - (tip[0] - 0.05)) < 3 * scale)
        self.assertTrue(places["needle"]["in_tissue"])
        self.assertAlmostEqual(places["needle"]["tip"][1], 0.03, delta=5e-4)
        x("mouseup", 1)
        # A seed by the right button, the key U takes it away, Space leaves another.
        x("click", 3)
        self.wait("a seed", lambda p: len(p["seeds"]) == 1)
        x("key", "u")
        self.wait("no seed", lambda p: not p["seeds"])
        x("key", "space")
        places = self.wait("a seed again", lambda p: len(p["seeds"]) == 1)
        self.assertEqual(places["seeds"][0]["target"], "seed")
        # Out again by the keyboard: the arrow that points out of the tissue.
        x("keydown", "Right")
        places = self.wait("the needle outside", lambda p: not p["needle"]["in_tissue"])
        x("keyup", "Right")
        self.assertEqual(places["error"], "")
        # Zoom by the wheel, pan by the middle button.
        before = places["camera"]
        middle = self.pixel(places, before["centre"])
        x("mousemove", *middle, "click", 4)
        places = self.wait("a closer look",
                           lambda p: p["camera"]["metres_per_pixel"] < 0.95 * before["metres_per_pixel"])
        x("mousemove", *middle, "mousedown", 2, "mousemove", middle[0] + 50, middle[1], "mouseup", 2)
        moved = self.wait("another part", lambda p: p["camera"]["centre"][0] < before["centre"][0] - 1e-3)
        self.assertAlmostEqual(before["centre"][0] - moved["camera"]["centre"][0],
                               50 * moved["camera"]["metres_per_pixel"], delta=1e-4)
        # All anew.
        x("key", "r")
        self.wait("a new start", lambda p: not p["seeds"] and p["time"] < 60 and p["notice"] == "anew")


if __name__ == "__main__":
    main(__file__)
