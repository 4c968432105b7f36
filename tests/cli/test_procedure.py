"""A recorded procedure runs as a scene; pictures of scenes."""

import json
import struct
import unittest
import zlib

from stylet_cli import DONE, NEEDLE_SCENE, NUMERICAL, SOURCE, CliTest, call, on_ranks

ROWS = """\
- {move: {speed: 0 m/s, duration: 0.05 s, steps: 5}}
- {enter: {height: 3.2 cm, cutting: {cutting_force: 1.7 N, tip_length: 6 mm}, \
friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s, slip_speed: 1.5 mm/s}}}
- {move: {speed: 0.02 m/s, duration: 1 s, steps: 100}}
- {change: {key: tissue.regions.gland.youngs_modulus, value: 80000}}
- {move: {speed: 0.025 m/s, duration: 0.8 s, steps: 80}}
- {implant: {target: seed}}
- {move: {speed: -0.04 m/s, duration: 1.4 s, steps: 140}}
"""
FRAMES = ["/usr/bin/python3", "-B", str(SOURCE / "jobs/frames.py")]


def without(text, start, end):
    return text[: text.index(start)] + text[text.index(end):]


RECORDED = without(NEEDLE_SCENE, "needles:", "targets:") + "procedure: {file: rows.yaml}\n"


def png(width, height):
    """A black picture."""
    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    rows = (b"\0" + bytes(width)) * height
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


class Procedure(CliTest):
    def setUp(self):
        super().setUp()
        self.write("scene.yaml", RECORDED)
        self.write("rows.yaml", ROWS)

    def summary(self, folder):
        return json.loads((self.folder / folder / "summary.json").read_text())

    def run_to(self, folder, scene="scene.yaml", *arguments, ranks=1):
        outcome = on_ranks(ranks, self.folder, "run", scene, "--output", folder, *arguments)
        self.assert_code(outcome, DONE)
        return outcome

    def test_runs_again_with_the_same_bits(self):
        for ranks in (1, 2):
            self.run_to(f"one{ranks}", ranks=ranks)
            self.run_to(f"two{ranks}", f"one{ranks}/scene.yaml", ranks=ranks)
            histories = [(self.folder / f"{name}{ranks}/history.csv").read_bytes()
                         for name in ("one", "two")]
            self.assertTrue(histories[0] == histories[1], "history.csv differs")
        errors = [self.summary(name)["seeds"][0]["placement_error"] for name in ("one1", "one2")]
        self.assertGreater(errors[0], 1e-4)
        self.assertAlmostEqual(errors[0], errors[1], delta=1e-8 * errors[0])
        score = self.summary("one1")["score"]
        self.assertAlmostEqual(score["mean_error"], errors[0], delta=1e-6)
        self.assertEqual(score["missed"], [])

    def test_a_torn_row_is_left_out_with_a_note(self):
        self.write("rows.yaml", ROWS + "- {implant: {tar")
        outcome = self.run_to("torn")
        self.assertIn("note: ", outcome.out)
        self.assertIn("rows.yaml: its last row", outcome.out)

    def test_what_a_scene_with_needles_may_not_a_procedure_may_not(self):
        outcome = self.stylet("run", "scene.yaml", "--set", "time.step=2 s")
        self.assert_refused(outcome, "'time.step'", "too long for needle 'needle1'",
                            "pushed for 1.8 s", "allowed: at most 0.8 s")
        for duration, parts in (("1e-200 s", ["a row of 1e-200 s", "1e-9 of time.step"]),
                                ("1e300 s", ["'time.step'", "at most 1e12 steps"])):
            self.write("rows.yaml", ROWS.replace("duration: 0.8 s", f"duration: {duration}"))
            self.assert_refused(self.stylet("run", "scene.yaml"), *parts)
        self.write("rows.yaml", ROWS)
        outcome = self.stylet("run", "scene.yaml", "--set", "expect=[{quantity: peak_needle_force}]")
        self.assert_refused(outcome, "'expect.0'", "a min or a max")
        self.write("rows.yaml", ROWS.replace("target: seed", "target: sede"))
        self.assert_refused(self.stylet("run", "scene.yaml"), "target 'sede'", "allowed: seed")

    def test_a_hand_that_outruns_its_increments_is_stopped(self):
        self.write("rows.yaml", ROWS.replace("tip_length: 6 mm",
                                             "tip_length: 6 mm, law: increment, increment: 0.1 mm"))
        outcome = self.stylet("run", "scene.yaml", "--force")
        self.assert_code(outcome, NUMERICAL)
        self.assertIn("cuts 0.0001 m at most", outcome.err)

    def test_a_push_of_few_steps_has_a_note(self):
        self.run_to("few", "scene.yaml", "--set", "time.step=0.7 s")
        self.assertIn("fewer than four steps", " ".join(self.summary("few")["notes"]))

    def test_notes_and_fingerprints_are_those_of_its_rows(self):
        self.run_to("one")
        self.write("rows.yaml", ROWS.replace("tip_length: 6 mm", "tip_length: 0 mm"))
        self.run_to("two")
        self.assertIn("has a point tip", " ".join(self.summary("two")["notes"]))
        self.assertNotEqual(self.summary("one")["fingerprints"]["procedure"],
                            self.summary("two")["fingerprints"]["procedure"])

    def test_rows_that_cannot_be_done_name_their_file(self):
        self.write("rows.yaml", ROWS.replace("key: tissue.regions.gland.youngs_modulus",
                                             "key: tissue.thickness"))
        self.assert_refused(self.stylet("run", "scene.yaml"), "rows.yaml: key 'tissue.thickness'")

    def test_refusals(self):
        def refuse(*parts, verb=("run",), scene=None, rows=ROWS):
            self.write("scene.yaml", scene or RECORDED)
            self.write("rows.yaml", rows)
            self.assert_refused(self.stylet(*verb, "scene.yaml"), *parts)

        refuse("rows.yaml:7:", "speed", rows=ROWS.replace("-0.04 m/s", "-0.04"))
        refuse("rows.yaml", "has no rows", rows="# nothing yet\n")
        refuse("key 'hand.courage'", rows=ROWS.replace("tissue.regions.gland.youngs_modulus",
                                                       "hand.courage"))
        both = NEEDLE_SCENE + "procedure: {file: rows.yaml}\n"
        refuse("'needles'", "procedure.file", scene=both)
        for verb in ("plan", "tradeoff", "stability"):
            refuse("'procedure'", verb=(verb,))
        refuse("'procedure'", "--store", verb=("converge", "--store"))

    def test_converges(self):
        outcome = self.stylet("converge", "scene.yaml", "--mesh-levels", "1", "--step-levels", "2",
                              "--quiet")
        self.assert_code(outcome, DONE)


class Image(CliTest):
    def test_is_written_and_drawn(self):
        self.write("scene.yaml", NEEDLE_SCENE.replace("snapshots: 100 ms", "snapshots: 1 s")
                   + "image: {seed: 1}\n")
        self.assert_code(self.stylet("run", "scene.yaml", "--output", "one", "--quiet"), DONE)
        self.assertTrue((self.folder / "one/image.png").read_bytes().startswith(b"\x89PNG"))
        self.assert_code(call([*FRAMES, "one", "--field", "image", "--no-gif"], self.folder), DONE)
        self.assertTrue((self.folder / "one/frames/overview.png").exists())

    def test_refusals(self):
        (self.folder / "black.png").write_bytes(png(30, 20))
        (self.folder / "torn.png").write_bytes(png(30, 20)[:48])
        self.write("text.png", "no picture")
        place = ", origin: [1 cm, 1 cm], size: [3 cm, 2 cm]}\n"
        for name, parts in (("black.png", ()), ("torn.png", ("torn.png", "PNG")),
                            ("text.png", ("text.png", "neither")), ("none.png", ("none.png",))):
            self.write("scene.yaml", NEEDLE_SCENE + "image: {file: " + name + place)
            outcome = self.stylet("check", "scene.yaml")
            if parts:
                self.assert_refused(outcome, "scene.yaml:", "key 'image.file'", *parts)
            else:
                self.assert_code(outcome, DONE)


if __name__ == "__main__":
    unittest.main()
