"""Attempts at a wrong answer with exit code 0 out of --resume."""

import json
import os
import shutil
import subprocess
import unittest
from pathlib import Path

import h5py
from compare import differences, largest_deviation
from scenes import DONE, FaultTest
from stylet_cli import block_mesh
from test_machine import BLOCK, sealed
from test_procedure import RECORDED, ROWS

STIFFER = ["--set", "tissue.regions.gland.youngs_modulus=61 kPa"]


class WrongState(FaultTest):
    def setUp(self):
        super().setUp()
        self.assert_code(self.run_short(1, "part", "--until", "0.5 s"), DONE)
        self.unseal("part")  # as if it was killed
        self.part = self.folder / "part"
        self.checkpoint = max((self.part / "checkpoints").iterdir())

    def kept(self, name):
        """A copy of the part, to be spoiled."""
        return Path(shutil.copytree(self.part, self.folder / name))

    def refused(self, name, *parts, options=(), n=1):
        outcome = self.run_short(n, name, "--resume", *options)
        self.assert_refused(outcome, *parts)

    def test_goes_on_where_nothing_is_wrong(self):
        kept = self.kept("kept")
        self.assert_code(self.run_short(1, "kept", "--resume"), DONE)
        self.assertLess(largest_deviation(self.whole(1), kept), 1e-10)

    def test_history_of_another(self):
        path = self.part / "history.csv"
        text = path.read_bytes()
        edited = self.kept("edited") / "history.csv"
        at = len(text) // 2
        edited.write_bytes(text[:at] + (b"1" if text[at:at + 1] != b"1" else b"2") + text[at + 1:])
        self.refused("edited", "history.csv", "changed", "--force")
        (self.kept("gone") / "history.csv").unlink()
        self.refused("gone", "history.csv", "--force")
        short = self.kept("short") / "history.csv"
        short.write_bytes(text[:text.rindex(b"\n", 0, -1) + 1])
        self.refused("short", "history.csv", "--force")
        self.assert_code(self.run_short(1, "other", "--until", "0.5 s", *STIFFER), DONE)
        shutil.copy(self.folder / "other/history.csv", self.kept("swapped"))
        self.refused("swapped", "history.csv", "--force")

    def test_snapshots_of_another(self):
        (self.kept("gone") / "snapshots.h5").unlink()
        self.refused("gone", "snapshots.h5", "put it back")
        self.assert_code(self.run_short(1, "other", "--until", "0.5 s", *STIFFER), DONE)
        shutil.copy(self.folder / "other/snapshots.h5", self.kept("swapped"))
        self.refused("swapped", "snapshots.h5", "--force")

    def test_checkpoint_of_another(self):
        self.assert_code(self.run_short(1, "other", "--until", "0.5 s", *STIFFER), DONE)
        shutil.copy(next((self.folder / "other/checkpoints").iterdir()),
                    self.kept("of_another_scene") / "checkpoints" / self.checkpoint.name)
        self.refused("of_another_scene", "youngs_modulus", "61000", "60000")
        # Of the same scene, but with other checkpoints: alike to round-off only, and so its history.
        self.assert_code(self.run_short(1, "of_other_places", "--until", "0.4 s", "--set",
                                        "output.checkpoint.steps=3"), DONE)
        kept = self.kept("mixed")
        shutil.rmtree(kept / "checkpoints")
        shutil.copytree(self.folder / "of_other_places/checkpoints", kept / "checkpoints")
        self.refused("mixed", "history.csv")

    def test_parts_of_two_checkpoints(self):
        kept = self.kept("kept")
        newest, before = sorted((kept / "checkpoints").iterdir())[::-1][:2]
        with h5py.File(newest, "r+") as file, h5py.File(before) as old:
            del file["state"]
            old.copy("state", file)
        sealed(newest)
        self.refused("kept", newest.name, "its state is one of t =")

    def test_edited_state_is_not_whole(self):
        kept = self.kept("kept")
        newest, before = sorted((kept / "checkpoints").iterdir())[::-1][:2]
        with h5py.File(newest, "r+") as file:
            file["state/body/u"][3] *= 1.001
        outcome = self.run_short(1, "kept", "--resume")
        self.assert_code(outcome, DONE)
        self.assertIn(f"{newest.name} is not whole", outcome.out)
        self.assertIn(f"from kept/checkpoints/{before.name}", outcome.out)
        self.assertEqual(differences(self.whole(1), kept), [])

    def test_only_one_and_torn(self):
        self.assert_code(self.run_short(1, "one", "--until", "0.5 s", "--set",
                                        "output.checkpoint.keep=1"), DONE)
        path, = (self.folder / "one/checkpoints").iterdir()
        path.write_bytes(path.read_bytes()[:5000])
        outcome = self.run_short(1, "one", "--resume", "--set", "output.checkpoint.keep=1")
        self.assertIn(outcome.code, (DONE, 2))
        if outcome.code == DONE:
            self.assertIn("begins at its beginning", outcome.out)
            self.assertEqual(largest_deviation(self.whole(1), self.folder / "one"), 0)

    def test_links(self):
        kept = self.kept("kept")
        os.rename(kept / "checkpoints", self.folder / "elsewhere")
        os.symlink(self.folder / "elsewhere", kept / "checkpoints")
        self.refused("kept", "checkpoints", "link")
        one = self.kept("one") / "checkpoints" / self.checkpoint.name
        os.rename(one, self.folder / "away.h5")
        os.symlink(self.folder / "away.h5", one)
        self.refused("one", one.name, "link")

    def test_folder_that_cannot_be_written(self):
        kept = self.kept("kept")
        if subprocess.run(["chattr", "+i", kept / "checkpoints"], capture_output=True).returncode != 0:
            self.skipTest("no folder can be made immutable here")
        try:
            outcome = self.run_short(1, "kept", "--resume")
        finally:
            subprocess.run(["chattr", "-i", kept / "checkpoints"], check=True)
        self.assert_code(outcome, 4)
        self.assert_message(outcome, "checkpoints", "--resume")

    def test_files_that_begin_or_end_on_the_way(self):
        self.kept("kept")
        self.refused("kept", "output.history", "gap", options=["--set", "output.history=false"])
        self.refused("kept", "output.snapshots", "gap", options=["--set", "output.snapshots=null"])
        other = self.run_short(1, "kept", "--resume", "--set", "output.snapshots=30 ms")
        self.assert_code(other, DONE)
        self.assertLess(largest_deviation(self.whole(1), self.folder / "kept"), 1e-10)

    def test_other_solver_options(self):
        loose = ["--", "-ksp_type", "cg", "-pc_type", "icc", "-ksp_rtol", "1e-9"]
        self.kept("kept")
        self.refused("kept", "PETSc options", "-ksp_rtol 1e-9", "none", options=loose)
        self.assert_code(self.run_short(1, "loose", "--until", "0.1 s", *loose), DONE)
        self.refused("loose", "PETSc options", "-ksp_rtol 1e-9", "none")
        # What is complete is so with these options.
        self.assert_code(self.run_short(1, "kept", "--resume"), DONE)
        self.refused("kept", "PETSc options", options=loose)

    def test_end_that_is_over(self):
        """An end before the state: it would go back in time, or never come."""
        self.assert_code(self.run_short(1, "later", "--until", "0.7 s"), DONE)
        self.refused("later", "time.until", options=["--set", "time.until=implanted"])
        self.write("block.msh", block_mesh(4)[0])
        self.write("block.yaml", BLOCK.replace("40 ms", "1 s").replace("1 ms", "10 ms"))
        run = ["run", "block.yaml", "--output", "block"]
        self.assert_code(self.stylet(*run, "--until", "0.4 s"), DONE)
        self.assert_refused(self.stylet(*run, "--resume", "--set", "time.duration=0.2 s"),
                            "time.duration", "0.2 s", "0.4")
        self.assert_code(self.stylet(*run, "--resume", "--set", "time.duration=0.5 s"), DONE)
        summary = json.loads((self.folder / "block/summary.json").read_text())
        self.assertAlmostEqual(summary["time"], 0.5, 12)

    def test_force(self):
        """Would throw away what it is to go on from."""
        self.refused("part", "--force", options=["--force"])
        self.assertTrue(self.checkpoint.exists())

    def test_recording_that_was_changed(self):
        self.write("recorded.yaml", RECORDED)
        self.write("rows.yaml", ROWS)
        run = ["run", "recorded.yaml", "--output", "recorded"]
        self.assert_code(self.stylet(*run, "--until", "0.5 s"), DONE)
        self.write("rows.yaml", ROWS.replace("-0.04", "-0.05"))
        self.assert_refused(self.stylet(*run, "--resume"), "procedure.file", "put the file back")
        self.write("rows.yaml", ROWS)
        self.assert_code(self.stylet(*run, "--resume"), DONE)

    def test_two_needles(self):
        scene = (self.folder / "scene.yaml").read_text()
        first = scene[scene.index("  - height"):scene.index("targets:")]
        self.write("scene.yaml", scene.replace(
            first, first + first.replace("3.2 cm", "2.9 cm").replace("      - settle\n", "")))
        shorter = ["--set", "needles.1.motion.0.depth=1 cm"]
        self.assert_code(self.run_short(1, "two", *shorter), DONE)
        for n, until in ((1, "0.9 s"), (1, "1.4 s")):
            name = f"two{until[:3]}"
            self.assert_code(self.run_short(n, name, "--until", until, *shorter), DONE)
            self.unseal(name)
            self.assert_code(self.run_short(n, name, "--resume", *shorter), DONE)
            self.assertLess(largest_deviation(self.folder / "two", self.folder / name), 1e-10)

    def test_other_ranks(self):
        self.kept("kept")
        self.assert_code(self.run_short(2, "kept", "--resume"), DONE)
        self.assertLess(largest_deviation(self.whole(1), self.folder / "kept"), 1e-10)


if __name__ == "__main__":
    unittest.main()
