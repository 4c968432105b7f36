"""jobs/surface_mesh.py: tetrahedra in a closed surface and around it, and surfaces that enclose nothing.
Skipped without Gmsh's module."""

import importlib.util
import json
import math
import os
import re
import struct
import sys
import unittest

import numpy as np

from stylet_cli import BAD_INPUT, DONE, IO, SOURCE, CliTest, call

SKIPPED = 77
HALF = np.array([20.0, 14, 17])  # mm, of the ellipsoid
CENTRE = np.array([10.0, -30, 5])

# Rollers and one material: uniaxial stress, which linear tetrahedra hold exactly.
SCENE = """\
mesh: {file: organ.msh}
tissue:
  regions:
    prostate: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}
    surrounding: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}
supports: {left: roller, bottom: roller, back: roller}
loads:
  traction: [{surface: right, stress: [600 Pa, 0 Pa, 0 Pa]}]
probes: {corner: [30 mm, 25 mm, 20 mm]}
time: {method: quasi_static}
"""


def ellipsoid(levels=3):
    """Corners of 8 * 4^levels triangles, (m, 3, 3): an octahedron whose triangles are cut in four."""
    ends = np.concatenate([np.eye(3), -np.eye(3)])
    corners = np.array([ends[[0, 1, 2]], ends[[1, 3, 2]], ends[[3, 4, 2]], ends[[4, 0, 2]],
                        ends[[1, 0, 5]], ends[[3, 1, 5]], ends[[4, 3, 5]], ends[[0, 4, 5]]])
    for _ in range(levels):
        a, b, c = corners.transpose(1, 0, 2)
        d, e, f = a + b, b + c, c + a
        corners = np.concatenate([np.stack(t, axis=1) for t in ((a, d, f), (d, b, e), (f, e, c), (d, e, f))])
        corners = corners / np.linalg.norm(corners, axis=2, keepdims=True)
    return CENTRE + HALF * corners


def binary(corners):
    facets = [struct.pack("<12fH", 0, 0, 0, *corner.ravel(), 0) for corner in corners]
    return bytes(80) + struct.pack("<I", len(facets)) + b"".join(facets)


def ascii_solids(corners, n):
    """Text of n solids, as programs write them that know the parts of a surface."""
    lines = []
    for i, part in enumerate(np.array_split(np.float32(corners), n)):
        lines += [f"solid part{i}"]
        for corner in part:
            lines += ["facet normal 0 0 0", "outer loop", *("vertex " + " ".join(map(repr, p)) for p in
                                                            corner.tolist()), "endloop", "endfacet"]
        lines += [f"endsolid part{i}"]
    return ("\n".join(lines) + "\n").encode()


class SurfaceMesh(CliTest):
    def mesh(self, *options, stl=None, environment=None):
        """The script on the ellipsoid, or on `stl`: corners of triangles, bytes, or None for no new file."""
        stl = ellipsoid() if stl is None else stl
        (self.folder / "organ.stl").write_bytes(stl if isinstance(stl, bytes) else binary(stl))
        command = ["/usr/bin/python3", "-B", str(SOURCE / "jobs/surface_mesh.py"), "organ.stl", "organ.msh",
                   *map(str, options)]
        return call(command, self.folder, env=os.environ | (environment or {}))

    def made(self, *options, share=0.9, **others):
        """The output; the mesh has a share of the closed form's volume: a flat element cuts off some."""
        outcome = self.mesh("--unit", "mm", "--force", *options, **others)
        self.assert_code(outcome, DONE)
        volume = float(re.search(r"^prostate: \d+ tetrahedra, ([\d.]+) cm3", outcome.out, re.M)[1])
        exact = 4 / 3 * math.pi * np.prod(HALF) / 1000
        self.assertLess(volume, exact, "the surface is convex")
        self.assertGreater(volume, share * exact)
        return outcome.out

    def refuse(self, stl, *parts, options=("--unit", "mm"), code=BAD_INPUT):
        outcome = self.mesh(*options, stl=stl)
        self.assert_code(outcome, code)
        for part in parts:
            self.assertIn(part, outcome.err)
        self.assertFalse((self.folder / "organ.msh").exists())

    def test_the_program_runs_on_it(self):
        """The box is 60 x 50 x 40 mm: at its corner 1 % of strain is 0.6 mm along, 0.15 and 0.12 across."""
        self.made("--size", 0.005, "--centre", "--box", -0.03, -0.025, -0.02, 0.03, 0.025, 0.02)
        self.write("scene.yaml", SCENE)
        checked = self.stylet("check", "scene.yaml")
        self.assert_code(checked, DONE)
        for side, area in (("left", 20), ("right", 20), ("bottom", 24), ("top", 24), ("back", 30), ("front", 30)):
            self.assertRegex(checked.out, rf"\b{side} +{area} cm2")
        self.assertRegex(checked.out, r"\bcapsule +\d+(\.\d+)? cm2 +inside")
        self.assert_code(self.stylet("run", "scene.yaml", "--output", "out"), DONE)
        moved = json.loads((self.folder / "out/summary.json").read_text())["probes"]["corner"]
        for value, exact in zip(moved, (6e-4, -1.5e-4, -1.2e-4)):
            self.assertAlmostEqual(value, exact, delta=1e-12)

    def test_same_bytes(self):
        """Wherever things are in memory, which the size of the environment moves."""
        self.made("--size", 0.005)
        first = (self.folder / "organ.msh").read_bytes()
        for n in (2000, 9000):
            self.made("--size", 0.005, environment={"FILLER": "x" * n})
            self.assertEqual((self.folder / "organ.msh").read_bytes(), first)

    def test_sizes_and_quality(self):
        fine = self.made("--size", 0.0025, "--outer-size", 0.010, share=0.97, stl=ellipsoid(4))
        edges = [float(x) for x in re.findall(r"mean edge ([\d.]+) mm", fine)]
        self.assertTrue(2.5 < edges[0] < 3.8 and 1.5 * edges[0] < edges[1] < 10, edges)
        for worst, low, middle in re.findall(r"from ([\d.]+), 1 % below ([\d.]+), median ([\d.]+)", fine):
            self.assertTrue(float(worst) > 0.1 and float(low) > 0.5 and float(middle) > 0.8, fine)
        self.assertIn("2048 triangles", fine)

    def test_axes_and_origin(self):
        """x to inferior (-z of the file), y to anterior (-y), z to right (-x)."""
        out = self.made("--size", 0.006, "--axes", "IAR")
        self.assertIn("from (-0.022 0.016 -0.03) to (0.012 0.044 0.01) m", out)
        out = self.made("--size", 0.006, "--axes", "IAR", "--centre", "--margin", 0.01)
        self.assertIn("from (-0.027 -0.024 -0.03) to (0.027 0.024 0.03) m", out)
        for axes, part in (("IAL", "mirrors"), ("LPP", "--axes LPP"), ("XYZ", "--axes XYZ")):
            outcome = self.mesh("--unit", "mm", "--axes", axes, "--force")
            self.assert_code(outcome, BAD_INPUT)
            self.assertIn(part, outcome.err)

    def test_inside_out_is_turned(self):
        out = self.made("--size", 0.006, stl=ellipsoid()[:, ::-1])
        self.assertIn("turned round", out)
        self.assertNotIn("turned round", self.made("--size", 0.006))

    def test_text_of_several_solids(self):
        self.made("--size", 0.006, stl=ascii_solids(ellipsoid(), 3))

    def test_names(self):
        outcome = self.mesh("--unit", "mm", "--size", 0.006, "--region", "kidney", "--surface", "skin")
        self.assert_code(outcome, DONE)
        names = (self.folder / "organ.msh").read_text().split("$EndPhysicalNames")[0]
        self.assertEqual(re.findall(r'^(\d) \d+ "(\w+)"', names, re.M)[0], ("2", "skin"))
        self.assertEqual(re.findall(r'^3 \d+ "(\w+)"', names, re.M), ["kidney", "surrounding"])
        for option, name in (("--region", "surrounding"), ("--surface", "left"), ("--region", "a b")):
            self.assert_code(self.mesh("--unit", "mm", option, name, "--force"), BAD_INPUT)

    def test_surfaces_that_are_not_closed(self):
        whole = ellipsoid()
        self.refuse(whole[1:], "3 open edges")
        self.refuse(np.concatenate([whole, whole[:1] + [0, 0, 60]]), "3 open edges")

    def test_surfaces_that_enclose_more_than_one_body(self):
        whole = ellipsoid()
        self.refuse(np.concatenate([whole, whole + [60, 0, 0]]), "2 separate shells, of 512, 512 triangles")
        inner = CENTRE + 0.5 * (whole - CENTRE)
        self.refuse(np.concatenate([whole, inner[:, ::-1]]), "2 separate shells")

    def test_sheets_that_meet(self):
        """Two bodies with an edge in common."""
        box = np.array([[0, 0, 0], [20, 0, 0], [0, 20, 0], [0, 0, 20]], dtype=float)
        faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        other = box * [1, -1, -1]  # turned about the x axis
        self.refuse(np.concatenate([box[faces], other[faces]]), "1 edges with more than two triangles",
                    "(10, 0, 0)")

    def test_triangles_that_disagree(self):
        corners = ellipsoid()
        corners[7] = corners[7, ::-1]
        self.refuse(corners, "3 edges whose triangles disagree")

    def test_surfaces_that_meet_themselves(self):
        corners = ellipsoid()
        pole = np.argmax(corners.reshape(-1, 3)[:, 2])
        at_pole = np.all(corners == corners.reshape(-1, 3)[pole], axis=2)
        through = corners.copy()
        through[at_pole] -= [0, 0, 50]  # out at the other side
        self.refuse(through, "crosses itself")
        flat = np.array([[0, 0, 0], [20, 0, 0], [0, 20, 0], [5, 5, 0.001]])  # two sheets on each other
        self.refuse(flat[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]], "folded onto itself")

    def test_files_that_are_no_surface(self):
        whole = ellipsoid()
        self.refuse(b"", "no STL file")
        self.refuse(b"no triangles\n", "no STL file")
        self.refuse(binary(whole)[:3000], "not a whole one")
        self.refuse(binary(whole[:0]), "no triangles")
        self.refuse(ascii_solids(whole, 1)[:-20], "no whole STL file", "512 facet")
        self.refuse(ascii_solids(whole, 1).replace(b"vertex 1", b"vertex one", 1), "not three numbers")
        self.refuse(ascii_solids(whole, 1).replace(b"vertex 1", b"vertex 1 1", 1), "not three numbers")
        whole[3, 1, 2] = math.nan
        self.refuse(whole, "not finite")

    def test_arguments(self):
        self.refuse(None, "--unit", options=())
        self.refuse(None, "is 40000 mm long if its unit is m", "--unit", options=("--unit", "m"))
        self.refuse(None, "beyond the side 'right'", options=("--unit", "mm", "--box", -0.02, -0.06, -0.02, 0.02,
                                                              0.0, 0.04))
        self.refuse(None, "X0 < X1", options=("--unit", "mm", "--box", 1, 0, 0, 0, 1, 1))
        self.refuse(None, "--margin and --box", options=("--unit", "mm", "--margin", 1, "--box", 0, 0, 0, 1, 1, 1))
        self.refuse(None, "--size", options=("--unit", "mm", "--size", 0))
        self.refuse(None, "--outer-size", options=("--unit", "mm", "--size", 0.004, "--outer-size", 0.003))
        self.refuse(None, "tetrahedra; allowed: up to", options=("--unit", "mm", "--size", 1e-4))
        self.refuse(None, "a smaller --size", options=("--unit", "mm", "--size", 0.03, "--margin", 0.1))

    def test_files_of_others(self):
        self.write("organ.msh", "mine")
        outcome = self.mesh("--unit", "mm")
        self.assert_code(outcome, BAD_INPUT)
        self.assertIn("--force", outcome.err)
        self.assertEqual((self.folder / "organ.msh").read_text(), "mine")
        script = str(SOURCE / "jobs/surface_mesh.py")
        outcome = call(["/usr/bin/python3", "-B", script, "organ.stl", "none/a.msh", "--unit", "mm"], self.folder)
        self.assert_code(outcome, IO)
        outcome = call(["/usr/bin/python3", "-B", script, "none.stl", "a.msh", "--unit", "mm"], self.folder)
        self.assert_code(outcome, BAD_INPUT)
        self.assertIn("none.stl: cannot be read", outcome.err)


if __name__ == "__main__":
    if importlib.util.find_spec("gmsh") is None:
        print("skipped: Gmsh's module is absent (apt-get install python3-gmsh)")
        sys.exit(SKIPPED)
    unittest.main()
