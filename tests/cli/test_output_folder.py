"""Where results go: nothing of the user's is lost, and a folder that cannot be used is named."""

import os
import signal
import subprocess
import time
import unittest

from stylet_cli import (BAD_INPUT, BLOCK_SCENE, DONE, IO, NEEDLE_SCENE, PROGRAM, SOURCE, CliTest,
                        block_mesh, call, on_ranks)

FOREIGN = ["notes.txt", "frames/talk.png", "frames/frame_0001.png", "results.csv", "report.md",
           "scenes/1.yaml", "scenes/00001.yaml", "plan.json", "study.png"]
CAMPAIGN = """\
scene: needle.yaml
design: grid
vary:
  force: {key: needles.0.cutting.cutting_force, values: [1 N, 1.7 N]}
outputs: [peak_needle_force]
"""


class OutputFolder(CliTest):
    def setUp(self):
        super().setUp()
        self.write("block.msh", block_mesh()[0])
        self.write("scene.yaml", BLOCK_SCENE)

    def fail_at(self, output, *parts):
        outcome = self.stylet("run", "scene.yaml", "--output", output)
        self.assert_code(outcome, IO)
        self.assert_message(outcome, output, *parts)

    def test_existing_results_are_kept_without_force(self):
        self.assert_code(self.stylet("run", "scene.yaml"), DONE)
        before = (self.folder / "out/scene/summary.json").read_bytes()
        self.assert_refused(self.stylet("run", "scene.yaml"), "out/scene", "not empty", "--force",
                            "--output")
        self.assertEqual((self.folder / "out/scene/summary.json").read_bytes(), before)

    def test_force_replaces_results_and_nothing_else(self):
        self.assert_code(self.stylet("run", "scene.yaml", "--set", "output.snapshots=1 s"), DONE)
        out = self.folder / "out/scene"
        for name in FOREIGN:
            (out / name).parent.mkdir(exist_ok=True)
            (out / name).write_text("mine")
        self.assert_code(self.stylet("run", "scene.yaml", "--force"), DONE)
        for name in FOREIGN:
            self.assertEqual((out / name).read_text(), "mine", name)
        self.assertFalse((out / "snapshots.h5").exists(), "this run writes none")

    def test_foreign_folder_is_refused(self):
        (self.folder / "mine").mkdir()
        (self.folder / "mine" / "thesis.tex").write_text("")
        for force in ([], ["--force"]):
            self.assert_refused(self.stylet("run", "scene.yaml", "--output", "mine", *force), "mine",
                                "not empty", "thesis.tex")
        self.assertEqual([path.name for path in (self.folder / "mine").iterdir()], ["thesis.tex"])

    def test_foreign_files_of_our_names_are_refused(self):
        """Of every verb, in a folder without our mark and in one of an earlier run."""
        self.write("needle.yaml", NEEDLE_SCENE)
        self.write("campaign.yaml", CAMPAIGN)
        verbs = {"run": ("needle.yaml", ["scene.yaml", "summary.json", "history.csv", "snapshots.h5",
                                         "snapshots.xdmf"]),
                 "sweep": ("campaign.yaml", ["plan.json", "results.csv", "report.md", "study.png",
                                             "statistics.json", "scenes/00000.yaml"]),
                 "converge": ("needle.yaml", ["convergence.json", "fields/00000.cbor"]),
                 "tradeoff": ("needle.yaml", ["tradeoff.json", "results.csv"]),
                 "plan": ("needle.yaml", ["planned.yaml", "results.csv"]),
                 "stability": ("needle.yaml", ["stability.csv", "stability_implicit.csv"])}
        self.assert_code(self.stylet("run", "scene.yaml", "--output", "ours"), DONE)
        marks = (self.folder / "ours/.stylet").read_text()
        for verb, (file, names) in verbs.items():
            for name in names:
                for marked in (False, True) if name == names[0] else (True,):
                    with self.subTest(verb=verb, name=name, marked=marked):
                        folder = self.folder / f"{verb}-{name.replace('/', '-')}-{marked}"
                        (folder / name).parent.mkdir(parents=True)
                        (folder / name).write_text("mine")
                        if marked:
                            (folder / ".stylet").write_text(marks.splitlines(True)[0])
                        outcome = self.stylet(verb, file, "--output", folder.name, "--force")
                        self.assert_refused(outcome, folder.name, name.split("/")[0])
                        self.assertEqual((folder / name).read_text(), "mine")
                        self.assertFalse((folder / ".stylet.lock").exists())

    def test_own_scene_edited_by_hand_is_kept(self):
        self.assert_code(self.stylet("run", "scene.yaml", "--output", "ours"), DONE)
        scene = self.folder / "ours/scene.yaml"
        text = scene.read_text().replace("0.3", "0.31")
        scene.write_text(text)
        outcome = self.stylet("run", "ours/scene.yaml", "--output", "ours", "--force")
        self.assert_refused(outcome, "scene.yaml", "changed")
        self.assertEqual(scene.read_text(), text)

    def test_pictures_replace_pictures_only(self):
        self.assert_code(self.stylet("run", "scene.yaml", "--set", "output.snapshots=0.5 s"), DONE)
        frames = ["/usr/bin/python3", "-B", SOURCE / "jobs/frames.py", "out/scene", "--no-gif"]
        foreign = self.folder / "out/scene/frames/frame_0001.png"
        foreign.parent.mkdir()
        foreign.write_text("mine")
        outcome = call(list(map(str, frames)), self.folder)
        if "needs python3" in outcome.err:
            self.skipTest(outcome.err.strip())
        self.assert_code(outcome, BAD_INPUT)
        self.assertIn("frame_0001.png", outcome.err)
        self.assertEqual([path.name for path in foreign.parent.iterdir()], [foreign.name])
        foreign.rename(foreign.with_name("frame_0099.png"))
        for every in ("1", "2"):
            self.assert_code(call([*map(str, frames), "--every", every], self.folder), DONE)
        self.assertEqual(sorted(path.name for path in foreign.parent.iterdir()),
                         ["frame_0000.png", "frame_0001.png", "frame_0099.png", "overview.png"])
        self.assert_code(self.stylet("run", "scene.yaml", "--force"), DONE)
        self.assertEqual([path.name for path in foreign.parent.iterdir()], ["frame_0099.png"])

    def test_folder_in_use(self):
        self.write("needle.yaml", NEEDLE_SCENE)
        program = self.background([PROGRAM, "run", "needle.yaml", "--output", "busy", "--set",
                                   "time.step=0.02 ms"], stderr=subprocess.DEVNULL)
        while not (self.folder / "busy/history.csv").exists():
            self.assertIsNone(program.poll())
            time.sleep(0.01)
        program.send_signal(signal.SIGSTOP)  # it holds the folder for as long as the others take
        for force in ([], ["--force"]):
            for n in (1, 2):
                outcome = on_ranks(n, self.folder, "run", "scene.yaml", "--output", "busy", *force)
                self.assert_code(outcome, BAD_INPUT)
                self.assertIn(f"in use by process {program.pid} on {os.uname().nodename} since 20",
                              outcome.err)
        program.kill()
        program.wait()
        self.assert_code(self.stylet("run", "scene.yaml", "--output", "busy", "--force"), DONE)

    def test_file_in_the_way(self):
        self.write("file", "")
        self.fail_at("file", "output folder")
        self.fail_at("file/below", "output folder")

    def test_unwritable(self):
        if os.geteuid() == 0:  # root may write anywhere but where the kernel has no files to make
            self.fail_at("/proc/stylet", "output folder")
            return
        (self.folder / "locked").mkdir(mode=0o555)
        self.fail_at("locked/out", "Permission denied")
        self.fail_at("locked", "Permission denied")


if __name__ == "__main__":
    unittest.main()
