"""A scene that starts in the tissue that another run has left goes on as that run does, and what lies
before cannot be another one."""

import csv
import json
import unittest

from scenes import FaultTest

SHORT = ["--quiet", "--set", "time.step=20 ms", "--set", "needles.0.motion.3.duration=0.2 s"]
LOADS = "loads:\n  traction: [{curve: right, force: [2 N/m, 0 N/m]}]\n"
QUASI_STATIC = ["--set", "time.method=quasi_static", "--set", "tissue.damping=null"]


class Start(FaultTest):
    def run_in(self, folder, *arguments, code=0, scene="scene.yaml"):
        outcome = self.stylet("run", scene, *SHORT, "--output", folder, *arguments)
        self.assert_code(outcome, code)
        return outcome

    def left_by(self, folder):
        """The newest checkpoint."""
        return f"{folder}/checkpoints/" + max(
            path.name for path in (self.folder / folder / "checkpoints").iterdir())

    def rows(self, folder):
        with open(self.folder / folder / "history.csv", newline="") as file:
            return list(csv.reader(file))

    def test_the_same_future(self):
        """Bit for bit what the run that is resumed leaves; also with a step of its own."""
        for method in ([], QUASI_STATIC):
            with self.subTest(method=method):
                name = f"run{len(method)}"
                self.run_in(name, "--until", "1 s", *method)
                start = self.left_by(name)
                self.run_in(f"{name}b", *method, "--set", f"start.from={start}")
                n_before = len(self.rows(name))
                self.run_in(name, "--resume", *method)
                whole, part = self.rows(name), self.rows(f"{name}b")
                self.assertEqual(whole[0], part[0])
                self.assertEqual(whole[n_before:], part[1:])
                self.run_in(f"{name}c", *method, "--set", f"start.from={start}",
                            "--set", "time.step=15 ms")
                seeds = [json.loads((self.folder / f / "summary.json").read_text())["seeds"][0]
                         for f in (name, f"{name}c")]
                self.assertNotEqual(seeds[0], seeds[1])
                self.assertAlmostEqual(seeds[0]["placement_error"], seeds[1]["placement_error"],
                                       delta=0.2e-3)

    def test_another_future(self):
        """The needle is drawn back half, a second seed is left, a second needle follows."""
        self.run_in("one", "--until", "1 s")
        start = self.left_by("one")
        scene = (self.folder / "scene.yaml").read_text()
        needle = scene[scene.index("  - height"):scene.index("targets:")]
        needle = needle.replace("- implant", "- implant: {target: seed}")
        self.write("next.yaml", scene.replace("- implant", "- implant: {target: seed}").replace(
            "      - retract: {speed: 2 cm/s}\n",
            "      - retract: {speed: 2 cm/s, depth: 2 cm}\n      - implant: {target: other}\n"
            "      - retract: {speed: 2 cm/s}\n").replace(
            "targets:\n", needle.replace("3.2 cm", "2.8 cm") + "targets:\n  other: [5 cm, 3 cm]\n")
            + f"start: {{from: {start}}}\n")
        self.assert_code(self.stylet("run", "next.yaml", "--quiet", "--set", "time.step=20 ms",
                                     "--output", "next"), 0)
        summary = json.loads((self.folder / "next/summary.json").read_text())
        self.assertEqual([seed["target"] for seed in summary["seeds"]], ["seed", "other", "seed"])

    def test_a_needle_after_the_last_seed(self):
        """The end of the run before, at its last seed, is none where another needle follows."""
        until = ["--quiet", "--set", "time.step=20 ms", "--set", "time.until=implanted"]
        self.assert_code(self.stylet("run", "scene.yaml", *until, "--output", "one",
                                     "--set", "output.checkpoint.at_end=true"), 0)
        start = self.left_by("one")
        scene = (self.folder / "scene.yaml").read_text()
        needle = scene[scene.index("  - height"):scene.index("targets:")]
        self.write("next.yaml", scene.replace(
            "targets:\n", needle.replace("3.2 cm", "2.8 cm") + "targets:\n"))
        self.assert_code(self.stylet("run", "next.yaml", *until, "--output", "next",
                                     "--set", f"start.from={start}"), 0)
        self.assertEqual(len(json.loads((self.folder / "next/summary.json").read_text())["seeds"]), 2)

    def test_an_action_that_ends_where_it_begins(self):
        self.run_in("one", "--set", "needles.0.motion.2=hold: {duration: 0.1 s}",
                    "--set", "needles.0.motion.3=hold: {duration: 0.1 s}",
                    "--set", "output.checkpoint.at_end=true")
        start = self.left_by("one")
        scene = (self.folder / "scene.yaml").read_text().replace(
            "      - settle\n", "      - hold: {duration: 0.1 s}\n      - insert: {speed: 1 cm/s, depth: 4 cm}\n"
            "      - retract: {speed: 2 cm/s}\n").replace(
            "      - retract: {speed: 2 cm/s}\n      - hold", "      - hold: {duration: 0.1 s}\n      - hold")
        self.write("next.yaml", scene)
        self.assert_code(self.stylet("run", "next.yaml", "--quiet", "--set", "time.step=20 ms",
                                     "--output", "next", "--set", f"start.from={start}"), 0)

    def test_what_it_starts_from_is_part_of_it(self):
        self.run_in("one", "--until", "1 s")
        start = self.left_by("one")
        other = ["--set", f"start.from={start}"]
        self.assert_message(self.run_in("one", "--force", *other, code=2), "start.from", "--force")
        self.run_in("two", *other)
        self.run_in("two", "--resume", *other)
        self.assert_code(self.stylet("run", "scene.yaml", *SHORT, "--set", "time.step=15 ms",
                                     "--output", "one", "--force", "--until", "1 s"), 0)
        (self.folder / self.left_by("one")).rename(self.folder / start)
        refused = self.run_in("two", "--resume", *other, code=2)
        self.assert_message(refused, "two", "--force")
        self.assert_message(self.run_in("three", "--until", "0.5 s", *other, code=2), "--until")
        for verb in ("converge", "tradeoff", "stability"):
            self.assert_message(self.stylet(verb, "scene.yaml", *other), "start")

    def test_loaded_tissue(self):
        """Loaded first, then pierced: quasi-static tissue remembers no order."""
        # Depths would be counted from the skin as it has moved.
        scene = (self.folder / "scene.yaml").read_text().replace("depth:", "position:") + LOADS
        self.write("both.yaml", scene)
        without = scene[:scene.index("needles:")] + scene[scene.index("targets:"):]
        self.write("loaded.yaml", without.replace("  step: 10 ms", "  step: 10 ms\n  duration: 0.1 s"))
        only = ["--quiet", *QUASI_STATIC, "--set", "time.step=20 ms"]
        self.assert_code(self.stylet("run", "loaded.yaml", *only, "--output", "loaded",
                                     "--set", "output.checkpoint.at_end=true"), 0)
        start = self.left_by("loaded")
        for name, changes in (("at_once", []), ("after", [f"start.from={start}"])):
            self.run_in(name, *QUASI_STATIC, *(x for c in changes for x in ("--set", c)),
                        scene="both.yaml")
        at_once, after = (json.loads((self.folder / f / "summary.json").read_text())
                          for f in ("at_once", "after"))
        self.assertAlmostEqual(at_once["seeds"][0]["placement_error"],
                               after["seeds"][0]["placement_error"], delta=1e-6)
        self.assertGreater(after["time"], at_once["time"] + 0.1)

    def test_refused(self):
        self.run_in("one", "--until", "1 s")
        start = self.left_by("one")
        for change, name in (("tissue.regions.gland.youngs_modulus=61 kPa", "youngs_modulus"),
                             ("mesh.refine=1", "mesh.refine"),
                             ("needles.0.height=3 cm", "needles.0.height"),
                             ("needles.0.motion.0.insert.depth=3.9 cm", "needles.0.motion.0"),
                             ("time.method=quasi_static", "time.method"),
                             ("needle_angle=170 deg", "needle_angle"),
                             ("membrane={region: gland, puncture_force: 1 N}", "membrane"),
                             ("supports.top=free", "supports.top")):
            refused = self.run_in("two", "--set", f"start.from={start}", "--set", change, code=2)
            self.assert_message(refused, name, start)
        self.run_in("late", "--until", "2.4 s")  # the seed is left
        refused = self.run_in("two", "--set", f"start.from={self.left_by('late')}",
                              "--set", "targets={other: [4 cm, 3.2 cm]}", code=2)
        self.assert_message(refused, "implant.target", "other", "seed")
        torn = self.folder / start
        torn.write_bytes(torn.read_bytes()[:-100])
        refused = self.run_in("two", "--set", f"start.from={start}", code=2)
        self.assert_message(refused, "start.from", "no whole checkpoint")
        refused = self.run_in("two", "--set", "start.from=nowhere.h5", code=2)
        self.assert_message(refused, "start.from", "nowhere.h5")
        before = (self.folder / "one/summary.json").read_bytes()
        self.assert_message(self.run_in("one", "--force", "--until", "0 s", code=2), "--until")
        self.assertEqual(before, (self.folder / "one/summary.json").read_bytes())
        self.assert_code(self.stylet("modes", "3", "scene.yaml", "--set", f"start.from={start}"), 2)


if __name__ == "__main__":
    unittest.main()
