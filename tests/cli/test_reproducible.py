"""The same scene gives the same bits; the scene.yaml of a run is that scene."""

import json
import unittest

from stylet_cli import BLOCK_SCENE, DONE, NEEDLE_SCENE, CliTest, block_mesh


class Reproducible(CliTest):
    def run_to(self, folder, *arguments):
        self.assert_code(self.stylet("run", *arguments, "--output", folder, "--quiet"), DONE)

    def history(self, folder):
        return (self.folder / folder / "history.csv").read_bytes()

    def error(self, folder):
        summary = json.loads((self.folder / folder / "summary.json").read_text())
        return summary["seeds"][0]["placement_error"]

    def test_same_run_twice(self):
        self.write("scene.yaml", NEEDLE_SCENE)
        self.run_to("one", "scene.yaml")
        self.run_to("two", "scene.yaml")
        self.assertGreater(self.error("one"), 0)
        self.assertTrue(self.history("one") == self.history("two"), "history.csv differs")
        self.assertEqual((self.folder / "one/scene.yaml").read_bytes(),
                         (self.folder / "two/scene.yaml").read_bytes())

    def test_scene_of_a_run_runs_again(self):
        self.write("scene.yaml", NEEDLE_SCENE)
        self.run_to("one", "scene.yaml", "--set", "needles.0.motion.0.depth=3 cm")
        self.run_to("two", "one/scene.yaml")
        self.assertEqual(self.error("two"), self.error("one"))
        self.assertTrue(self.history("one") == self.history("two"), "history.csv differs")

    def test_scene_of_a_run_finds_its_mesh(self):
        (self.folder / "deep").mkdir()
        self.write("deep/block.msh", block_mesh()[0])
        self.write("deep/block.yaml", BLOCK_SCENE)
        self.run_to("one", "deep/block.yaml")
        self.run_to("elsewhere/two", "one/scene.yaml")
        self.assertTrue(self.history("one") == self.history("elsewhere/two"))


if __name__ == "__main__":
    unittest.main()
