"""Every way out of a run is told: status in summary.json, exit code, files that can be read."""

import csv
import json
import os
import signal
import subprocess
import time
import unittest

from stylet_cli import (AS_ROOT, BAD_INPUT, BLOCK_SCENE, DONE, IO, NEEDLE_SCENE, PROGRAM, CliTest,
                        block_mesh, call, on_ranks, own_lines)

LONG = ["--set", "time.step=0.02 ms", "--set", "output.snapshots=2 ms"]  # minutes on any machine
CAMPAIGN = """\
scene: scene.yaml
set: [time.step=0.05 ms]
design: grid
vary:
  force: {key: needles.0.cutting.cutting_force, values: [1 N, 1.7 N]}
outputs: [peak_needle_force]
"""


class Status(CliTest):
    def setUp(self):
        super().setUp()
        self.write("scene.yaml", NEEDLE_SCENE)

    def summary(self, folder="out/scene"):
        return json.loads((self.folder / folder / "summary.json").read_text())

    def assert_readable(self, folder, least_steps=1):
        import h5py

        with open(self.folder / folder / "history.csv", newline="") as file:
            rows = list(csv.reader(file))
        self.assertTrue(all(len(row) == len(rows[0]) for row in rows))
        with h5py.File(self.folder / folder / "snapshots.h5") as file:
            self.assertGreaterEqual(len([name for name in file if name.startswith("step")]),
                                    least_steps)
        return rows

    def start(self, n, *arguments):
        command = [PROGRAM, *arguments]
        if n > 1:
            command = [os.environ["STYLET_MPIEXEC"], "--oversubscribe", "-n", str(n), *command]
        return self.background(command, env=os.environ | AS_ROOT, stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE, text=True)

    def wait_for(self, program, happened):
        while not happened():
            self.assertIsNone(program.poll(), "ended too early")
            time.sleep(0.01)

    def grown(self, path, least=5000):
        file = self.folder / path
        return file.exists() and file.stat().st_size > least

    def test_signal_stops_a_run(self):
        for sent in (signal.SIGTERM, signal.SIGINT, signal.SIGQUIT, signal.SIGXCPU):
            name = f"by{int(sent)}"
            program = self.start(1, "run", "scene.yaml", "--output", name, *LONG)
            self.wait_for(program, lambda: self.grown(f"{name}/history.csv"))
            program.send_signal(sent)
            err = own_lines(program.communicate()[1])
            self.assertEqual(program.returncode, 128 + sent, err)
            self.assertIn("stopped by signal", err)
            summary = self.summary(name)
            self.assertEqual(summary["status"], "stopped")
            self.assertIn("signal " + sent.name.removeprefix("SIG"), summary["error"])
            rows = self.assert_readable(name, 2)
            self.assertEqual(float(rows[-1][0]), summary["time"])
            self.assertEqual(len(rows) - 1, summary["steps"])
            self.assertFalse((self.folder / name / ".stylet.lock").exists())

    def test_signal_to_one_rank_stops_all(self):
        program = self.start(2, "run", "scene.yaml", "--output", "one", *LONG)
        self.wait_for(program, lambda: self.grown("one/history.csv"))
        writer = int((self.folder / "one/.stylet.lock").read_text().split()[0])
        ranks = [int(pid) for pid in os.listdir("/proc") if pid.isdigit()
                 and self.is_child(int(pid), program.pid)]
        self.assertEqual(len(ranks), 2)
        os.kill(next(pid for pid in ranks if pid != writer), signal.SIGTERM)
        program.communicate()
        self.assertNotEqual(program.returncode, 0)
        self.assertEqual(self.summary("one")["status"], "stopped")
        self.assert_readable("one", 2)

    @staticmethod
    def is_child(pid, parent):
        try:
            with open(f"/proc/{pid}/stat") as file:
                return int(file.read().rsplit(")", 1)[1].split()[1]) == parent
        except OSError:
            return False

    def test_signal_stops_a_run_on_two_ranks(self):
        program = self.start(2, "run", "scene.yaml", "--output", "two", *LONG)
        self.wait_for(program, lambda: self.grown("two/history.csv"))
        program.send_signal(signal.SIGTERM)  # mpirun hands it on, and kills a moment later
        program.communicate()
        self.assertNotEqual(program.returncode, 0)
        self.assertEqual(self.summary("two")["status"], "stopped")
        self.assert_readable("two")

    def test_ignored_signal_stays_ignored(self):
        program = self.background(["sh", "-c", 'trap "" HUP; exec "$@"', "sh", PROGRAM, "run",
                                   "scene.yaml", *LONG], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL)
        self.wait_for(program, lambda: self.grown("out/scene/history.csv"))
        program.send_signal(signal.SIGHUP)
        size = (self.folder / "out/scene/history.csv").stat().st_size
        self.wait_for(program, lambda: self.grown("out/scene/history.csv", size + 5000))
        self.assertEqual(self.summary()["status"], "running")

    def test_crash_is_told(self):
        program = self.start(1, "run", "scene.yaml", *LONG)
        self.wait_for(program, lambda: self.grown("out/scene/history.csv"))
        program.send_signal(signal.SIGSEGV)
        program.communicate()
        self.assertEqual(program.returncode, -signal.SIGSEGV)
        self.assertEqual(self.summary()["status"], "failed")
        self.assertIn("SEGV", self.summary()["error"])

    def test_signal_stops_a_campaign(self):
        self.write("campaign.yaml", CAMPAIGN)
        program = self.start(1, "sweep", "campaign.yaml", "--output", "many")
        self.wait_for(program, lambda: (self.folder / "many/scenes/00000.yaml").exists())
        program.send_signal(signal.SIGTERM)
        program.communicate()
        self.assertEqual(program.returncode, 128 + signal.SIGTERM)
        self.assertEqual(self.summary("many")["status"], "stopped")
        self.assertFalse((self.folder / "many/.stylet.lock").exists())

    def test_unused_option_and_refused_needle(self):
        for n in (1, 2):
            outcome = on_ranks(n, self.folder, "run", "scene.yaml", "--output", f"unused{n}", "--",
                               "-ksp_tpye", "cg")
            self.assert_code(outcome, BAD_INPUT)
            summary = self.summary(f"unused{n}")
            self.assertEqual(summary["status"], "failed")
            self.assertIn("-ksp_tpye", summary["error"])
            self.assert_readable(f"unused{n}")

    def test_killed_at_any_moment_leaves_no_unreadable_file(self):
        import h5py

        wait = 0.0
        seen = set()
        while "snapshots.h5" not in seen or "history.csv" not in seen:
            self.assertLess(wait, 10)
            program = self.start(1, "run", "scene.yaml", "--output", "killed", "--force", *LONG)
            self.wait_for(program, lambda: (self.folder / "killed/.stylet").exists())
            time.sleep(wait)
            program.kill()
            program.communicate()
            wait = 1.5 * wait + 0.001
            folder = self.folder / "killed"
            seen = {path.name for path in folder.iterdir()}
            if "summary.json" in seen:
                self.assertEqual(self.summary("killed")["status"], "running")
            if "history.csv" in seen:
                self.assertTrue((folder / "history.csv").read_text().startswith("time [s],"))
            if "snapshots.h5" in seen:
                h5py.File(folder / "snapshots.h5").close()
        outcome = self.stylet("run", "scene.yaml", "--output", "killed", "--force", "--quiet")
        self.assert_code(outcome, DONE)
        left = {path.name for path in (self.folder / "killed").iterdir()}
        self.assertEqual({name for name in left if name.startswith(".")}, {".stylet"})

    def test_standard_output_that_cannot_be_written(self):
        self.write("block.msh", block_mesh()[0])
        self.write("block.yaml", BLOCK_SCENE)
        for arguments in (["run", "block.yaml"], ["check", "block.yaml"], ["schema"], ["--help"],
                          ["--version"], ["modes", "2", "block.yaml"], ["schema", "--markdown"]):
            with self.subTest(arguments=arguments):
                for target in ("> /dev/full", ">&-"):
                    outcome = call(["sh", "-c", f'"$@" {target}', "sh", PROGRAM, *arguments,
                                    *(["--force"] if arguments[0] == "run" else [])], self.folder)
                    self.assert_code(outcome, IO)
                    self.assert_message(outcome, "standard output cannot be written")
        self.assertEqual(self.summary("out/block")["status"], "completed")
        for name in os.listdir(self.folder / "out/block"):  # nothing was printed into a file
            self.assertNotIn(b"files in", (self.folder / "out/block" / name).read_bytes())


if __name__ == "__main__":
    unittest.main()
