"""The verb sweep: tables, ranks, kills, refusals, and statistics against closed forms."""

import csv
import json
import os
import signal
import subprocess
import time
import unittest

from stylet_cli import (BAD_INPUT, DONE, NEEDLE_SCENE, NUMERICAL, PROGRAM, SOURCE, CliTest, call)

ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_mpi_yield_when_idle": "1"}
CAMPAIGN = """\
scene: scene.yaml
set: [time.until=implanted, output.snapshots=null, "time.step=20 ms"]
design: grid
vary:
  cutting_force: {key: needles.0.cutting.cutting_force, values: [1 N, 1.7 N]}
  friction:
    factor_of: {needles.0.friction.static_force: 1, needles.0.friction.kinetic_force: 1}
    values: [0.5, 1, 2]
outputs: [seeds.0.placement_error, peak_needle_force]
"""
DEPTHS = """\
scene: scene.yaml
set: [time.until=implanted, output.snapshots=null]
design: grid
vary:
  depth: {key: needles.0.motion.0.depth, values: [3 cm, 4 cm], on_the_way: ON_THE_WAY}
outputs: [seeds.0.placement_error]
"""


class Sweep(CliTest):
    def setUp(self):
        super().setUp()
        self.write("scene.yaml", NEEDLE_SCENE)
        self.write("campaign.yaml", CAMPAIGN)

    def rows(self, folder):
        with open(self.folder / folder / "results.csv", newline="") as file:
            return list(csv.DictReader(file))

    def results(self, folder):
        """Without times, and the fingerprints that they are in."""
        return [{k: v for k, v in row.items() if not k.startswith(("wall_time", "fingerprint"))}
                for row in self.rows(folder)]

    def on_ranks(self, n, *arguments):
        return call([os.environ["STYLET_MPIEXEC"], "--oversubscribe", "-n", str(n), PROGRAM,
                     *map(str, arguments)], self.folder, env=os.environ | ROOT)

    def sweep(self, name, *arguments):
        return self.stylet("sweep", name, "--no-picture", *arguments)

    def test_values_of_another_kind_stay_as_they_are(self):
        self.write("campaign.yaml", """\
scene: scene.yaml
set: [time.until=implanted, output.snapshots=null, "time.step=50 ms"]
design: grid
vary:
  ratio: {key: tissue.regions.gland.poisson_ratio, values: [0.3, 4 kPa]}
  height: {key: needles.0.height, values: [32 mm, 3.2 cm, 32]}
outputs: [seeds.0.placement_error]
""")
        self.assert_code(self.sweep("campaign.yaml"), DONE)
        rows = self.rows("out/sweep-campaign")
        self.assertEqual([row["ratio"] for row in rows], 3 * ["0.3"] + 3 * ["4 kPa"])
        self.assertEqual([row["height [mm]"] for row in rows], 2 * ["32", "32", "32"])
        self.assertEqual([row["status"] for row in rows],
                         ["done", "done", "failed", "failed", "failed", "failed"])
        self.assertIn("needs a unit", rows[2]["error"])
        self.assertIn("'4 kPa'", rows[3]["error"])

    def test_columns_have_names_of_their_own(self):
        for change, column in ((("cutting_force:", "seeds.0.placement_error:"), None),
                               (("friction:", "error:"), "error"),
                               (("outputs: [", "outputs: [peak_needle_force, "),
                                "peak_needle_force")):
            self.write("campaign.yaml", CAMPAIGN.replace(*change))
            outcome = self.sweep("campaign.yaml", "--force")
            if column is None:  # its title has the unit
                self.assert_code(outcome, DONE)
            else:
                self.assert_refused(outcome, "campaign.yaml", f"two columns '{column}'")

    def test_same_table_on_any_number_of_ranks_and_as_single_runs(self):
        outcome = self.sweep("campaign.yaml")
        self.assert_code(outcome, DONE)
        one = self.results("out/sweep-campaign")
        self.assertEqual(len(one), 6)
        self.assertEqual({row["status"] for row in one}, {"done"})
        for n in (2, 3):
            self.assert_code(self.on_ranks(n, "sweep", "campaign.yaml", "--no-picture", "--output",
                                           f"on{n}", "--quiet"), DONE)
            self.assertEqual(self.results(f"on{n}"), one)
        row = one[4]  # 1.7 N, friction as in the scene
        self.assertEqual((row["cutting_force [N]"], row["friction"]), ("1.7", "1"))
        self.assert_code(self.stylet("run", "scene.yaml", "--set", "time.until=implanted", "--set",
                                     "time.step=20 ms", "--output", "single"), DONE)
        summary = json.loads((self.folder / "single/summary.json").read_text())
        self.assertEqual(float(row["seeds.0.placement_error"]),
                         summary["seeds"][0]["placement_error"])
        # The kept scene is that of the run.
        self.assert_code(self.stylet("run", "out/sweep-campaign/scenes/00004.yaml", "--output",
                                     "kept"), DONE)
        kept = json.loads((self.folder / "kept/summary.json").read_text())
        self.assertEqual(kept["seeds"], summary["seeds"])

    def test_groups_of_ranks(self):
        self.assert_code(self.sweep("campaign.yaml"), DONE)
        self.assert_code(self.on_ranks(2, "sweep", "campaign.yaml", "--no-picture", "--ranks-per-run",
                                       2, "--output", "group", "--quiet"), DONE)
        for a, b in zip(self.results("out/sweep-campaign"), self.results("group"), strict=True):
            x, y = (float(row["seeds.0.placement_error"]) for row in (a, b))
            self.assertAlmostEqual(x, y, delta=1e-8 * x)  # round-off of the linear solver
        self.assert_refused(self.sweep("campaign.yaml", "--ranks-per-run", 2, "--output", "few"),
                            "--ranks-per-run 2")

    def test_killed_campaign_goes_on(self):
        self.assert_code(self.sweep("campaign.yaml", "--output", "whole"), DONE)
        kills = 0
        arguments = [PROGRAM, "sweep", "campaign.yaml", "--no-picture", "--output", "killed"]
        while kills < 5:
            program = subprocess.Popen([*arguments, "--resume"], cwd=self.folder,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            table = self.folder / "killed/results.csv"
            before = len(table.read_text().splitlines()) if table.exists() else 0
            # In the middle of the run after the next result, or at the start.
            while program.poll() is None and kills > 0:
                if table.exists() and len(table.read_text().splitlines()) > max(before, 1):
                    break
                time.sleep(0.002)
            if program.poll() is not None:
                break
            time.sleep(0.02)
            program.send_signal(signal.SIGKILL)
            program.wait()
            kills += 1
        self.assertEqual(kills, 5)
        self.assert_code(call([*arguments, "--resume"], self.folder), DONE)
        self.assertEqual(self.results("killed"), self.results("whole"))
        # Nothing is left to do.
        outcome = call([*arguments, "--resume"], self.folder)
        self.assert_code(outcome, DONE)
        self.assertIn("6 of them kept", outcome.out)

    def test_edited_rows_are_not_taken_for_results(self):
        self.assert_code(self.sweep("campaign.yaml"), DONE)
        table = self.folder / "out/sweep-campaign/results.csv"
        whole = table.read_text()
        results = self.results("out/sweep-campaign")
        self.unseal("out/sweep-campaign")
        lines = whole.splitlines(True)
        for edited in (lines[3].replace(",done,", ",failed,"), lines[3].replace("0.00", "0.01", 1),
                       lines[3].replace("00002", "00004")):
            self.assertNotEqual(edited, lines[3])
            table.write_text("".join([*lines[:3], edited, *lines[4:]]))
            self.assert_refused(self.sweep("campaign.yaml", "--resume"), "results.csv: row 4",
                                "not as this study wrote it")
        table.write_text("".join([*lines[:3], *lines[4:]]))
        outcome = self.sweep("campaign.yaml", "--resume")
        self.assert_code(outcome, DONE)
        self.assertIn("5 of them kept", outcome.out)
        self.assertEqual(self.results("out/sweep-campaign"), results)

    def test_failed_runs_are_recorded(self):
        self.write("partly.yaml", CAMPAIGN.replace("values: [1 N, 1.7 N]",
                                                   "values: [1 N, -1 N]"))
        outcome = self.sweep("partly.yaml")
        self.assert_code(outcome, DONE)
        self.assertIn("3 rows have no result", outcome.out)
        rows = self.results("out/sweep-partly")
        self.assertEqual([row["status"] for row in rows], 3 * ["done"] + 3 * ["failed"])
        self.assertIn("cutting_force", rows[3]["error"])
        self.assertEqual(rows[3]["seeds.0.placement_error"], "")
        self.write("wrong.yaml", CAMPAIGN.replace("peak_needle_force", "peak_force"))
        self.assert_refused(self.sweep("wrong.yaml"), "'outputs': 'peak_force' is no number of",
                            "the nearest is 'peak_needle_force'")
        self.assertFalse((self.folder / "out/sweep-wrong").exists(), "before the first run")

    def test_seeds_on_the_way_are_those_of_runs_of_their_own(self):
        errors = []
        for on_the_way in ("true", "false"):
            self.write("depths.yaml", DEPTHS.replace("ON_THE_WAY", on_the_way))
            self.assert_code(self.sweep("depths.yaml", "--output", on_the_way), DONE)
            errors.append([float(r["seeds.0.placement_error"]) for r in self.rows(on_the_way)])
        self.assertEqual(len({row["run"] for row in self.rows("true")}), 1)
        # The stop on the way cuts a step in two, nothing else.
        for a, b in zip(*errors, strict=True):
            self.assertAlmostEqual(a, b, delta=1e-5)

    def test_refusals(self):
        self.write("unknown.yaml", CAMPAIGN + "colour: red\n")
        self.assert_refused(self.sweep("unknown.yaml"), "unknown.yaml", "colour")
        self.write("key.yaml", CAMPAIGN.replace("cutting.cutting_force", "cutting.force"))
        self.assert_refused(self.sweep("key.yaml"), "needles.0.cutting.force", "cutting_force")
        self.assertFalse((self.folder / "out").exists(), "a refused campaign leaves no folder")
        self.assert_code(self.sweep("campaign.yaml", "--quiet"), DONE)
        self.assert_refused(self.sweep("campaign.yaml"), "not empty", "--force")
        self.assert_refused(self.sweep("campaign.yaml", "--resume", "--set", "time.step=10 ms"),
                            "plan.json", "another one")
        self.assert_refused(self.sweep("campaign.yaml", "--resume", "--force"), "--resume", "--force")
        self.write("out/sweep-campaign/mine.txt", "not the program's")
        self.assert_code(self.sweep("campaign.yaml", "--force", "--quiet"), DONE)
        self.assertTrue((self.folder / "out/sweep-campaign/mine.txt").exists())

    def test_parts_make_the_campaign(self):
        self.assert_code(self.sweep("campaign.yaml", "--output", "whole"), DONE)
        for part in ("1/3", "3/3"):
            self.assert_code(self.sweep("campaign.yaml", "--output", "parts", "--part", part), DONE)
        self.assertEqual([r["run"] for r in self.rows("parts/part-3")], ["00002", "00005"])
        outcome = self.sweep("campaign.yaml", "--output", "parts", "--join")
        self.assert_code(outcome, DONE)
        self.assertIn("4 of them kept", outcome.out)
        self.assertEqual(self.results("parts"), self.results("whole"))
        for k in range(6):
            self.assertTrue((self.folder / f"parts/scenes/{k:05d}.yaml").exists())
        for wrong in ("0/3", "4/3", "2", "a/b"):
            self.assert_refused(self.sweep("campaign.yaml", "--part", wrong), "--part", "K/N")
        self.assert_refused(self.sweep("campaign.yaml", "--join", "--output", "none"), "--join", "no part")
        self.assert_refused(self.sweep("campaign.yaml", "--join", "--part", "1/2"), "--part", "--join")

    def test_picture_and_report(self):
        outcome = self.stylet("sweep", "campaign.yaml")
        self.assert_code(outcome, DONE)
        if "needs python3" not in outcome.err:
            for name in ("study.png", "report.md", "statistics.json"):
                self.assertTrue((self.folder / "out/sweep-campaign" / name).exists(), name)


class Statistics(CliTest):
    """jobs/sweep.py on tables made here, of functions whose indices are known."""

    def indices(self, design, samples, points, values, ranges):
        variables = [{"name": f"x{j}", "column": f"x{j}", "from": low, "to": high, "scale": "linear"}
                     for j, (low, high) in enumerate(ranges)]
        plan = {"title": "", "design": design, "samples": samples, "seed": 1, "outputs": ["y"],
                "runs": len(points), "shifts": 1, "variables": variables,
                "points": [[str(x) for x in p] for p in points]}
        self.write("plan.json", json.dumps(plan))
        lines = ["run,point,status," + ",".join(v["name"] for v in variables) + ",y,error,wall_time"]
        lines += [f"{i},{i},done," + ",".join(map(repr, p)) + f",{y!r},,0"
                  for i, (p, y) in enumerate(zip(points, values, strict=True))]
        self.write("results.csv", "\n".join(lines) + "\n")
        outcome = call(["/usr/bin/python3", SOURCE / "jobs/sweep.py", "."], self.folder)
        if "needs python3" in outcome.err:
            self.skipTest(outcome.err.strip())
        self.assert_code(outcome, DONE)
        return json.loads((self.folder / "statistics.json").read_text())

    def test_sobol_indices_of_ishigami(self):
        import math
        import random

        draw = random.Random(1)
        n, d = 4096, 3
        a = [[draw.uniform(-math.pi, math.pi) for _ in range(d)] for _ in range(n)]
        b = [[draw.uniform(-math.pi, math.pi) for _ in range(d)] for _ in range(n)]
        points = a + b
        for j in range(d):
            points = points + [[b[i][k] if k == j else a[i][k] for k in range(d)] for i in range(n)]
        values = [math.sin(x) + 7 * math.sin(y) ** 2 + 0.1 * z ** 4 * math.sin(x) for x, y, z in points]
        found = self.indices("sobol", n, points, values, d * [(str(-math.pi), str(math.pi))])
        # Ishigami and Homma 1990, a = 7, b = 0.1; the sampling error of 4096 rows is about 0.02.
        for index, exact in zip(found["first"], (0.3139, 0.4424, 0.0)):
            self.assertAlmostEqual(index, exact, delta=0.05)
        for index, exact in zip(found["total"], (0.5576, 0.4424, 0.2437)):
            self.assertAlmostEqual(index, exact, delta=0.05)
        for (low, high), exact in zip(found["total_interval"], (0.5576, 0.4424, 0.2437)):
            self.assertLess(low - 0.02, exact)
            self.assertGreater(high + 0.02, exact)

    def test_morris_of_a_linear_function_is_exact(self):
        third = 1 / 3
        points = [[0, 0], [2 * third, 0], [2 * third, 2 * third], [1, third], [1, 1], [third, 1]]
        points = [[10 * x, y] for x, y in points]
        values = [0.3 * x - 2 * y + 1 for x, y in points]
        found = self.indices("morris", 2, points, values, [("0 mm", "10 mm"), ("0", "1")])
        for size, exact in zip(found["mu_star"], (3, 2)):  # over the whole range
            self.assertAlmostEqual(size, exact, places=9)
        for sigma in found["sigma"]:
            self.assertAlmostEqual(sigma, 0, places=9)


if __name__ == "__main__":
    unittest.main()
