"""The verbs converge, tradeoff and plan, and what run does with a stored study."""

import csv
import json
import os
import re
import unittest

from stylet_cli import DONE, NEEDLE_SCENE, NUMERICAL, PROGRAM, CliTest, call

COARSE = NEEDLE_SCENE.replace("step: 10 ms", "step: 20 ms\n  until: implanted")
ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_mpi_yield_when_idle": "1"}


class Studies(CliTest):
    def setUp(self):
        super().setUp()
        self.write("scene.yaml", COARSE)

    def json(self, path):
        return json.loads((self.folder / path).read_text())

    def rows(self, path):
        with open(self.folder / path, newline="") as file:
            return list(csv.DictReader(file))

    def test_converge_store_and_run(self):
        plain = self.stylet("run", "scene.yaml", "--output", "plain")
        self.assert_code(plain, DONE)
        self.assertIn("numerical error unknown", plain.out)
        self.assert_refused(self.stylet("run", "scene.yaml", "--accuracy", "0.2 mm"),
                            "no convergence study", "converge --store")

        outcome = self.stylet("converge", "scene.yaml", "--mesh-levels", 3, "--step-levels", 3,
                              "--store", "--no-picture")
        self.assert_code(outcome, DONE)
        self.assertEqual(len(self.rows("out/converge-scene/results.csv")), 7)
        study = self.json("scene.accuracy.json")
        self.assertEqual(study, self.json("out/converge-scene/convergence.json"))
        mesh = study["quantities"]["seeds.0.placement_error"]["mesh"]
        values = [level["value"] for level in mesh["levels"]]
        for level in mesh["levels"]:  # every band holds the finest value
            self.assertLessEqual(abs(level["value"] - values[-1]), level["uncertainty"])
        distances = study["fields"]["mesh"]
        self.assertGreater(distances[0][0], distances[1][0])

        stored = self.stylet("run", "scene.yaml", "--output", "stored")
        self.assert_code(stored, DONE)
        self.assertRegex(stored.out, r"placement error .* ± [0-9.]+ mm \(mesh [0-9.]+, step [0-9.]+\)")
        uncertainty = self.json("stored/summary.json")["uncertainty"]["seeds.0.placement_error"]
        self.assertAlmostEqual(uncertainty["mesh"], mesh["levels"][0]["uncertainty"])
        other = self.stylet("run", "scene.yaml", "--output", "other", "--set", "needles.0.height=3 cm")
        self.assertIn("numerical error unknown", other.out, "another scene")
        coarser = self.stylet("run", "scene.yaml", "--output", "long", "--set", "time.step=40 ms")
        self.assertIn("numerical error unknown", coarser.out, "a longer step than was studied")

        wanted = 1.0001e3 * mesh["levels"][1]["uncertainty"]
        chosen = self.stylet("run", "scene.yaml", "--output", "chosen", "--accuracy",
                             f"{wanted + 0.3} mm")
        self.assert_code(chosen, DONE)
        self.assertRegex(chosen.out, r"mesh\.refine \d, time\.step")
        total = self.json("chosen/summary.json")["uncertainty"]["seeds.0.placement_error"]["total"]
        self.assertLess(total, 1e-3 * (wanted + 0.3))
        self.assert_refused(self.stylet("run", "scene.yaml", "--accuracy", "1e-9 mm"),
                            "scene.accuracy.json", "the best is")

    def test_converge_goes_on_after_a_lost_row(self):
        options = ["--mesh-levels", "2", "--step-levels", "2", "--no-picture", "--quiet"]
        self.assert_code(self.stylet("converge", "scene.yaml", *options), DONE)
        table = self.folder / "out/converge-scene/results.csv"
        whole = table.read_text()
        table.write_text("".join(whole.splitlines(True)[:3]) + "00002,do")
        self.unseal("out/converge-scene")
        self.assert_refused(self.stylet("converge", "scene.yaml", *options), "not empty")
        two = call([os.environ["STYLET_MPIEXEC"], "--oversubscribe", "-n", "2", PROGRAM, "converge",
                    "scene.yaml", *options, "--resume"], self.folder, env=os.environ | ROOT)
        self.assert_code(two, DONE)
        times = re.compile(r",[^,]*,[^,]*$", re.MULTILINE)  # and fingerprints of the rows
        self.assertEqual(times.sub("", table.read_text()), times.sub("", whole))

    def test_converge_refusals(self):
        self.assert_refused(self.stylet("converge", "scene.yaml", "--mesh-levels", 1, "--step-levels", 1),
                            "--mesh-levels")
        explicit = ["--set", "time.method=explicit", "--set", "tissue.damping.stiffness_factor=null"]
        self.assert_refused(self.stylet("converge", "scene.yaml", *explicit), "stable step")

    def test_tradeoff(self):
        outcome = self.stylet("tradeoff", "scene.yaml", "--mesh-levels", 1, "--step-levels", 1,
                              "--repeats", 1, "--no-picture", "--set", "time.step=10 ms")
        self.assert_code(outcome, DONE)
        self.assertIn("Pareto front", outcome.out)
        self.assertIn("going dynamic changes", outcome.out)
        self.assertIn("explicit failed", outcome.out)  # the scene has stiffness damping
        study = self.json("out/tradeoff-scene/tradeoff.json")
        done = [run for run in study["runs"] if "failure" not in run]
        self.assertEqual(len(done), len(study["runs"]) - 1)
        front = [run for run in done if run["on_front"]]
        self.assertGreater(len(front), 0)
        for run in front:
            for other in done[:-1]:
                self.assertFalse(other["seconds"] < run["seconds"]
                                 and other["safe_error"] < run["safe_error"])

    def test_plan_brings_the_seed_to_its_target(self):
        outcome = self.stylet("plan", "scene.yaml")
        self.assert_code(outcome, DONE)
        summary = self.json("out/plan-scene/summary.json")
        seed = summary["seeds"][0]
        self.assertGreater(seed["error_before"], 1e-3)
        self.assertLess(seed["placement_error"], 0.05e-3)  # the tolerance
        self.assert_code(self.stylet("run", "out/plan-scene/planned.yaml", "--output", "planned"), DONE)
        run = self.json("planned/summary.json")
        self.assertAlmostEqual(run["seeds"][0]["placement_error"], seed["placement_error"], delta=1e-12)
        self.assert_refused(self.stylet("plan", "scene.yaml", "--depth-range", "3"),
                            "--depth-range", "unit")
        self.assert_refused(self.stylet("run", "scene.yaml", "--accuracy", "2"), "--accuracy", "unit")
        self.assert_refused(self.stylet("plan", "scene.yaml", "--set", "targets=null",
                                        "--output", "new"), "target")

    def test_plan_under_a_lasting_load_is_that_of_a_run(self):
        """Seeds at rest are not where they are in the unloaded tissue."""
        loaded = (COARSE.replace("  until: implanted\n", "").replace("bottom: fixed", "bottom: free")
                  + "loads: {body: [{force: [0 N/m^3, 80000 N/m^3]}]}\n")
        self.write("loaded.yaml", loaded)
        self.assert_code(self.stylet("plan", "loaded.yaml", "--tolerance", "0.2 mm"), DONE)
        seed = self.json("out/plan-loaded/summary.json")["seeds"][0]
        self.assertLess(seed["placement_error"], 0.2e-3)
        self.assert_code(self.stylet("run", "out/plan-loaded/planned.yaml", "--output", "run"), DONE)
        run = self.json("run/summary.json")["seeds"][0]
        self.assertAlmostEqual(run["placement_error"], seed["placement_error"], delta=1e-9)
        moved = [w - r for w, r in zip(run["world"], run["reference"], strict=True)]
        self.assertGreater(abs(moved[1]), 1e-3, "the load moves the seed at rest")

    def test_plan_that_ends_at_its_range_says_so(self):
        outcome = self.stylet("plan", "scene.yaml", "--depth-range", "0.5 mm", "--height-range", "0 mm")
        self.assert_code(outcome, NUMERICAL)
        self.assert_message(outcome, "the plan still misses by",
                            "needle1: the stop of motion.0 (--depth-range)")
        self.assertEqual(len(self.json("out/plan-scene/summary.json")["shortfalls"]), 1)

    def test_plan_that_uses_up_its_runs_says_so(self):
        outcome = self.stylet("plan", "scene.yaml", "--most-runs", "2")
        self.assert_code(outcome, NUMERICAL)
        self.assert_message(outcome, "the plan still misses by", "needle1: its 2 runs are used up")
        self.assertEqual(self.json("out/plan-scene/summary.json")["status"], "failed")

    def test_plan_needs_runs(self):
        for runs in ("0", "-5"):  # PETSc would take a negative number for its default
            outcome = self.stylet("plan", "scene.yaml", "--most-runs", runs)
            self.assert_refused(outcome, "--most-runs above 0")

    def test_plan_of_seeds_that_do_not_come_to_rest_is_refused(self):
        self.write("in.yaml", COARSE.replace("  until: implanted\n", "")
                   .replace("      - retract: {speed: 2 cm/s}\n      - settle\n",
                            "      - hold: {duration: 0.1 s}\n"))
        self.assert_refused(self.stylet("plan", "in.yaml"), "is not all the way out at the end")

    def test_plan_of_two_needles_and_three_seeds(self):
        second = """\
      - implant: {target: near}
      - retract: {speed: 2 cm/s}
  - height: 2.4 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    motion:
      - insert: {speed: 2 cm/s, depth: 3.5 cm}
      - implant: {target: low}
      - retract: {speed: 2 cm/s}
      - settle
targets:
  seed: [4 cm, 3.2 cm]
  near: [5.2 cm, 3.2 cm]
  low: [4.5 cm, 2.4 cm]
"""
        first = COARSE[: COARSE.index("targets:")]
        rest = COARSE[COARSE.index("time:"):]
        first = first.replace("      - implant\n      - retract: {speed: 2 cm/s}\n",
                              "      - implant: {target: seed}\n"
                              "      - retract: {speed: 2 cm/s, depth: 2.8 cm}\n")
        self.assertIn("depth: 2.8 cm", first)
        first = first.replace("      - settle\n", "")
        self.write("two.yaml", first + second + rest.replace("  until: implanted\n", ""))
        outcome = self.stylet("plan", "two.yaml")
        self.assert_code(outcome, DONE)
        seeds = self.json("out/plan-two/summary.json")["seeds"]
        self.assertEqual([s["target"] for s in seeds], ["seed", "near", "low"])
        for seed in seeds:
            self.assertLess(seed["placement_error"], min(0.3e-3, seed["error_before"]), str(seeds))


if __name__ == "__main__":
    unittest.main()
