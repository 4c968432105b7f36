"""The verb stability: its files, its refusals, and the same numbers on two ranks."""

import csv
import json
import os
import unittest

from stylet_cli import (BLOCK_SCENE, DONE, NEEDLE_SCENE, PROGRAM, SOURCE, CliTest, block_mesh, call)

ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_mpi_yield_when_idle": "1"}
COARSE = ["--set", "mesh.rectangle.columns=8", "--set", "mesh.rectangle.rows=6"]
TABLES = ("stability.csv", "stability_implicit.csv")


class Stability(CliTest):
    def setUp(self):
        super().setUp()
        self.write("scene.yaml", NEEDLE_SCENE)
        self.write("block.msh", block_mesh()[0])
        self.write("block.yaml", BLOCK_SCENE)

    def rows(self, folder, table):
        with open(self.folder / folder / table, newline="") as file:
            return list(csv.DictReader(file))

    def test_files_refusal_and_two_ranks(self):
        outcome = self.stylet("stability", "scene.yaml", "--samples", 2, *COARSE)
        self.assert_code(outcome, DONE)
        folder = "out/stability-scene"
        self.assertTrue(outcome.out.rstrip().endswith(f"jobs/stability.py {folder}"), str(outcome))
        limits = self.rows(folder, "stability.csv")
        self.assertEqual(len(limits), 2 * 3, "two moments, three kinds of damping")
        self.assertEqual(float(limits[0]["tip_depth [m]"]), 0)
        self.assertAlmostEqual(float(limits[-1]["tip_depth [m]"]), 0.04)
        for row in limits:
            self.assertLess(float(row["predicted_over_measured"]), 1)
            self.assertAlmostEqual(float(row["spectral_over_measured"]), 1, delta=0.005)
        for row in self.rows(folder, "stability_implicit.csv"):
            self.assertAlmostEqual(float(row["average_acceleration_last"]), 1, delta=1e-6)
        summary = json.loads((self.folder / folder / "summary.json").read_text())
        self.assertEqual([g["grows"] for g in summary["implicit"]], 18 * [False])
        self.assertGreater(len(summary["insertions"]), 0)

        self.assert_refused(self.stylet("stability", "scene.yaml"), folder, "not empty", "--force")
        drawn = call(["/usr/bin/python3", SOURCE / "jobs/stability.py", folder], self.folder)
        if "needs python3-matplotlib" not in drawn.err:
            self.assert_code(drawn, DONE)
            self.assertTrue((self.folder / folder / "stability.png").exists())

        environment = os.environ | ROOT
        two = call([os.environ["STYLET_MPIEXEC"], "--oversubscribe", "-n", "2", PROGRAM, "stability",
                    "scene.yaml", "--samples", "2", *COARSE, "--output", "two", "--quiet"],
                   self.folder, env=environment)
        self.assert_code(two, DONE)
        self.assertEqual(two.out, "")
        for table in TABLES:
            for one, other in zip(self.rows(folder, table), self.rows("two", table), strict=True):
                for name in one:
                    a, b = float(one[name]), float(other[name])
                    # Energies far below the start's are round-off of the solver.
                    self.assertAlmostEqual(a, b, delta=1e-7 * abs(a) + 1e-15, msg=f"{table} {name}")

    def test_scene_without_needle_has_one_moment(self):
        outcome = self.stylet("stability", "block.yaml", "--output", "o")
        self.assert_code(outcome, DONE)
        self.assertEqual(len(self.rows("o", "stability.csv")), 3)

    def test_refusals(self):
        weightless = ["--set", "tissue.regions.tissue.density=0 kg/m^3"]
        self.assert_refused(self.stylet("stability", "block.yaml", *weightless),
                            "tissue.regions.tissue.density", "without mass")
        self.assert_refused(self.stylet("stability", "block.yaml", "--samples", 0), "--samples 0")
        self.assert_refused(self.stylet("stability", "block.yaml", "--", "-eps_tolerance", "1"),
                            "-eps_tolerance")
        self.assert_refused(self.stylet("stability", "scene.yaml", "--set", "time.method=explicit",
                                        "--output", "new"), "stiffness_factor")
        self.assertFalse((self.folder / "new").exists(), "a refused scene leaves no folder")

    def test_help_shows_an_example(self):
        outcome = self.stylet("stability", "--help")
        self.assert_code(outcome, DONE)
        self.assertIn("stylet stability input/prostate.yaml", outcome.out)


if __name__ == "__main__":
    unittest.main()
