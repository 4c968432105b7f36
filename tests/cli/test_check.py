"""The verb check: what it lists of a good scene, and what it finds before a run would."""

import json
import re
import unittest

from stylet_cli import BAD_INPUT, DONE, NEEDLE_SCENE, NUMERICAL, CliTest


def holed_mesh(n=12, size=0.06, hole=(5, 7)):
    """Gmsh 2.2 text of a square of n x n squares without those in the middle; curve 'left'."""
    def node(i, j):
        return j * (n + 1) + i + 1

    triangles = []
    for j in range(n):
        for i in range(n):
            if hole[0] <= i < hole[1] and hole[0] <= j < hole[1]:
                continue
            a, b, c, d = node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)
            triangles += [(a, b, c), (a, c, d)]
    used = sorted({k for triangle in triangles for k in triangle})
    number = {k: m for m, k in enumerate(used, 1)}
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", '1 2 "left"',
             '2 1 "tissue"', "$EndPhysicalNames", "$Nodes", str(len(used))]
    lines += [f"{number[k]} {(k - 1) % (n + 1) * size / n!r} {(k - 1) // (n + 1) * size / n!r} 0"
              for k in used]
    lines += ["$EndNodes", "$Elements", str(n + len(triangles))]
    lines += [f"{j + 1} 1 2 2 1 {number[node(0, j)]} {number[node(0, j + 1)]}" for j in range(n)]
    lines += [f"{k} 2 2 1 1 " + " ".join(str(number[m]) for m in triangle)
              for k, triangle in enumerate(triangles, n + 1)]
    return "\n".join([*lines, "$EndElements"]) + "\n"


HOLED_SCENE = """\
mesh: {file: holed.msh}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 50 kPa, poisson_ratio: 0.4, density: 1000 kg/m^3}}
  damping: {stiffness_factor: 0.05 s}
supports: {left: fixed}
needles:
  - height: 31 mm
    cutting: {cutting_force: 0.5 N, tip_length: 5 mm}
    motion: [insert: {speed: 2 cm/s, depth: 2 cm}]
time: {step: 50 ms}
"""


class Check(CliTest):
    def test_lists_what_it_found(self):
        self.write("scene.yaml", NEEDLE_SCENE + "membrane: {region: gland, puncture_force: 2 N}\n")
        outcome = self.stylet("check", "scene.yaml")
        self.assert_code(outcome, DONE)
        text = " ".join(outcome.out.split())
        for part in ("scene.yaml is valid", "triangles",
                     "gland 6 cm2 E 60 kPa, nu 0.4, 1000 kg/m3", "surrounding 42 cm2",
                     "left 6 cm fixed", "right 6 cm free",
                     "membrane", "holds up to 2 N",
                     "needle1 enters at (8, 3.2) cm, cuts at 1.7 N",
                     "way: surrounding from 0 to 3 cm, gland from 3 cm to 4 cm deep",
                     "the tissue ends at 8 cm", "meets the membrane at 3 cm",
                     "insert to depth 4 cm, position 4 cm: 2 s, 200 steps",
                     "implant at depth 4 cm, for 'seed'",
                     "retract all the way out: 2 s, 200 steps", "settle until all tissue is slower",
                     "implicit, 400 steps of 10 ms", "of memory", "on disk", "on one core"):
            self.assertIn(part, text)
        self.assertFalse((self.folder / "out").exists(), "check writes nothing")

    def test_lists_loads_and_notes(self):
        self.write("scene.yaml", NEEDLE_SCENE.replace("tip_length: 6 mm", "tip_length: 0 mm"))
        outcome = self.stylet(
            "check", "scene.yaml", "--set", "loads.body=[{force: [0 N/m^3, -9810 N/m^3]}]",
            "--set", "supports={left: fixed}", "--set",
            "prescribed=[{curve: top, displacement: [0 mm, -2 mm], start: 1 s, ramp: 2 s}]")
        self.assert_code(outcome, DONE)
        text = " ".join(outcome.out.split())
        for part in ("top 8 cm moved by (0, -2) mm from 1 s to 3 s",
                     "body force (0, -9810) N/m3", "where 'top' meets a support, at (0, 6) cm",
                     "note: needle 'needle1' has a point tip", "note: a support holds (0, 0.06) m"):
            self.assertIn(part, text)

    def test_way_through_a_hole(self):
        self.write("holed.msh", holed_mesh())
        self.write("scene.yaml", HOLED_SCENE)
        self.assert_code(self.stylet("check", "scene.yaml"), DONE)
        number = self.write_changed(HOLED_SCENE, "depth: 2 cm", "depth: 4.5 cm")
        self.assert_refused(self.stylet("check", "scene.yaml"), f"scene.yaml:{number}:",
                            "'needles.0.motion.0.insert'", "leaves the tissue at (0.035, 0.031) m",
                            "to enter it again at (0.025, 0.031) m")
        self.write_changed(HOLED_SCENE, "height: 31 mm", "height: 11 mm")
        self.assert_code(self.stylet("check", "scene.yaml", "--set", "needles.0.motion.0.depth=4.5 cm"),
                         DONE)

    def test_needle_that_never_cuts_in(self):
        """What only the run can know: exit 3, no placement error."""
        self.write_changed(NEEDLE_SCENE, "cutting_force: 1.7 N", "cutting_force: 90 N")
        self.assert_code(self.stylet("check", "scene.yaml"), DONE)
        outcome = self.stylet("run", "scene.yaml", "--set", "time.step=50 ms")
        self.assert_code(outcome, NUMERICAL)
        self.assert_message(outcome, "has not cut its way in", "of the 90 N that are needed")
        summary = json.loads((self.folder / "out/scene/summary.json").read_text())
        self.assertEqual(summary["status"], "failed")
        self.assertEqual(summary["seeds"], [])

    def test_notes_are_in_the_summary(self):
        self.write("scene.yaml", NEEDLE_SCENE)
        outcome = self.stylet("run", "scene.yaml", "--set", "needles.0.cutting.tip_length=0 mm",
                              "--set", "needles.0.motion.0.depth=1.5 cm", "--set", "time.step=50 ms")
        self.assert_code(outcome, DONE)
        summary = json.loads((self.folder / "out/scene/summary.json").read_text())
        self.assertIn("note: " + summary["notes"][-1], outcome.out)
        self.assertGreater(summary["largest_strain"]["value"], 0)
        self.assertGreater(summary["largest_strain"]["time"], 0)


class DryRun(CliTest):
    """run --dry-run says what would be run, and writes nothing."""

    def setUp(self):
        super().setUp()
        self.write("scene.yaml", NEEDLE_SCENE)

    def tell(self, *arguments):
        outcome = self.stylet("run", "scene.yaml", "--dry-run", "--set", "time.step=20 ms", *arguments)
        self.assert_code(outcome, DONE)
        return outcome.out

    def test_says_steps_and_writes_nothing(self):
        told = self.tell("--output", "new")
        self.assertRegex(told, r"200 steps of 20 ms")
        self.assertRegex(told, r"MB of memory, measured")
        self.assertRegex(told, r"takes .*steps have taken")
        self.assertIn("writes      to new, which is new", told)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["scene.yaml"])
        self.assertIn("100 steps of 20 ms, up to the last implant",
                      self.tell("--set", "time.until=implanted"))

    def test_says_what_becomes_of_earlier_results(self):
        run = ["run", "scene.yaml", "--quiet", "--output", "out", "--set", "time.step=20 ms"]
        self.assert_code(self.stylet(*run, "--until", "0.4 s"), DONE)
        before = sorted(p.stat().st_mtime_ns for p in (self.folder / "out").rglob("*"))
        self.assertIn("would be refused", self.tell("--output", "out"))
        self.assertIn("replacing", self.tell("--output", "out", "--force"))
        self.assertIn("going on after step 20, at t = 0.4 s",
                      self.tell("--output", "out", "--resume"))
        refused = self.stylet("run", "scene.yaml", "--dry-run", "--resume", "--output", "out",
                              "--set", "time.step=10 ms")
        self.assert_code(refused, BAD_INPUT)
        self.assert_message(refused, "time.step", "0.02 s")
        self.assertEqual(before, sorted(p.stat().st_mtime_ns for p in (self.folder / "out").rglob("*")))

    def test_disk_and_memory_are_those_of_the_run(self):
        told = self.tell("--output", "out", "--set", "output.snapshots=20 ms")
        said = float(re.search(r"about ([\d.]+) MB on disk", told)[1])
        self.assert_code(self.stylet("run", "scene.yaml", "--quiet", "--output", "out", "--set",
                                     "time.step=20 ms", "--set", "output.snapshots=20 ms"), DONE)
        taken = 1e-6 * sum(p.stat().st_size for p in (self.folder / "out").iterdir())
        self.assertLess(abs(said / taken - 1), 0.5, (said, taken))

    def test_what_the_run_would_refuse(self):
        outcome = self.stylet("run", "scene.yaml", "--dry-run", "--set", "time.step=-1 s")
        self.assert_message(outcome, "time.step")


if __name__ == "__main__":
    unittest.main()
