"""jobs/report.py: one page of a run that holds everything, whatever became of the run."""

import base64
import csv
import html.parser
import json
import re
import unittest

from stylet_cli import BAD_INPUT, BLOCK_SCENE, DONE, NEEDLE_SCENE, NUMERICAL, SOURCE, CliTest, block_mesh, call

PNG = b"\x89PNG\r\n\x1a\n"
VOID = {"meta", "img", "br"}


class Page(html.parser.HTMLParser):
    """Text, pictures and whatever would be fetched; every element is closed where it should be."""

    def __init__(self, text):
        super().__init__()
        self.open, self.words, self.pictures, self.fetched = [], [], [], []
        self.feed(text)
        self.close()
        if self.open:
            raise AssertionError(f"not closed: {self.open}")
        self.text = " ".join("".join(self.words).split())

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        if tag == "img":
            kind, data = values["src"].split(",", 1)
            assert kind == "data:image/png;base64" and values["alt"], values
            self.pictures.append(base64.b64decode(data))
        self.fetched += [values[key] for key in ("href", "src")
                         if key in values and not values[key].startswith("data:")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if self.open.pop() != tag:
            raise AssertionError(f"</{tag}> closes another element")

    def handle_data(self, data):
        self.words.append(data)


class Report(CliTest):
    def report(self, folder, *options):
        return call(["/usr/bin/python3", "-B", str(SOURCE / "jobs/report.py"), folder, *options], self.folder)

    def page(self, folder):
        outcome = self.report(folder)
        if "needs python3" in outcome.err:
            self.skipTest(outcome.err.strip())
        self.assert_code(outcome, DONE)
        page = Page((self.folder / folder / "report.html").read_text(encoding="utf-8"))
        self.assertEqual(page.fetched, [], "the page is one file")
        for picture in page.pictures:
            self.assertTrue(picture.startswith(PNG))
        return page

    def test_a_run_with_needle(self):
        self.write("needle.yaml", NEEDLE_SCENE + "expect:\n"
                   "  - {quantity: seeds.0.placement_error, min: 1 mm, max: 20 mm}\n")
        self.assert_code(self.stylet("run", "needle.yaml", "--output", "out"), DONE)
        summary = json.loads((self.folder / "out/summary.json").read_text())
        page = self.page("out")
        self.assertEqual(len(page.pictures), 2, "moments and curves")
        error = 1e3 * summary["seeds"][0]["placement_error"]
        self.assertIn(f"placement error of the seed for 'seed'{error:.5g} mm", page.text)
        self.assertIn(f"peak needle force{summary['peak_needle_force']:.5g} N", page.text)
        self.assertIn("The run was completed.", page.text)
        self.assertIn("met.", page.text)
        self.assertIn("is not known", page.text)  # no study is stored beside this scene
        self.assertIn(summary["fingerprints"]["scene"], page.text)
        self.assertIn(summary["versions"]["petsc"], page.text)
        # Once more replaces the page; a page that somebody changed stays.
        self.page("out")
        path = self.folder / "out/report.html"
        path.write_text(path.read_text() + "mine")
        outcome = self.report("out")
        self.assert_code(outcome, BAD_INPUT)
        self.assertIn("report.html", outcome.err)

    def test_bands_of_a_stored_study(self):
        """As `stylet run` prints them."""
        self.write("needle.yaml", NEEDLE_SCENE)
        self.assert_code(self.stylet("run", "needle.yaml", "--output", "out"), DONE)
        path = self.folder / "out/summary.json"
        summary = json.loads(path.read_text())
        summary["peak_needle_force"] = 5.9646
        summary["uncertainty"] = {"peak_needle_force": {"mesh": 0.04, "step": 0.0003, "total": 0.04}}
        path.write_text(json.dumps(summary))
        page = self.page("out")
        self.assertIn("5.965 ± 0.040 N (mesh 0.040, step 0.000)", page.text)

    def test_a_seed_beyond_small_strain(self):
        self.write("needle.yaml", NEEDLE_SCENE)
        soft = [word for region in ("gland", "surrounding")
                for word in ("--set", f"tissue.regions.{region}.youngs_modulus=12 kPa")]
        outcome = self.stylet("run", "needle.yaml", "--output", "out", *soft)
        self.assert_code(outcome, DONE)
        summary = json.loads((self.folder / "out/summary.json").read_text())
        over = summary["seeds"][0]["turned_over"]
        self.assertGreater(over, 0)
        self.assertRegex(outcome.out, rf"placement error.* mm, NOT TO BE TRUSTED: .*: {over}\n")
        self.assertIn("note: beyond small strain:", outcome.out)
        page = self.page("out")
        self.assertRegex(page.text, rf"placement error of the seed for 'seed'[^:]*not to be trusted: .*: {over}")

    def test_a_run_without_needle_and_snapshots(self):
        self.write("block.msh", block_mesh()[0])
        self.write("scene.yaml", BLOCK_SCENE + "probes: {a <b>: [1 cm, 1 cm]}\n")
        self.assert_code(self.stylet("run", "scene.yaml", "--output", "out"), DONE)
        page = self.page("out")
        self.assertEqual(page.pictures, [])
        self.assertIn("displacement of probe 'a <b>'", page.text)
        self.assertIn("no snapshots", page.text)

    def test_a_run_that_failed(self):
        # Without damping and friction the tissue never rests.
        text = NEEDLE_SCENE.replace("  damping:\n    stiffness_factor: 0.05 s\n", "")
        self.write("needle.yaml", text.replace("cutting_force: 1.7 N", "cutting_force: 900 N"))
        self.assert_code(self.stylet("run", "needle.yaml", "--output", "out"), NUMERICAL)
        error = json.loads((self.folder / "out/summary.json").read_text())["error"]
        page = self.page("out")
        self.assertIn("The run failed.", page.text)
        self.assertIn(" ".join(error.split()), page.text)

    def test_a_history_cut_short(self):
        self.write("needle.yaml", NEEDLE_SCENE)
        self.assert_code(self.stylet("run", "needle.yaml", "--output", "out"), DONE)
        path = self.folder / "out/history.csv"
        text = path.read_text()
        with open(path, encoding="utf-8") as file:
            self.assertGreater(len(list(csv.reader(file))), 100)
        path.write_text(text[: int(0.7 * len(text))])
        self.assertEqual(len(self.page("out").pictures), 2)

    def test_what_is_no_run(self):
        (self.folder / "empty").mkdir()
        outcome = self.report("empty")
        self.assert_code(outcome, BAD_INPUT)
        self.assertRegex(outcome.err, re.compile(r"summary\.json is missing"))
        (self.folder / "other").mkdir()
        self.write("other/summary.json", '{"status": "completed"}')
        self.assert_code(self.report("other"), BAD_INPUT)


if __name__ == "__main__":
    unittest.main()
