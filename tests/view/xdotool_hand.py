"""The hand of xdotool: real events of mouse and keyboard in a window under Xvfb.

Where things are is asked of the window itself (key X saves a picture and the places in it). Nothing
depends on how fast the machine is: a test waits for what it has asked for.
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

import numpy
from PIL import Image

from stylet_cli import AS_ROOT, PROGRAM, SOURCE

PATIENCE = 100  # s, on a busy machine
INSIDE = "STYLET_UNDER_XVFB"


def x(*arguments):
    return subprocess.run(["xdotool", *map(str, arguments)], capture_output=True, text=True,
                          timeout=PATIENCE, check=True).stdout


class Hand(unittest.TestCase):
    OPTIONS = ()  # of stylet view

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.shots = 0
        self.program = subprocess.Popen(
            [PROGRAM, "view", str(SOURCE / "input/prostate.yaml"), "--record", "record", *self.OPTIONS],
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

    def drag_needle(self, places, way):
        """Pushes by this much (m) and lets go when it is there."""
        scale = places["camera"]["metres_per_pixel"]
        tip = places["needle"]["tip"]
        start = self.pixel(places, (0.075, tip[1]))
        self.drag(start, (start[0] - round(way / scale), start[1]))
        there = self.wait("the tip under the mouse",
                          lambda p: p["error"] or abs(p["needle"]["tip"][0] - (tip[0] - way)) < 3 * scale)
        x("mouseup", 1)
        return there

    def take_needle(self, height):
        """The needle outside at this height (m)."""
        places = self.wait("a first picture", lambda p: p["needle"]["phase"] == "outside")
        x("mousemove", *self.pixel(places, (0.06, height)))
        return self.wait("a height", lambda p: abs(p["needle"]["tip"][1] - height) < 5e-4)

    def picture_of(self, places, widget):
        """Pixels of a thing in the panel in the newest picture, rows by columns by colours."""
        left, top, width, height = (round(n) for n in places["widgets"][widget])
        picture = numpy.asarray(Image.open(self.folder / f"stylet-{self.shots}.png").convert("RGB"))
        return picture[top:top + height, left:left + width].astype(int)

    def end(self):
        """Ctrl with Q; what the program has printed."""
        x("key", "ctrl+q")
        out, err = self.program.communicate(timeout=PATIENCE)
        self.assertEqual(self.program.returncode, 0, err)
        return out


def main(file):
    for need in ("xvfb-run", "xdotool"):
        if shutil.which(need) is None:
            print(f"skipped: {need} is not installed (bash jobs/install.sh --tests)")
            sys.exit(77)
    if INSIDE not in os.environ:
        sys.exit(subprocess.run(
            ["xvfb-run", "-a", "-s", "-screen 0 1280x800x24", sys.executable, "-B", file],
            env={**os.environ, INSIDE: "1"}, check=False).returncode)
    unittest.main()
