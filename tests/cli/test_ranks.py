"""Errors on two ranks: one message, the right exit code, and no rank left behind."""

import os
import unittest

from stylet_cli import BAD_INPUT, BLOCK_SCENE, DONE, IO, NUMERICAL, PROGRAM, CliTest, block_mesh, call

ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


class Ranks(CliTest):
    def setUp(self):
        super().setUp()
        self.write("block.msh", block_mesh(n=6)[0])
        self.write("scene.yaml", BLOCK_SCENE)

    def on_two(self, *arguments):
        environment = os.environ | (ROOT if os.geteuid() == 0 else {})
        return call([os.environ["STYLET_MPIEXEC"], "--oversubscribe", "-n", "2", PROGRAM,
                     *arguments], self.folder, env=environment)

    def fail(self, code, arguments, *parts):
        outcome = self.on_two(*arguments)
        self.assert_code(outcome, code)
        self.assert_message(outcome, *parts)

    def test_run(self):
        outcome = self.on_two("run", "scene.yaml")
        self.assert_code(outcome, DONE)
        self.assertEqual(outcome.out.count("2 ranks"), 1, str(outcome))

    def test_bad_arguments(self):
        self.fail(BAD_INPUT, [], "subcommand is required")
        self.fail(BAD_INPUT, ["run", "scene.yaml", "--", "-options_file", "x"], "-options_file")

    def test_bad_scene(self):
        self.fail(BAD_INPUT, ["run", "scene.yaml", "--set", "time.stepp=1 s"], "'time.stepp'")

    def test_bad_mesh(self):
        self.write("block.msh", block_mesh()[0][:200])
        self.fail(BAD_INPUT, ["run", "scene.yaml"], "block.msh", "truncated?")

    def test_output_below_a_file(self):
        self.fail(IO, ["run", "scene.yaml", "--output", "block.msh/out"], "block.msh/out")

    def test_expectation_that_is_not_met(self):
        self.write("scene.yaml", BLOCK_SCENE + "expect:\n  - {quantity: steps, min: 7}\n")
        self.fail(NUMERICAL, ["run", "scene.yaml"], "expectations", "summary.json")


if __name__ == "__main__":
    unittest.main()
