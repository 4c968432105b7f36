"""What decides a result: other meshes, options and versions are told apart; hidden options do not act."""

import hashlib
import json
import os
import subprocess
import time
import unittest

from stylet_cli import (BLOCK_SCENE, DONE, IO, NUMERICAL, PROGRAM, SOURCE, CliTest, block_mesh, call,
                        on_ranks)

PULLED = BLOCK_SCENE.replace("method: quasi_static", "method: quasi_static\n  step: 0.5 s\n"
                             "  duration: 1 s") + """\
loads:
  body: [{force: [0 N/m^3, -9810 N/m^3]}]
probes:
  corner: [2 cm, 2 cm]
"""
CAMPAIGN = """\
scene: scene.yaml
design: grid
vary:
  stiffness: {key: tissue.regions.tissue.youngs_modulus, values: [50 kPa, 60 kPa, 70 kPa]}
outputs: [probes.corner.1]
"""
LEVELS = ["--mesh-levels", "2", "--step-levels", "1", "--no-picture", "--quiet"]


def other_mesh():
    """The block with its first node moved inwards a little."""
    return block_mesh()[0].replace("\n1 0.0 0.0 0\n", "\n1 0.0 0.0001 0\n")


class Identity(CliTest):
    def setUp(self):
        super().setUp()
        self.write("block.msh", block_mesh()[0])
        self.write("scene.yaml", PULLED)
        self.write("campaign.yaml", CAMPAIGN)
        self.assertNotEqual(other_mesh(), block_mesh()[0])

    def summary(self, folder):
        return json.loads((self.folder / folder / "summary.json").read_text())

    def corner(self, folder):
        return self.summary(folder)["probes"]["corner"][1]

    def test_reference_scene_has_its_stored_study(self):
        # A default that scene.yaml did not have, or another mesh, would cost it its band.
        outcome = self.stylet("run", str(SOURCE / "input/prostate.yaml"), "--output", "reference")
        self.assert_code(outcome, DONE)
        self.assertIn("for 'seed': 6.20 \N{PLUS-MINUS SIGN} 0.31 mm", outcome.out)

    def test_summary_has_fingerprints_and_options(self):
        self.assert_code(self.stylet("run", "scene.yaml", "--", "-ksp_rtol", "1e-10",
                                     "-pc_type", "jacobi"), DONE)
        summary = self.summary("out/scene")
        for name, path in (("mesh", "block.msh"), ("scene", "out/scene/scene.yaml")):
            digest = hashlib.sha256((self.folder / path).read_bytes()).hexdigest()
            self.assertEqual(summary["fingerprints"][name], digest)
        self.assertEqual(summary["solver_options"], ["-ksp_rtol 1e-10", "-pc_type jacobi"])

    def test_hidden_options_do_not_act(self):
        self.assert_code(self.stylet("run", "scene.yaml", "--output", "plain"), DONE)
        hidden = "-ksp_type preonly\n-pc_type none\n-ksp_rtol 1\n"
        for name in ("petscrc", ".petscrc"):
            self.write(name, hidden)
        units = "<unit-system><unit><base/><name><singular>meter</singular></name>" \
                "<symbol>m</symbol></unit></unit-system>"
        self.write("units.xml", units)
        environment = os.environ | {"HOME": str(self.folder),
                                    "PETSC_OPTIONS": hidden.replace("\n", " "),
                                    "PETSC_OPTIONS_YAML": "ksp_rtol: 1",
                                    "UDUNITS2_XML_PATH": str(self.folder / "units.xml")}
        for n in (1, 2):
            outcome = on_ranks(n, self.folder, "run", "scene.yaml", "--output", f"on{n}",
                               environment=environment)
            self.assert_code(outcome, DONE)
            self.assertEqual(self.summary(f"on{n}")["solver_options"], [])
            self.assertAlmostEqual(self.corner(f"on{n}"), self.corner("plain"),
                                   delta=1e-9 * abs(self.corner("plain")))

    def test_options_cannot_make_an_answer_wrong(self):
        self.assert_refused(self.stylet("run", "scene.yaml", "--", "-ksp_rtol", "1"), "-ksp_rtol",
                            "1e-8")
        outcome = self.stylet("run", "scene.yaml", "--force", "--", "-ksp_type",
                              "richardson", "-ksp_norm_type", "none", "-ksp_max_it", "2",
                              "-pc_type", "jacobi")
        self.assert_code(outcome, NUMERICAL)
        self.assert_message(outcome, "residual", "solver options")
        self.assertEqual(self.summary("out/scene")["status"], "failed")
        self.assert_refused(self.stylet("modes", 2, "scene.yaml", "--", "-eps_target", "1e9"),
                            "-eps_target", "which modes")

    def test_resume_refuses_another_mesh_program_and_options(self):
        sweep = ["sweep", "campaign.yaml", "--no-picture", "--quiet", "--resume"]
        self.assert_code(self.stylet(*sweep), DONE)
        before = (self.folder / "out/sweep-campaign/results.csv").read_bytes()
        self.write("block.msh", other_mesh())
        self.assert_refused(self.stylet(*sweep), "the bytes of block.msh", "differs")
        self.write("block.msh", block_mesh()[0])
        self.assert_refused(self.stylet(*sweep, "--", "-ksp_rtol", "1e-9"), "solver_options")
        self.assert_refused(self.stylet(*sweep, "--set", "time.step=0.25 s"), "set")
        self.write("scene.yaml", PULLED.replace("0.3", "0.4"))
        self.assert_refused(self.stylet(*sweep), "scene")
        self.write("scene.yaml", PULLED)
        self.assert_code(self.stylet(*sweep, "--", "-log_view", ":log.txt"), DONE)
        self.assertEqual((self.folder / "out/sweep-campaign/results.csv").read_bytes(), before)
        plan = self.folder / "out/sweep-campaign/plan.json"
        self.unseal("out/sweep-campaign")
        plan.write_text(plan.read_text().replace('"stylet 0.', '"stylet 9.'))
        self.assert_refused(self.stylet(*sweep), "differs: program;")

    def test_joined_parts_are_of_one_mesh(self):
        sweep = ["sweep", "campaign.yaml", "--no-picture", "--quiet", "--output", "parts"]
        self.assert_code(self.stylet(*sweep, "--part", "1/2"), DONE)
        self.write("block.msh", other_mesh())
        self.assert_code(self.stylet(*sweep, "--part", "2/2"), DONE)
        self.assert_refused(self.stylet(*sweep, "--join"), "part-1", "the bytes of block.msh")

    def test_stored_accuracy_is_of_one_mesh(self):
        self.assert_code(self.stylet("converge", "scene.yaml", "--store", *LEVELS), DONE)
        outcome = self.stylet("run", "scene.yaml", "--output", "same")
        self.assertIn("uncertainty", self.summary("same") | {"uncertainty": 1})
        self.assertNotIn("accuracy.json is", outcome.out)
        self.write("block.msh", other_mesh())
        outcome = self.stylet("run", "scene.yaml", "--output", "other")
        self.assert_code(outcome, DONE)
        self.assertIn("scene.accuracy.json is of another mesh file", outcome.out)
        self.assertIn("converge --store", outcome.out)
        self.assert_refused(self.stylet("run", "scene.yaml", "--output", "no", "--accuracy", "1 mm"),
                            "another mesh file", "converge --store")

    def test_stored_accuracy_of_earlier_versions_and_by_hand(self):
        stored = self.folder / "scene.accuracy.json"
        self.assert_code(self.stylet("converge", "scene.yaml", "--store", *LEVELS), DONE)
        whole = json.loads(stored.read_text())
        for change, told in (({"program": "9.0"}, "changed since"), ({"fingerprint": None}, "earlier")):
            study = {k: v for k, v in (whole | change).items() if v is not None}
            stored.write_text(json.dumps(study))
            outcome = self.stylet("run", "scene.yaml", "--output", told.split()[0])
            self.assert_code(outcome, DONE)
            self.assertIn(told, outcome.out)
            self.assertIn("numerical error unknown", outcome.out)
        again = ["converge", "scene.yaml", "--store", "--force", *LEVELS]
        self.assert_code(self.stylet(*again), DONE)  # the earlier version's is replaced
        self.assertIn("fingerprint", json.loads(stored.read_text()))
        for foreign in ("mine\n", json.dumps(whole | {"program": "9.0"})):
            stored.write_text(foreign)
            self.assert_refused(self.stylet(*again), "scene.accuracy.json", "not replaced")
            self.assertEqual(stored.read_text(), foreign)

    def test_missing_mesh_is_named_before_a_campaign(self):
        self.write("campaign.yaml", CAMPAIGN.replace(
            "stiffness: {key: tissue.regions.tissue.youngs_modulus, values: [50 kPa, 60 kPa, 70 kPa]}",
            "mesh: {key: mesh.file, values: [block.msh, second.msh]}"))
        sweep = ["sweep", "campaign.yaml", "--no-picture", "--quiet"]
        self.assert_refused(self.stylet(*sweep), "second.msh", "cannot be read")
        self.assertFalse((self.folder / "out").exists())
        self.write("second.msh", other_mesh())
        self.assert_code(self.stylet(*sweep), DONE)

    def test_mesh_that_changes_or_vanishes_during_a_campaign_is_no_result(self):
        sweep = ["sweep", "campaign.yaml", "--no-picture", "--quiet", "--set", "time.step=0.01 ms"]
        mesh = self.folder / "block.msh"
        for name, told in (("changed", "was changed while the study ran"), ("gone", "cannot be read")):
            self.write("block.msh", block_mesh()[0])
            program = self.background([PROGRAM, *sweep, "--output", name], stderr=subprocess.PIPE,
                                      text=True)
            while program.poll() is None and not (self.folder / name / "scenes/00000.yaml").exists():
                time.sleep(0.001)
            if name == "gone":
                mesh.unlink()
            else:
                self.write("block.msh", other_mesh())
            err = program.communicate()[1]
            self.assertEqual(program.returncode, IO, err)
            self.assertIn(told, err)
            rows = (self.folder / name / "results.csv").read_text().splitlines()[1:]
            self.assertTrue(all(",done," in row for row in rows), rows)
            self.assertEqual(self.summary(name)["status"], "failed")
            self.assertIn(told, self.summary(name)["error"])


if __name__ == "__main__":
    unittest.main()
