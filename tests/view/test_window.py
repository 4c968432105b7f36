#!/usr/bin/python3
"""A needle in the hand of xdotool: real events of mouse and keyboard in a window under Xvfb.

Where things are is asked of the window itself (key X saves a picture and the places in it). Nothing
depends on how fast the machine is: the test waits for what it has asked for.
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

from stylet_cli import AS_ROOT, PROGRAM, SOURCE

PATIENCE = 100  # s, on a busy machine
INSIDE = "STYLET_UNDER_XVFB"


def x(*arguments):
    return subprocess.run(["xdotool", *map(str, arguments)], capture_output=True, text=True,
                          timeout=PATIENCE, check=True).stdout


class Window(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.shots = 0
        self.program = subprocess.Popen(
            [PROGRAM, "view", str(SOURCE / "input/prostate.yaml"), "--set",
             "time.method=quasi_static", "--set", "time.step=20 ms", "--size", "1000x700", "--record", "record"],
            cwd=self.folder, env={**os.environ, **AS_ROOT}, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.stop)
        found = x("search", "--sync", "--onlyvisible", "--name", "Stylet:").split()
        self.id = found[0]
        x("windowmove", self.id, 0, 0)

    def stop(self):
        if self.program.poll() is None:
            self.program.terminate()
        self.program.communicate(timeout=PATIENCE)

    def look(self):
        """The places of things now."""
        path = self.folder / f"stylet-{self.shots + 1}.json"
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            x("key", "x")
            for _ in range(20):
                time.sleep(0.1)
                if path.exists() and path.read_text().endswith("}\n"):
                    # Keys that came late have saved more.
                    self.shots = len(list(self.folder.glob("stylet-*.json")))
                    newest = self.folder / f"stylet-{self.shots}.json"
                    while not newest.read_text().endswith("}\n"):
                        time.sleep(0.05)
                    return json.loads(newest.read_text())
            self.assertIsNone(self.program.poll(), "the window is gone")
        self.fail("no picture was saved")

    def wait(self, what, is_so):
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            places = self.look()
            if is_so(places):
                return places
        self.fail(f"in vain: {what}; last seen: {places['needle']}, {places['notice']}, {places['error']}")

    def pixel(self, places, point):
        camera = places["camera"]
        left, top, width, height = camera["pane"]
        scale = camera["metres_per_pixel"]
        return (round(left + width / 2 + (point[0] - camera["centre"][0]) / scale),
                round(top + height / 2 - (point[1] - camera["centre"][1]) / scale))

    def drag(self, start, end, pieces=20):
        """With the button held down at the end."""
        x("mousemove", *start, "mousedown", 1)
        for i in range(1, pieces + 1):
            x("mousemove", *(round(a + (b - a) * i / pieces) for a, b in zip(start, end)))

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
    for need in ("xvfb-run", "xdotool"):
        if shutil.which(need) is None:
            print(f"skipped: {need} is not installed (bash jobs/install.sh --tests)")
            sys.exit(77)
    if INSIDE not in os.environ:
        sys.exit(subprocess.run(
            ["xvfb-run", "-a", "-s", "-screen 0 1280x800x24", sys.executable, "-B", __file__],
            env={**os.environ, INSIDE: "1"}, check=False).returncode)
    unittest.main()
