"""A run that is interrupted and resumed leaves what it leaves without: bit for bit on as many ranks, to
1e-10 on others."""

import hashlib
import json
import shutil
import signal
import time
import unittest

import h5py
from compare import differences, largest_deviation
from scenes import METHODS, FaultTest, on_ranks

EVERY = ["--quiet", "--set", "time.step=20 ms", "--set", "needles.0.motion.3.duration=0.2 s",
         "--set", "output.checkpoint.steps=7", "--set", "output.snapshots=50 ms"]


class Resume(FaultTest):
    def run_on(self, n, *arguments, code=0):
        outcome = on_ranks(n, self.folder, "run", "scene.yaml", *EVERY, *arguments)
        self.assert_code(outcome, code)
        return outcome

    def kill_in_the_middle(self, n, name, *arguments):
        """Killed a moment after a checkpoint, so that rows and snapshots behind it are there."""
        program = self.start(n, "run", "scene.yaml", *EVERY, "--output", name, *arguments)
        checkpoint = self.folder / name / "checkpoints/00000049.h5"
        killed = self.wait_for(program, checkpoint.exists)
        time.sleep(0.03)
        self.kill(program)
        return killed

    def assert_same(self, one, other):
        self.assertEqual(differences(self.folder / one, self.folder / other), [])

    def test_all_methods_bit_for_bit(self):
        for method, changes in METHODS.items():
            with self.subTest(method=method):
                self.run_on(1, "--output", f"{method}/whole", *changes)
                self.kill_in_the_middle(1, f"{method}/part", *changes)
                self.run_on(1, "--output", f"{method}/part", "--resume", *changes)
                self.assert_same(f"{method}/whole", f"{method}/part")

    def test_other_ranks(self):
        self.run_on(2, "--output", "two")
        self.run_on(1, "--output", "one")
        self.kill_in_the_middle(2, "part")
        shutil.copytree(self.folder / "part", self.folder / "moved")
        self.run_on(2, "--output", "part", "--resume")
        self.assert_same("two", "part")
        self.run_on(1, "--output", "moved", "--resume")
        for folder in self.folder / "one", self.folder / "two":
            self.assertLess(largest_deviation(folder, self.folder / "moved"), 1e-10)

    def test_checkpoints_change_nothing(self):
        self.run_on(1, "--output", "with")
        self.run_on(1, "--output", "without", "--set", "output.checkpoint=null")
        self.assertLess(largest_deviation(self.folder / "with", self.folder / "without"), 1e-10)
        self.assertFalse((self.folder / "without/checkpoints").exists())

    def test_torn_newest_one(self):
        self.run_on(1, "--output", "whole")
        self.kill_in_the_middle(1, "part")
        # Three, with a draft beside them, where the kill met the writing of the next one.
        files = sorted((self.folder / "part/checkpoints").glob("[0-9]*.h5"))
        self.assertGreaterEqual(len(files), 2)
        files[-1].write_bytes(files[-1].read_bytes()[:-1000])
        outcome = on_ranks(1, self.folder, "run", "scene.yaml", *EVERY[1:], "--output", "part",
                           "--resume")
        self.assert_code(outcome, 0)
        self.assertIn(f"{files[-1].name} is not whole", outcome.out)
        self.assert_same("whole", "part")

    def test_stopped_by_a_scheduler(self):
        for sent in (signal.SIGUSR1, signal.SIGTERM):
            name = f"by{int(sent)}"
            program = self.start(1, "run", "scene.yaml", "--quiet", "--output", name)
            self.wait_for(program, lambda: (self.folder / name / "history.csv").exists())
            program.send_signal(sent)
            program.communicate()
            self.assertEqual(program.returncode, 128 + sent)
            folder = self.folder / name
            self.assertEqual(json.loads((folder / "summary.json").read_text())["status"], "stopped")
            self.assertEqual(len(list((folder / "checkpoints").iterdir())), 1)
            self.assert_code(self.stylet("run", "scene.yaml", "--quiet", "--output", name,
                                         "--resume"), 0)
        self.assert_code(self.stylet("run", "scene.yaml", "--quiet", "--output", "plain"), 0)
        self.assertLess(largest_deviation(self.folder / name, self.folder / "plain"), 1e-10)

    def test_parts(self):
        """--until makes parts; what is completed is left as it is; only output and end may change."""
        self.run_on(1, "--output", "parts", "--until", "0.4 s")
        self.assertEqual(json.loads((self.folder / "parts/summary.json").read_text())["status"],
                         "stopped")
        refused = self.run_on(1, "--output", "parts", "--resume", "--set", "time.step=5 ms", code=2)
        self.assert_message(refused, "time.step", "0.02 s", "0.005 s")
        refused = self.run_on(1, "--output", "parts", "--resume", "--set",
                              "tissue.regions.gland.youngs_modulus=61 kPa", code=2)
        self.assert_message(refused, "tissue.regions.gland.youngs_modulus")
        self.run_on(1, "--output", "parts", "--resume", "--until", "1 s")
        self.run_on(1, "--output", "parts", "--resume", "--set", "output.snapshots=100 ms")
        before = (self.folder / "parts/summary.json").stat().st_mtime_ns
        self.run_on(1, "--output", "parts", "--resume", "--set", "output.snapshots=100 ms")
        self.assertEqual(before, (self.folder / "parts/summary.json").stat().st_mtime_ns)
        self.run_on(1, "--output", "whole")
        self.assertLess(largest_deviation(self.folder / "parts", self.folder / "whole"), 1e-10)

    def test_format_of_another_program(self):
        self.run_on(1, "--output", "part", "--until", "0.3 s")
        path = next((self.folder / "part/checkpoints").iterdir())
        whole = path.read_bytes()
        seal = whole.rindex(b"\nstylet checkpoint, ")
        line = whole[seal:].split(b": ")[0] + b": "
        with h5py.File(path, "r+") as file:  # may cut off what is not HDF5's
            file.attrs.modify("format", 99)
        changed = path.read_bytes()[:seal]
        path.write_bytes(changed + line + hashlib.sha256(changed).hexdigest().encode() + b"\n")
        refused = self.run_on(1, "--output", "part", "--resume", code=2)
        self.assert_message(refused, "format 99", path.name)
        self.assertTrue(path.exists())


if __name__ == "__main__":
    unittest.main()
