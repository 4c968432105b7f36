#!/usr/bin/python3
"""The panel and the messages under a real mouse: sliders, the box of an error, the error of a seed with its
band, and what is said of a seed that cannot be trusted; in the numbers and in the pictures."""
import json
import math
import subprocess

from stylet_cli import AS_ROOT, DONE, PROGRAM
from xdotool_hand import PATIENCE, Hand, main, os, x

LARGE = ("--size", "1280x790")
ORANGE = (255, 191, 64)  # of warnings
CUTTING = "needle.cutting.cutting_force"
MODULUS = "tissue.regions.prostate.youngs_modulus"


def lit(pixels):
    """Pixels of letters."""
    return int((pixels.min(axis=2) > 150).sum())


def orange(pixels):
    return int((abs(pixels - ORANGE).sum(axis=2) < 60).sum())


def grab(pixels):
    """Where the handle of a slider is, 0 to 1."""
    blue = (pixels[:, :, 2] > 200) & (pixels[:, :, 0] < 120)
    columns = blue.nonzero()[1]
    return columns.mean() / pixels.shape[1]


class Panel(Hand):
    OPTIONS = LARGE

    def at_rest(self, key):
        """Where a slider stays: rows above it come with the first pictures."""
        last = self.look()
        return self.wait(f"{key} at rest", lambda p: key in p["widgets"] and p["widgets"][key] == last["widgets"].get(key)
                         or last.update(p))

    def drag_slider(self, places, key, share):
        left, top, width, height = places["widgets"][key]
        middle = (round(left + width / 2), round(top + height / 2))
        self.drag(middle, (round(left + share * width), middle[1]), pieces=5)
        self.look()  # a picture later the slider has followed
        x("mouseup", 1)

    def value_at(self, places, key, share):
        """Of a slider of ratios; its handle has a width."""
        parameter = places["parameters"][key]
        width = places["widgets"][key][2]
        rest = (share * width - 7) / (width - 14)
        return parameter["low"] * (parameter["high"] / parameter["low"]) ** rest

    def test_an_error_with_its_band_and_sliders(self):
        places = self.take_needle(0.032)
        self.assertEqual(places["method"], "implicit")
        # A slider of the needle to come.
        places = self.at_rest(CUTTING)
        before = self.picture_of(places, CUTTING)
        self.assertAlmostEqual(grab(before), 0.5, delta=0.06)
        wanted = self.value_at(places, CUTTING, 0.4)
        self.drag_slider(places, CUTTING, 0.4)
        places = self.wait("another cutting force", lambda p: p["parameters"][CUTTING]["value"] != 1.7)
        value = places["parameters"][CUTTING]["value"]
        self.assertAlmostEqual(math.log(value / wanted), 0, delta=0.1)
        x("key", "r")  # as the scene has it
        places = self.wait("a new start", lambda p: p["parameters"][CUTTING]["value"] == 1.7)
        places = self.take_needle(places["targets"]["seed"][1])
        places = self.drag_needle(places, places["needle"]["tip"][0] - places["targets"]["seed"][0])
        x("click", 3)
        places = self.wait("a seed", lambda p: len(p["seeds"]) == 1)
        seed = places["seeds"][0]
        self.assertEqual(seed["turned_over"], 0)
        self.assertAlmostEqual(seed["error_at_rest"], 6.2e-3, delta=0.6e-3)
        self.assertAlmostEqual(seed["band"], 0.31e-3, delta=0.02e-3)  # the stored study's
        band = self.picture_of(places, "band of seed")
        self.assertGreater(lit(band), 30)
        self.assertNotIn("distrust of seed", places["widgets"])
        # A slider further down, while the needle is in.
        left, top, width, height = places["widgets"][CUTTING]
        x("mousemove", round(left - 20), round(top), "click", "--repeat", 8, 5)
        camera = places["camera"]
        places = self.at_rest(MODULUS)
        self.assertEqual(places["camera"], camera)  # the wheel was the panel's
        wanted = self.value_at(places, MODULUS, 0.7)
        self.drag_slider(places, MODULUS, 0.7)
        places = self.wait("stiffer tissue", lambda p: p["parameters"][MODULUS]["value"] != 6e4)
        value = places["parameters"][MODULUS]["value"]
        self.assertAlmostEqual(math.log(value / wanted), 0, delta=0.1)
        # The band was that of the scene as it is written.
        self.assertNotIn("band", places["seeds"][0])
        x("click", "--repeat", 12, 4)
        places = self.wait("the top of the panel", lambda p: "band of seed" in p["widgets"])
        unknown = self.picture_of(places, "band of seed")
        self.assertTrue(unknown.shape != band.shape or abs(unknown - band).max() > 100)
        out = self.end()
        self.assertIn("method: implicit (the scene's", out)
        self.assertIn("mm off", out)
        self.assertIn("'needle1' is still in", out)
        rows = (self.folder / "record-1/procedure.yaml").read_text()
        self.assertIn(MODULUS, rows)


class ErrorBox(Hand):
    OPTIONS = (*LARGE, "--set", "time.method=quasi_static", "--set", "time.step=20 ms", "--set",
               "needles.0.cutting.law=increment", "--set", "needles.0.cutting.increment=0.41 mm")

    def test_a_step_without_an_answer(self):
        # The hand's limit is twice the scene's speed, and further in a step than the law cuts.
        places = self.take_needle(0.032)
        places = self.drag_needle(places, 0.05)
        self.assertIn("cuts 0.00041 m at most", places["error"])
        # In the first picture a box may only learn its size.
        places = self.wait("the box of the error", lambda p: "error" in p["widgets"]
                           and orange(self.picture_of(p, "error")) > 200)
        still = self.look()
        self.assertEqual(still["time"], places["time"])
        self.assertTrue(still["error"])
        left, top, width, height = places["widgets"]["undo after an error"]
        x("mousemove", round(left + width / 2), round(top + height / 2), "click", 1)
        undone = self.wait("an undo", lambda p: not p["error"])
        self.assertFalse(undone["needle"]["in_tissue"])
        self.assertNotIn("error", undone["widgets"])
        self.wait("time that goes on", lambda p: p["time"] > undone["time"])


class BeyondSmallStrain(Hand):
    OPTIONS = (*LARGE, "--set", "time.method=quasi_static", "--set", "time.step=10 ms", "--set",
               "tissue.regions.prostate.youngs_modulus=15 kPa", "--set",
               "tissue.regions.surrounding.youngs_modulus=15 kPa")

    def test_is_said_by_picture_score_and_replay(self):
        places = self.take_needle(0.032)
        self.drag_needle(places, 0.054)
        x("click", 3)
        places = self.wait("a seed", lambda p: len(p["seeds"]) == 1)
        self.assertGreater(places["seeds"][0]["turned_over"], 0)
        self.assertGreater(orange(self.picture_of(places, "distrust of seed")), 100)
        x("keydown", "Right")
        places = self.wait("the needle outside", lambda p: not p["needle"]["in_tissue"])
        x("keyup", "Right")
        self.assertEqual(places["turned_over"]["now"], 0)
        self.assertGreater(orange(self.picture_of(places, "distrust of seed")), 100)
        out = self.end()
        self.assertIn("NOT TO BE TRUSTED", out)
        score = json.loads((self.folder / "record-1/score.json").read_text())
        replay = subprocess.run(
            [PROGRAM, "run", "record-1/scene.yaml", "--output", "again"], cwd=self.folder,
            env={**os.environ, **AS_ROOT}, capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual(replay.returncode, DONE, replay.stderr)
        self.assertIn("NOT TO BE TRUSTED", replay.stdout)
        summary = json.loads((self.folder / "again/summary.json").read_text())
        self.assertEqual(summary["notes"], score.pop("notes"))
        self.assertEqual(summary["score"], score)


if __name__ == "__main__":
    main(__file__)
