"""A disk that is full, a folder that goes or cannot be written: exit code 4, a true status, and a run that
goes on when the disk is well again."""

import os
import shutil
import subprocess
import sys
import time
import unittest
from pathlib import Path

from compare import differences
from scenes import (AS_ROOT, DONE, IO, LONG, PATIENCE, SHORT, FaultTest, call, command, faults,
                    own_lines)

sys.path.insert(0, str(Path(__file__).parent.parent / "cli"))
from test_full_disk import namespace  # noqa: E402

# What is written of each file when the disk is full: some at the start, some in the middle.
FILES = {"history.csv": 4000, "snapshots.h5": 300000, "snapshots.xdmf": 40000,
         "snapshots_needle.xdmf": 40000, "checkpoints/": 500000}
AT_THE_START = {"scene.yaml": 500, ".stylet.reserve": 0, ".stylet.snapshots.h5": 0}
ON_SMALL_DISK = """mount -t tmpfs -o size=$0 tmpfs disk || exit 77
"$@"
first=$?
[ $first = 4 ] || exit $first
cp disk/out/summary.json first.json
mount -o remount,size=64m disk
"$@" --resume || exit $?
cp -r disk/out copy
"""


class Disk(FaultTest):
    def test_full_at_each_file(self):
        for n in (1, 2):
            for name, room in FILES.items() if n == 1 else list(FILES.items())[::2]:
                with self.subTest(file=name, ranks=n):
                    outcome = self.run_short(n, "part", "--quiet",
                                             faulty=faults(on=f"/part/{name}" if "/" in name else name,
                                                           full=room))
                    print(f"{name} full, {n} ranks: exit {outcome.code}, {outcome.seconds:.1f} s")
                    self.assert_code(outcome, IO)
                    self.assertEqual(self.told(outcome), 1, str(outcome))
                    self.assertIn(name, outcome.err)
                    self.assertIn("No space left", outcome.err)
                    self.assertIn("--resume", outcome.err)
                    status, error = self.status("part")
                    self.assertEqual(status, "failed")
                    self.assertIn("No space left", error)
                    self.assert_readable("part")
                    self.assertIn("going on at", self.assert_goes_on(n, "part"))
                    shutil.rmtree(self.folder / "part")

    @staticmethod
    def told(outcome):
        return sum(line.startswith("stylet: ") for line in outcome.err.splitlines())

    def test_full_at_the_start(self):
        for name, room in AT_THE_START.items():
            with self.subTest(file=name):
                outcome = self.run_short(1, "part", "--quiet", faulty=faults(on=name, full=room))
                self.assert_code(outcome, IO)
                self.assert_message(outcome, "No space left")
                if (self.folder / "part/summary.json").exists():
                    self.assertEqual(self.status("part")[0], "failed")
                self.assert_readable("part")
                self.assert_goes_on(1, "part")
                shutil.rmtree(self.folder / "part")

    def test_snapshots_whose_room_was_lost(self):
        """HDF5 meets the full disk itself, which it does not survive."""
        for n in (1, 2):
            with self.subTest(ranks=n):
                outcome = self.run_short(n, "part", "--quiet",
                                         faulty=faults(on="snapshots.h5", full=300000, reserve="yes"))
                self.assert_code(outcome, IO)
                self.assertIn("--resume", outcome.err)
                self.assertEqual(self.status("part")[0], "failed")
                self.assert_readable("part")
                self.assert_goes_on(n, "part")
                shutil.rmtree(self.folder / "part")

    def test_small_disk(self):
        wrap = namespace()
        if wrap is None:
            self.skipTest("no tmpfs can be mounted here")
        (self.folder / "disk").mkdir()
        run = command(1, "run", "scene.yaml", "--quiet", "--output", "disk/out", *SHORT)
        outcome = call([*wrap, "sh", "-c", ON_SMALL_DISK, "700k", *run], self.folder,
                       env=os.environ | AS_ROOT)
        self.assert_code(outcome, DONE)
        self.assertIn('"status": "failed"', (self.folder / "first.json").read_text())
        self.assertEqual(differences(self.whole(1), self.folder / "copy"), [])

    def ends(self, program):
        start = time.monotonic()
        err = own_lines(program.communicate(timeout=PATIENCE)[1])
        print(f"ended with {program.returncode} after {time.monotonic() - start:.1f} s: {err[:300]}")
        self.assertIn("--resume", err)
        return program.returncode

    def long_run(self, n, *changes):
        program = self.start(n, "run", "scene.yaml", "--quiet", "--output", "part", *SHORT, *LONG,
                             *changes)
        self.assertTrue(self.wait_for(program, (self.folder / "part/history.csv").exists))
        return program

    def test_folder_that_goes(self):
        for n in (1, 2):
            for how in ("removed", "moved"):
                with self.subTest(ranks=n, how=how):
                    # Nothing else would be written for minutes.
                    program = self.long_run(n, "--set", "output.snapshots=null", "--set",
                                            "output.checkpoint=null")
                    if how == "moved":
                        os.rename(self.folder / "part", self.folder / "moved")
                    else:
                        shutil.rmtree(self.folder / "part")
                    self.assertEqual(self.ends(program), IO)
                    self.assertFalse((self.folder / "part").exists())
                    shutil.rmtree(self.folder / "moved", ignore_errors=True)

    def test_folder_that_becomes_anothers(self):
        """The lock was removed by hand while its holder was alive: the first run gives way."""
        program = self.long_run(1)
        (self.folder / "part/.stylet.lock").unlink()
        other = self.run_short(1, "part", "--quiet", "--force")
        self.assert_code(other, DONE)
        self.assertEqual(self.ends(program), IO)
        self.assertEqual(differences(self.whole(1), self.folder / "part"), [])

    def test_folder_that_cannot_be_written_any_more(self):
        folder = self.folder / "part"
        folder.mkdir()
        if subprocess.run(["chattr", "+i", folder], capture_output=True).returncode != 0:
            self.skipTest("no file can be made immutable here")
        subprocess.run(["chattr", "-i", folder], check=True)
        folder.rmdir()
        for n in (1, 2):
            with self.subTest(ranks=n):
                program = self.start(n, "run", "scene.yaml", "--quiet", "--output", "part", *SHORT)
                self.assertTrue(self.wait_for(program, (folder / "checkpoints/00000007.h5").exists))
                subprocess.run(["chattr", "-R", "+i", folder], capture_output=True)
                try:
                    self.assertEqual(self.ends(program), IO)
                    self.assertEqual(self.status("part")[0], "running")  # nobody can change that
                finally:
                    subprocess.run(["chattr", "-R", "-i", folder], capture_output=True)
                self.assert_readable("part")
                self.assert_goes_on(n, "part")
                shutil.rmtree(folder)


if __name__ == "__main__":
    unittest.main()
