"""jobs/paraview.py in pvpython: what a reader sees of a run. Skipped without ParaView."""

import os
import shutil
import sys
import unittest

from stylet_cli import BAD_INPUT, DONE, NEEDLE_SCENE, SOURCE, CliTest, call

SKIPPED = 77


class ParaView(CliTest):
    def setUp(self):
        super().setUp()
        # Few snapshots: ParaView reads them all for the range of the colours.
        self.write("needle.yaml", NEEDLE_SCENE.replace("snapshots: 100 ms", "snapshots: 500 ms"))
        self.assert_code(self.stylet("run", "needle.yaml", "--output", "out"), DONE)

    def draw(self, *options):
        command = ["/usr/bin/python3", "-B", str(SOURCE / "jobs/paraview.py"), "out", "--picture", *options]
        return call(command, self.folder)

    def pixels(self):
        from PIL import Image

        return Image.open(self.folder / "out/paraview/picture.png").convert("RGB")

    def share(self, picture, is_colour):
        return sum(map(is_colour, picture.getdata())) / (picture.width * picture.height)

    def test_pictures(self):
        def seed(p):
            return p[0] > 220 and 60 < p[1] < 120 and p[2] < 90

        def needle(p):
            return max(p) < 60 and abs(p[0] - 28) < 12 and abs(p[2] - 48) < 12

        self.assert_code(self.draw("--time", "1"), DONE)
        inside = self.pixels()
        self.assertEqual(inside.size, (1200, 900))
        self.assertGreater(self.share(inside, needle), 1e-3)  # a line of 6 x 500 pixels is 3e-3
        # Its own picture is replaced. After the run the needle is out and the seed is left: 12 x 12
        # pixels are 1.3e-4.
        self.assert_code(self.draw("--field", "von_mises"), DONE)
        after = self.pixels()
        self.assertGreater(self.share(after, seed), 0.5e-4)
        self.assertLess(self.share(inside, seed), 0.5e-4)

    def test_refusals(self):
        outcome = self.draw("--field", "colour")
        self.assert_code(outcome, BAD_INPUT)
        self.assertIn("von_mises", outcome.err)
        (self.folder / "out/paraview").mkdir()
        (self.folder / "out/paraview/picture.png").write_text("mine")
        self.assert_code(self.draw(), BAD_INPUT)
        self.assertEqual((self.folder / "out/paraview/picture.png").read_text(), "mine")
        (self.folder / "out/snapshots.h5").unlink()
        self.assert_code(self.draw(), BAD_INPUT)


if __name__ == "__main__":
    if shutil.which("pvpython") is None:
        print("skipped: pvpython is absent (apt-get install paraview python3-paraview)")
        sys.exit(SKIPPED)
    if not os.environ.get("DISPLAY") and shutil.which("Xvfb") is None:
        print("skipped: there is no display, and Xvfb is absent (apt-get install xvfb)")
        sys.exit(SKIPPED)
    unittest.main()
