"""jobs/frames.py on a run in space: slices, the capsule in perspective, needle, seeds and errors."""

import itertools
import json
import sys
import unittest

import h5py
import numpy as np
from PIL import Image

from stylet_cli import BAD_INPUT, DONE, NEEDLE_SCENE, SOURCE, CliTest, call

sys.path.insert(0, str(SOURCE / "jobs"))
import space  # noqa: E402

# A soft body in a box, sheared and squeezed; 2 cm from the skin to its middle.
SCENE = """\
mesh:
  box:
    size: [6 cm, 4 cm, 4 cm]
    columns: 12
    rows: 8
    layers: 8
    region: surrounding
    inner_regions: [{name: gland, ellipsoid: {centre: [3 cm, 2 cm, 2 cm], size: [3 cm, 2.4 cm, 2.4 cm]}}]
tissue:
  regions:
    gland: {youngs_modulus: 20 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}
    surrounding: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}
supports: {left: fixed}
prescribed: [{surface: right, displacement: [-3 mm, 4 mm, 0 mm], ramp: 1 s}]
time: {method: quasi_static, step: 0.25 s, duration: 1 s}
output: {snapshots: 0.25 s}
"""


def bricks(n):
    """Nodes (in [0, 1]^3) and tetrahedra of n^3 bricks, six each around a diagonal."""
    def node(at):
        return at[0] + (n + 1) * (at[1] + (n + 1) * at[2])

    points = np.array(list(itertools.product(np.arange(n + 1) / n, repeat=3)))[:, ::-1]
    cells = []
    for corner in itertools.product(range(n), repeat=3):
        for order in itertools.permutations(range(3)):
            at, path = list(corner), [node(corner)]
            for axis in order:
                at[axis] += 1
                path.append(node(at))
            cells.append(path)
    return points, np.array(cells)


class Geometry(unittest.TestCase):
    def setUp(self):
        self.points, self.cells = bricks(4)

    def slice_of(self, point, normal):
        plane = space.Plane(np.array(point), np.array(normal, dtype=float))
        height = plane.height(self.points)
        return plane, [(found, space.edge_points(self.points, height, ends))
                       for found, ends in space.cut(self.cells, height)]

    def test_a_slice_covers_the_body_once(self):
        """Across an axis the area is 1; x + y = 1 is sqrt(2), the hexagon x + y + z = 3/2 is 3 sqrt(3) / 4."""
        for point, normal, area in (([0.3, 0.4, 0.45], [0, 0, 2], 1), ([0.5, 0.5, 0.1], [1, 1, 0], 2**0.5),
                                    ([0.5, 0.5, 0.5], [-1, -1, -1], 0.75 * 3**0.5),
                                    ([0.5, 0.5, 0.5], [1, 0, 0], 1)):  # along faces of the mesh
            plane, parts = self.slice_of(point, normal)
            total = 0
            for _, corners in parts:
                np.testing.assert_allclose(corners @ plane.normal, plane.offset, atol=1e-14)
                flat = plane.flat(corners)
                for k in range(1, flat.shape[1] - 1):
                    a, b = flat[:, k] - flat[:, 0], flat[:, k + 1] - flat[:, 0]
                    total += 0.5 * np.sum(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))
            self.assertAlmostEqual(total, area, places=12)

    def test_cells_of_a_slice_are_those_it_crosses(self):
        _, parts = self.slice_of([0.3, 0.4, 0.45], [0, 0.2, 1])
        for found, corners in parts:
            cells = self.points[self.cells[found]]
            middle = corners.mean(axis=1)
            self.assertTrue(np.all(middle <= cells.max(axis=1)) and np.all(middle >= cells.min(axis=1)))

    def test_axes_of_pictures(self):
        """x and y, x and z, or y and z grow to the right and upwards."""
        for normal, right, up in (([0, 0, -1], "x", "y"), ([0, 1, 0], "x", "z"), ([-1, 0, 0], "y", "z")):
            plane = space.Plane(np.array([1.0, 2, 3]), np.array(normal, dtype=float))
            words = plane.words()
            self.assertEqual(words[:2], [f"{right} (cm)", f"{up} (cm)"])
            axis = int(np.argmax(np.abs(normal)))
            self.assertEqual(words[2], f"{'xyz'[axis]} = {axis + 1}.00 cm")
            np.testing.assert_allclose(plane.frame(plane.flat(np.array([1.0, 2, 3])), [9, 9])[0], [1, 2, 3])

    def test_interfaces(self):
        inner = np.all(np.abs(self.points[self.cells].mean(axis=1) - 0.5) < 0.25, axis=1)
        for region, area in ((inner, 6 * 0.5**2), (np.zeros(len(self.cells)), 6)):
            corners = self.points[space.interfaces(self.cells, region)]
            twice = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            self.assertAlmostEqual(np.linalg.norm(twice, axis=1).sum() / 2, area, places=12)


class Frames(CliTest):

    def setUp(self):
        super().setUp()
        self.write("scene.yaml", SCENE)
        self.assert_code(self.stylet("run", "scene.yaml", "--output", "out"), DONE)

    def frames(self, *options, folder="out"):
        return call(["/usr/bin/python3", "-B", str(SOURCE / "jobs/frames.py"), folder, *map(str, options)],
                    self.folder)

    def share(self, name, is_colour, part=(0, 1)):
        """Of the pixels between two shares of the width."""
        with Image.open(self.folder / "out/frames" / name) as picture:
            pixels = np.asarray(picture.convert("RGB")).astype(int)
        width = pixels.shape[1]
        pixels = pixels[:, int(part[0] * width):int(part[1] * width)].reshape(-1, 3)
        return np.mean(is_colour(*pixels.T))

    def add_needle(self):
        """As a run with a needle along z leaves it: targets, seeds in the end, one far from the needle."""
        targets = np.array([[0.03, 0.02, 0.02], [0.03, 0.032, 0.02]])
        with h5py.File(self.folder / "out/snapshots.h5", "a") as file:
            steps = [file[name] for name in sorted(file) if name.startswith("step_")]
            for step in steps:
                step["point_sets/targets"] = targets
            for step in steps[:-1]:
                step["polylines/needle"] = np.array([[0.03, 0.02, -0.02], [0.03, 0.02, 0.02]])
            steps[-1]["point_sets/seeds"] = targets + [0, 0, 0.006]
        path = self.folder / "out/summary.json"
        summary = json.loads(path.read_text())
        summary["seeds"] = [{"target_point": list(x), "world": list(x + [0, 0, 0.006]), "placement_error": 0.006}
                            for x in targets]
        path.write_text(json.dumps(summary))

    def test_pictures(self):
        self.assert_code(self.frames("--field", "von_mises", "--normal", 1, 0.5, 0, "--dpi", 60), DONE)
        folder = self.folder / "out/frames"
        self.assertEqual(len(list(folder.glob("frame_*.png"))), 5)
        with Image.open(folder / "overview.gif") as film:
            self.assertEqual(film.n_frames, 5)

        def coloured(r, g, b):  # of the field: grey is frame, letters and ground
            return np.maximum(np.maximum(r, g), b) - np.minimum(np.minimum(r, g), b) > 60

        def capsule(r, g, b):
            return (r > g + 15) & (abs(g - b) < 15)

        self.assertGreater(self.share("frame_0004.png", coloured, (0, 0.5)), 0.3)
        self.assertGreater(self.share("frame_0004.png", capsule, (0.6, 1)), 0.02)

    def test_a_needle_with_seeds(self):
        self.add_needle()
        self.assert_code(self.frames("--no-gif"), DONE)

        def seed(r, g, b):
            return (abs(r - 255) < 3) & (abs(g - 90) < 3) & (abs(b - 54) < 3)

        self.assertEqual(self.share("frame_0003.png", seed), 0)
        self.assertGreater(self.share("frame_0004.png", seed, (0, 0.5)), 2e-5)

        def seed_in_capsule(r, g, b):
            return (r - g > 80) & (r - b > 80)

        self.assertEqual(self.share("frame_0003.png", seed_in_capsule, (0.6, 1)), 0)
        self.assertGreater(self.share("frame_0004.png", seed_in_capsule, (0.6, 1)), 2e-4)
        # The slice is that of the needle, which is upright: x = 3 cm would not show the tip's y.
        run = space.SpaceRun(self.folder / "out", "displacement")
        self.assertEqual(run.labels, ["x (cm)", "z (cm)", "y = 2.00 cm"])
        self.assertEqual(len(list(run.errors())), 1, "the other one is 1.2 cm from the slice")
        self.assertEqual(len(list(run.errors_in_space())), 2)
        np.testing.assert_allclose(run.shape(run.steps[-1], "point_sets", "seeds"), [[3, 2.6]])

    def test_the_slice_shows_the_field(self):
        """Displacement on the moved right side is 5 mm, and 0 on the left."""
        run = space.SpaceRun(self.folder / "out", "displacement", [3, 2, 2], [0, 0, 1])
        points, _, values, _ = run.slice(run.steps[-1])
        right = points[:, 0] > points[:, 0].max() - 1e-9
        self.assertAlmostEqual(points[:, 0].max(), 5.7, places=9)
        np.testing.assert_allclose(values[right], 5, rtol=1e-9)
        np.testing.assert_allclose(values[points[:, 0] < 1e-9], 0, atol=1e-12)

    def test_a_report_shows_slices(self):
        outcome = call(["/usr/bin/python3", "-B", str(SOURCE / "jobs/report.py"), "out"], self.folder)
        self.assert_code(outcome, DONE)
        self.assertIn("six moments", (self.folder / "out/report.html").read_text())

    def test_refusals(self):
        for options, part in ((("--through", 9, 2, 2, "--normal", "x"), "misses the tissue by 3"),
                              (("--normal", "w"), "--normal w"), (("--normal", 0, 0, 0), "--normal 0 0 0"),
                              (("--through", "nan", 2, 2), "--through"), (("--field", "image"), "--field image")):
            outcome = self.frames(*options)
            self.assert_code(outcome, BAD_INPUT)
            self.assertIn(part, outcome.err)
        self.assertFalse((self.folder / "out/frames").exists())
        outcome = call(["/usr/bin/python3", "-B", str(SOURCE / "jobs/paraview.py"), "out", "--picture"], self.folder)
        self.assert_code(outcome, BAD_INPUT)
        self.assertIn("is a run in space", outcome.err)
        self.write("needle.yaml", NEEDLE_SCENE)
        self.assert_code(self.stylet("run", "needle.yaml", "--output", "plane", "--set", "time.until=implanted"), DONE)
        outcome = self.frames("--normal", "z", folder="plane")
        self.assert_code(outcome, BAD_INPUT)
        self.assertIn("is in the plane", outcome.err)


if __name__ == "__main__":
    unittest.main()
