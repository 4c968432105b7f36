"""A run in a log: its progress line; killed, what it wrote so far can be read."""

import csv
import json
import signal
import subprocess
import time
import unittest

import h5py
import numpy as np
from stylet_cli import NEEDLE_SCENE, PROGRAM, CliTest, own_lines

LONGEST_WAIT = 250  # s; the first progress line is due after 10 s, on a busy machine later
PROGRESS = r"^ *\d+ %  t \d.*(inserting|retracting).*mm deep.*N  elapsed \d+:\d\d, left \d+:\d\d$"


class KilledRun(CliTest):
    def test_killed_run(self):
        self.write("scene.yaml", NEEDLE_SCENE)
        log = self.folder / "log"
        with open(log, "w") as err:
            # Steps of 0.02 ms: minutes on any machine, so that it is killed in the middle.
            run = subprocess.Popen([PROGRAM, "run", "scene.yaml", "--set", "time.step=0.02 ms",
                                    "--set", "output.snapshots=10 ms"],
                                   cwd=self.folder, stdout=subprocess.DEVNULL, stderr=err)
            self.addCleanup(run.kill)
            end = time.monotonic() + LONGEST_WAIT
            while "elapsed" not in log.read_text() and time.monotonic() < end:
                self.assertIsNone(run.poll(), f"ended too early: {log.read_text()}")
                time.sleep(0.1)
            run.send_signal(signal.SIGKILL)
            self.assertEqual(run.wait(), -signal.SIGKILL)

        self.assertRegex(own_lines(log.read_text()).splitlines()[0], PROGRESS)
        out = self.folder / "out/scene"

        self.assertEqual(json.loads((out / "summary.json").read_text())["status"], "running")

        with open(out / "history.csv", newline="") as file:
            rows = list(csv.reader(file))
        complete = rows[1:-1]  # the last one may be cut short
        self.assertGreater(len(complete), 100)
        self.assertTrue(all(len(row) == len(rows[0]) for row in complete))
        times = np.array([float(row[0]) for row in complete])
        self.assertTrue(np.all(np.diff(times) > 0))

        with h5py.File(out / "snapshots.h5") as file:
            steps = sorted(name for name in file if name.startswith("step"))
            self.assertGreater(len(steps), 1)
            displacement = file[steps[-1]]["u"][:]
            self.assertTrue(np.all(np.isfinite(displacement)))
            self.assertGreater(np.abs(displacement).max(), 0)


if __name__ == "__main__":
    unittest.main()
