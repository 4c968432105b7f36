"""Where results go: nothing of the user's is lost, and a folder that cannot be used is named."""

import os
import unittest

from stylet_cli import BLOCK_SCENE, DONE, IO, CliTest, block_mesh


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
        self.assert_code(self.stylet("run", "scene.yaml"), DONE)
        out = self.folder / "out/scene"
        (out / "notes.txt").write_text("mine")
        (out / "frames").mkdir()
        (out / "frames" / "talk.png").write_text("mine")
        (out / "snapshots.h5").write_text("of an earlier run")
        self.assert_code(self.stylet("run", "scene.yaml", "--force"), DONE)
        self.assertEqual((out / "notes.txt").read_text(), "mine")
        self.assertEqual((out / "frames" / "talk.png").read_text(), "mine")
        self.assertFalse((out / "snapshots.h5").exists(), "this run writes none")

    def test_foreign_folder_is_refused(self):
        (self.folder / "mine").mkdir()
        (self.folder / "mine" / "thesis.tex").write_text("")
        self.assert_refused(self.stylet("run", "scene.yaml", "--output", "mine"), "mine",
                            "not empty")

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
