"""Studies that are interrupted inside a run go on inside it, with the same results."""

import csv
import json
import signal
import unittest

from scenes import FaultTest, on_ranks

EVERY = ["--set", "time.step=20 ms", "--set", "needles.0.motion.3.duration=0.2 s",
         "--set", "output.checkpoint.steps=10"]
CAMPAIGN = """\
scene: scene.yaml
set: [time.step=20 ms, output.checkpoint.steps=10, output.snapshots=null]
design: grid
vary:
  cutting_force: {key: needles.0.cutting.cutting_force, from: 1 N, to: 2 N, count: 2}
outputs: [seeds.0.placement_error, peak_needle_force]
"""
STUDIES = {
    "converge": ["scene.yaml", "--mesh-levels", "1", "--step-levels", "2", "--no-picture", *EVERY],
    "sweep": ["campaign.yaml", "--no-picture"],
    "tradeoff": ["scene.yaml", "--mesh-levels", "1", "--step-levels", "1", "--repeats", "1",
                 "--no-picture", *EVERY],
    "plan": ["scene.yaml", "--height-range", "0 mm", "--most-runs", "4", "--tolerance", "2 mm",
             "--set", "time.step=20 ms", "--set", "output.checkpoint.steps=10"],
}


class ResumeStudy(FaultTest):
    def setUp(self):
        super().setUp()
        self.write("campaign.yaml", CAMPAIGN)

    def results(self, folder):
        """Rows of results.csv but for times."""
        with open(self.folder / folder / "results.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        return [{k: v for k, v in row.items() if "[s]" not in k or k == "step [s]"} | {"fingerprint": ""}
                for row in rows]

    def interrupt(self, n, verb, folder, by):
        """Where the first run that is long enough is in its middle."""
        arguments = [verb, *STUDIES[verb], "--quiet", "--output", folder]
        program = self.start(n, *arguments)
        checkpoints = self.folder / folder / "checkpoints"
        self.assertTrue(self.wait_for(
            program, lambda: checkpoints.exists() and list(checkpoints.glob("*.h5"))))
        if by == signal.SIGKILL:
            self.kill(program)
        else:
            program.send_signal(by)
            program.communicate()
            self.assertEqual(program.returncode, 128 + by)
            summary = json.loads((self.folder / folder / "summary.json").read_text())
            self.assertEqual(summary["status"], "stopped")
        self.assertTrue(list(checkpoints.glob("*.h5")))

    def resume(self, n, verb, folder):
        outcome = on_ranks(n, self.folder, verb, *STUDIES[verb], "--output", folder, "--resume")
        self.assert_code(outcome, 0)
        self.assertIn("going on at t =", outcome.out)
        self.assertFalse((self.folder / folder / "checkpoints").exists())

    def test_every_study(self):
        for verb in STUDIES:
            with self.subTest(verb=verb):
                self.assert_code(self.stylet(verb, *STUDIES[verb], "--quiet", "--output", f"{verb}1"), 0)
                self.interrupt(1, verb, f"{verb}2", signal.SIGKILL)
                self.resume(1, verb, f"{verb}2")
                self.assertEqual(self.results(f"{verb}1"), self.results(f"{verb}2"))

    def test_stopped_by_a_scheduler(self):
        """Of two runs at a time both go on."""
        self.assert_code(on_ranks(2, self.folder, "sweep", *STUDIES["sweep"], "--quiet",
                                  "--output", "whole"), 0)
        for sent in (signal.SIGUSR1, signal.SIGTERM):
            self.interrupt(1, "sweep", f"by{int(sent)}", sent)
            self.resume(2, "sweep", f"by{int(sent)}")
            # The checkpoint of the signal is one that the other has not made.
            for a, b in zip(self.results("whole"), self.results(f"by{int(sent)}"), strict=True):
                for name in ("seeds.0.placement_error", "peak_needle_force"):
                    self.assertAlmostEqual(float(a[name]) / float(b[name]), 1, delta=1e-9)

    def test_checkpoint_of_another_run(self):
        self.interrupt(1, "sweep", "one", signal.SIGKILL)
        path = next((self.folder / "one/checkpoints").glob("*.h5"))
        path.rename(path.with_name("00001.h5"))
        outcome = self.stylet("sweep", *STUDIES["sweep"], "--output", "one", "--resume")
        self.assert_code(outcome, 4)
        self.assert_message(outcome, "cutting_force", "00001.h5", "begins this run anew")


if __name__ == "__main__":
    unittest.main()
