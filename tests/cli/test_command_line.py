"""Arguments: help, --set, and PETSc options after --."""

import json
import re
import unittest

from stylet_cli import BLOCK_SCENE, DONE, NEEDLE_SCENE, NUMERICAL, CliTest, block_mesh, on_ranks


class CommandLine(CliTest):
    def setUp(self):
        super().setUp()
        self.write("block.msh", block_mesh()[0])
        self.write("block.yaml", BLOCK_SCENE)
        self.write("scene.yaml", NEEDLE_SCENE)

    def test_help_shows_examples(self):
        for arguments in (["--help"], ["run", "--help"], ["check", "--help"], ["modes", "--help"]):
            with self.subTest(arguments=arguments):
                outcome = self.stylet(*arguments)
                self.assert_code(outcome, DONE)
                self.assertIn("Examples:", outcome.out)
                self.assertIn("stylet run input/prostate.yaml", outcome.out)
                self.assertIn("Exit codes: 0 done, 2 bad scene or mesh", outcome.out)
                self.assertEqual(outcome.err, "")

    def test_every_option_of_run_is_explained(self):
        out = self.stylet("run", "--help").out
        for option in ("--set", "--output", "--force", "--quiet"):
            self.assertRegex(out, rf"{option}\b.*\w")

    def test_no_arguments(self):
        self.assert_refused(self.stylet(), "subcommand is required", "stylet --help")

    def test_unknown_verb_is_named(self):
        self.assert_refused(self.stylet("rum", "scene.yaml"), "rum", "run", "stylet --help")

    def test_unknown_option_is_named(self):
        self.assert_refused(self.stylet("run", "scene.yaml", "--outputt"), "--outputt",
                            "stylet --help")

    def test_set(self):
        for override, parts in {
            "time.stepp=1 ms": ["'time.stepp'", "'1 ms'", "nearest known key is 'time.step'"],
            "step=1 ms": ["'step'", "'time.step'"],
            "time.step=5": ["'5'", "needs a unit", "> 0 s"],
            "time.step=1e-13 s": ["'time.step'", "too short", "1e12 steps"],
            "time.step=5 N": ["'5 N'", "not convertible to s"],
            "time.step": ["allowed: key=value"],
            "=": ["allowed: key=value"],
            "needles.3.height=1 cm": ["'needles.3'", "no such item", "counted from 0"],
            "mesh.refine=-1": ["'-1'", "whole number >= 0"],
        }.items():
            with self.subTest(override=override):
                outcome = self.stylet("check", "scene.yaml", "--set", override)
                self.assert_refused(outcome, "scene.yaml", *parts)

    def test_too_fine_a_mesh_is_refused_before_it_is_made(self):
        outcome = self.stylet("check", "scene.yaml", "--set", "mesh.refine=40")
        self.assert_refused(outcome, "key 'mesh.refine': 40 makes", "triangles", "GB of memory",
                            "allowed here: up to")

    def test_what_finds_no_room_is_refused_before_the_first_run(self):
        """Levels, moments and modes that would need more memory, or more steps, than there are."""
        for verb, options, parts in (
                ("converge", ["--mesh-levels", "40"], ["mesh.refine 39", "GB", "levels fewer"]),
                ("converge", ["--mesh-levels", "2000000000"], ["GB", "levels fewer"]),
                ("converge", ["--step-levels", "60"], ["--step-levels", "too short", "1e12 steps"]),
                ("converge", ["--step-levels", "2000000000"], ["--step-levels", "too short"]),
                ("tradeoff", ["--mesh-levels", "40"], ["mesh.refine 40", "GB", "levels fewer"]),
                ("tradeoff", ["--step-levels", "40"], ["--step-levels", "too long"]),
                ("stability", ["--samples", "2000000000"], ["--samples", "steps of time.step"])):
            with self.subTest(verb=verb, options=options):
                self.assert_refused(self.stylet(verb, "scene.yaml", *options), *parts)
        self.assertFalse((self.folder / "out").exists())

    def test_wrong_values_of_options_are_bad_input(self):
        """Whoever finds them: this program, CLI11, PETSc when it reads them or when it sets up."""
        for arguments in (
                ["modes", "x", "scene.yaml"], ["modes", "0", "scene.yaml"],
                ["modes", "1000000000", "scene.yaml"], ["stability", "scene.yaml", "--samples", "0"],
                ["plan", "scene.yaml", "--most-runs", "0"],
                *(["modes", "3", "scene.yaml", "--", *options] for options in (
                    ["-eps_tol", "x"], ["-eps_tol", "-1"], ["-eps_max_it", "0"], ["-eps_ncv", "-4"],
                    ["-eps_ncv", "2"], ["-eps_type", "x"], ["-st_type", "x"], ["-st_pc_type", "x"])),
                *(["run", "scene.yaml", "--force", "--", *options] for options in (
                    ["-ksp_rtol", "x"], ["-ksp_rtol", "-1"], ["-ksp_rtol", "1e-3"], ["-pc_type", "x"],
                    ["-pc_type", "gamg", "-pc_gamg_threshold", "x"],
                    ["-pc_type", "gamg", "-mg_levels_ksp_max_it", "x"],
                    ["-pc_factor_mat_solver_type", "mumps", "-mat_mumps_icntl_7", "x"]))):
            with self.subTest(arguments=arguments):
                self.assert_refused(self.stylet(*arguments))

    def test_set_changes_the_scene(self):
        outcome = self.stylet("run", "scene.yaml", "--set", "needles.0.motion.0.depth=1 cm",
                              "--set", "output.snapshots=null")
        self.assert_code(outcome, DONE)
        self.assertIn("depth: 0.01 m", (self.folder / "out/scene/scene.yaml").read_text())
        self.assertFalse((self.folder / "out/scene/snapshots.h5").exists())

    def test_solver_options_are_taken(self):
        for number, options in enumerate([["-ksp_rtol", "1e-10"], ["-log_view", ":view.txt"],
                                          ["-ksp_monitor"], ["-ksp_rtol", "1e-10", "-ksp_monitor"]]):
            with self.subTest(options=options):
                outcome = self.stylet("run", "block.yaml", "--output", f"out{number}", "--",
                                      *options)
                self.assert_code(outcome, DONE)

    def test_explicit_steps_are_shown(self):
        explicit = ["--set", "time.method=explicit", "--set", "tissue.mass=lumped", "--set",
                    "time.duration=1 ms", "--set", "time.step=0.1 ms"]
        outcome = self.stylet("run", "block.yaml", *explicit, "--", "-ts_view", "-ts_monitor")
        self.assert_code(outcome, DONE)
        self.assertIn("type: stylet-central-difference", outcome.out)
        steps = re.findall(r"^(\d+) TS dt (\S+) time (\S+)", outcome.out, re.MULTILINE)
        summary = json.loads((self.folder / "out/block/summary.json").read_text())
        self.assertEqual([int(n) for n, _, _ in steps], list(range(1, summary["sub_steps"] + 1)))
        self.assertAlmostEqual(float(steps[-1][2]), 1e-3, delta=1e-8)  # %g has six digits
        implicit = ["--set", "time.method=implicit", "--set", "time.duration=1 ms", "--set",
                    "time.step=0.1 ms"]
        outcome = self.stylet("run", "block.yaml", "--force", *implicit, "--", "-ts_monitor")
        self.assert_refused(outcome, "-ts_monitor", "not used by any solver")

    def test_looking_changes_nothing(self):
        # Bytes, not numbers: a solver that is looked at is the same solver.
        for n in (1, 2):
            files = []
            for number, options in enumerate([[], ["-ksp_view", "-ksp_monitor",
                                                   "-ksp_converged_reason", "-log_view"]]):
                out = self.folder / f"look{n}{number}"
                # Two ranks: of a scene without a needle, since they may share a processor.
                outcome = on_ranks(n, self.folder, "run", "scene.yaml" if n == 1 else "block.yaml",
                                   "--output", out, "--", *options)
                self.assert_code(outcome, DONE)
                if options:
                    for said in ("KSP Object", "KSP Residual norm", "Linear solve converged",
                                 "CHOLMOD's factor"):
                        self.assertIn(said, outcome.out)
                files.append((out / "history.csv").read_bytes())
                summary = json.loads((out / "summary.json").read_text())
                self.assertEqual(summary["solver"], "preonly, cholmod on every rank, by size")
            self.assertEqual(files[0], files[1])

    def test_another_solver_is_named_in_the_summary(self):
        for options, name in ((["-pc_factor_mat_solver_type", "mumps"], "preonly, cholesky (mumps)"),
                              (["-pc_type", "gamg"], "cg, gamg")):
            self.assert_code(self.stylet("run", "block.yaml", "--output", name, "--", *options), DONE)
            summary = json.loads((self.folder / name / "summary.json").read_text())
            self.assertEqual(summary["solver"], name + ", by options")

    def test_factor_that_no_package_has_is_bad_input(self):
        outcome = self.stylet("run", "block.yaml", "--", "-pc_factor_mat_solver_type", "nonsense")
        self.assert_refused(outcome, "nonsense")

    def test_unused_petsc_option(self):
        outcome = self.stylet("run", "block.yaml", "--", "-ksp_tpye", "cg")
        self.assert_refused(outcome, "-ksp_tpye", "not used by any solver")

    def test_other_petsc_options(self):
        for option in (["-options_file", "x"], ["-start_in_debugger"], ["-help"],
                       ["-malloc_dump"], ["-mat_view"], ["-ts_type", "euler"], ["-ts_dt", "1"]):
            with self.subTest(option=option):
                outcome = self.stylet("run", "block.yaml", "--", *option)
                self.assert_refused(outcome, option[0], "solver options", "-ksp_*")

    def test_unknown_solver_is_bad_input(self):
        outcome = self.stylet("run", "block.yaml", "--", "-ksp_type", "nonsense")
        self.assert_refused(outcome, "nonsense")

    def test_solvers_that_do_not_solve(self):
        # One step of Jacobi in place of a factor: the residual tells.
        outcome = self.stylet("run", "scene.yaml", "--", "-ksp_type", "preonly", "-pc_type", "jacobi")
        self.assert_code(outcome, NUMERICAL)
        self.assert_message(outcome, "left a residual", "solver options (after --)")


if __name__ == "__main__":
    unittest.main()
