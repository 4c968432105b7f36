"""A disk that fills up while a run writes: exit code 4, and what was written stays readable."""

import json
import os
import resource
import shutil
import subprocess
import sys
import time
import unittest

from stylet_cli import (IO, NEEDLE_SCENE, PROGRAM, TIMEOUT, CliTest, Outcome, call,
                        own_lines)

SKIPPED = 77
ROOM = 1 << 20  # bytes; the run writes several times as much
# A tmpfs in a mount namespace of its own is gone when the shell ends; so the files are copied out.
ON_TMPFS = f"""mount -t tmpfs -o size={ROOM} tmpfs disk || exit {SKIPPED}
"$@"
code=$?
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
        self.assertIn(json.loads((folder / "summary.json").read_text())["status"],
                      ("running", "failed"))
        import h5py

        with h5py.File(folder / "snapshots.h5") as file:
            self.assertGreater(len(file), 0)

    def test_full_disk(self):
        self.write("scene.yaml", NEEDLE_SCENE)
        (self.folder / "disk").mkdir()
        run = [PROGRAM, "run", "scene.yaml", "--quiet", "--set", "output.snapshots=20 ms"]
        wrap = namespace()
        if wrap is not None:
            shell = ["sh", "-c", ON_TMPFS, "sh", *run, "--output", "disk/out"]
            self.check(call(wrap + shell, self.folder), self.folder / "copy" / "out")
            return
        print("no tmpfs can be mounted here: file sizes are limited instead", file=sys.stderr)
        self.check(self.with_limited_files(run + ["--output", "disk/out"]),
                   self.folder / "disk" / "out")

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
