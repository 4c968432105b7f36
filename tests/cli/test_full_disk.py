"""A disk that fills up while a run writes: exit code 4, and what was written stays readable."""

import json
import os
import resource
import shutil
import subprocess
import sys
import time
import unittest

from stylet_cli import (AS_ROOT, BLOCK_SCENE, DONE, IO, NEEDLE_SCENE, PROGRAM, TIMEOUT, CliTest,
                        Outcome, block_mesh, call, own_lines)

SKIPPED = 77
ROOM = 1 << 20  # bytes; the run writes several times as much
# A tmpfs in a mount namespace of its own is gone when the shell ends; so the files are copied out.
ON_TMPFS = f"""mount -t tmpfs -o size=$0 tmpfs disk || exit {SKIPPED}
"$@"
code=$?
rm -rf copy
cp -r disk copy
exit $code"""


def namespace():
    """The command that gives us mounts of our own, or None where the system forbids them."""
    wrap = ["unshare", "--mount"] + ([] if os.geteuid() == 0 else ["--map-root-user"])
    if shutil.which("unshare") is None:
        return None
    probe = ["sh", "-c", "mount -t tmpfs -o size=64k tmpfs /mnt"]
    return wrap if subprocess.run(wrap + probe, capture_output=True).returncode == 0 else None


class FullDisk(CliTest):
    def check(self, outcome, folder):
        self.assert_code(outcome, IO)
        self.assert_message(outcome, "snapshots.h5")
        lines = (folder / "history.csv").read_text().splitlines()
        self.assertGreater(len(lines), 1)
        self.assertTrue(lines[0].startswith("time [s],"))
        summary = json.loads((folder / "summary.json").read_text())
        self.assertEqual(summary["status"], "failed")
        self.assertIn("snapshots.h5", summary["error"])
        import h5py

        with h5py.File(folder / "snapshots.h5") as file:
            self.assertGreater(len(file), 0)

    def test_full_disk(self):
        self.write("scene.yaml", NEEDLE_SCENE)
        (self.folder / "disk").mkdir()
        run = [PROGRAM, "run", "scene.yaml", "--quiet", "--set", "output.snapshots=20 ms"]
        wrap = namespace()
        if wrap is not None:
            shell = ["sh", "-c", ON_TMPFS, str(ROOM), *run, "--output", "disk/out"]
            self.check(call(wrap + shell, self.folder), self.folder / "copy" / "out")
            return
        print("no tmpfs can be mounted here: file sizes are limited instead", file=sys.stderr)
        self.check(self.with_limited_files(run + ["--output", "disk/out"]),
                   self.folder / "disk" / "out")

    def on_small_disk(self, size, n, *options):
        """Exit code and folder of a run on n ranks that writes to a disk of so many kB."""
        run = [PROGRAM, "run", "scene.yaml", "--quiet", "--output", "disk/out", *options]
        if n > 1:
            run = [os.environ["STYLET_MPIEXEC"], "--oversubscribe", "-n", str(n), *run]
        wrap = namespace()
        if wrap is None:
            self.skipTest("no tmpfs can be mounted here")
        outcome = call([*wrap, "sh", "-c", ON_TMPFS, f"{size}k", *run], self.folder,
                       env=os.environ | AS_ROOT)
        folder = self.folder / "copy/out"
        summary = folder / "summary.json"
        status = json.loads(summary.read_text())["status"] if summary.exists() else None
        if (folder / "snapshots.h5").exists():
            import h5py

            h5py.File(folder / "snapshots.h5").close()
        return outcome, status, folder

    def test_disk_that_is_full_from_the_start(self):
        """At whatever moment of the start: never a crash, a hang, or a file that cannot be read."""
        self.write("block.msh", block_mesh()[0])
        self.write("scene.yaml", BLOCK_SCENE)
        (self.folder / "disk").mkdir()
        codes = set()
        for size in (4, 40, 48, 56, 80, 116, 400):
            for n in (1, 2):
                with self.subTest(size=size, ranks=n):
                    outcome, status, _ = self.on_small_disk(size, n, "--set", "output.snapshots=1 s")
                    self.assertIn(outcome.code, (DONE, IO), str(outcome))
                    self.assertIn(status, ("completed",) if outcome.code == DONE else ("failed", None))
                    self.assertIn("No space left" if outcome.code == IO else "", outcome.err)
                    codes.add(outcome.code)
        self.assertEqual(codes, {DONE, IO})

    def test_history_that_cannot_be_written_ends_the_run(self):
        self.write("scene.yaml", NEEDLE_SCENE)
        (self.folder / "disk").mkdir()
        for n in (1, 2):
            # Without snapshots nothing else is written until the end. The disk has room for few steps: two
            # ranks on a busy machine wait for each other many times in each.
            outcome, status, folder = self.on_small_disk(
                64, n, "--set", "output.snapshots=null", "--set", "time.step=0.02 ms")
            self.assert_code(outcome, IO)
            self.assertIn("history.csv", outcome.err)
            self.assertEqual(status, "failed")
            lines = (folder / "history.csv").read_text().splitlines()
            self.assertGreater(len(lines), 50)
            self.assertLess(float(lines[-2].split(",")[0]), 0.5)

    def with_limited_files(self, command):
        """Limits the files of the program once it runs: MPI needs larger ones to start."""
        run = subprocess.Popen(command + ["--set", "time.step=1 ms"], cwd=self.folder, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(run.kill)
        while run.poll() is None and not (self.folder / "disk/out/summary.json").exists():
            time.sleep(0.01)
        resource.prlimit(run.pid, resource.RLIMIT_FSIZE, (ROOM, ROOM))
        out, err = run.communicate(timeout=TIMEOUT)
        return Outcome(run.returncode, out, own_lines(err))


if __name__ == "__main__":
    unittest.main()
