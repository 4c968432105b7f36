"""Scenes that cannot be run: exit code 2 and what is wrong, where, and what is allowed."""

import unittest

from stylet_cli import NEEDLE_SCENE, CliTest


class BadScene(CliTest):
    def refuse(self, old, new, *parts, line=True):
        number = self.write_changed(NEEDLE_SCENE, old, new)
        place = f"scene.yaml:{number}:" if line else "scene.yaml: "
        self.assert_refused(self.stylet("run", "scene.yaml"), place, *parts)
        self.assertFalse((self.folder / "out").exists(), "a refused scene leaves no output")

    def test_missing_unit(self):
        self.refuse("cutting_force: 1.7 N", "cutting_force: 1.7",
                    "'needles.0.cutting.cutting_force'", "'1.7'", "needs a unit", "> 0 N")

    def test_wrong_dimension(self):
        self.refuse("cutting_force: 1.7 N", "cutting_force: 1.7 m",
                    "'needles.0.cutting.cutting_force'", "'1.7 m'", "not convertible to N", "> 0 N")

    def test_unknown_unit(self):
        self.refuse("cutting_force: 1.7 N", "cutting_force: 1.7 Newt",
                    "'needles.0.cutting.cutting_force'", "unknown unit 'Newt'", "> 0 N")

    def test_unknown_key_names_the_nearest(self):
        self.refuse("tip_length", "tip_lenght", "'needles.0.cutting.tip_lenght'", "'6 mm'",
                    "nearest known key is 'tip_length'", "allowed: law, cutting_force")

    def test_incompressible(self):
        self.refuse("poisson_ratio: 0.45", "poisson_ratio: 0.5",
                    "'tissue.regions.surrounding.poisson_ratio'", "'0.5'", "< 0.5")

    def test_negative_stiffness(self):
        self.refuse("youngs_modulus: 60 kPa", "youngs_modulus: -60 kPa",
                    "'tissue.regions.gland.youngs_modulus'", "'-60 kPa'", "> 0 Pa")

    def test_slip_speed_below_stick_speed(self):
        self.refuse("slip_speed: 1.5 mm/s", "slip_speed: 0.5 mm/s",
                    "'needles.0.friction.slip_speed'", "'0.5 mm/s'", "> stick_speed, which is 0.001")

    def test_target_outside_the_tissue(self):
        self.refuse("seed: [4 cm, 3.2 cm]", "seed: [9 cm, 3.2 cm]",
                    "'targets.seed'", "(0.09", "outside the tissue, which spans", line=False)

    def test_coordinates_are_those_of_the_scene(self):
        """Also where the needle's direction turns them; and with the digits that matter."""
        self.write("scene.yaml", NEEDLE_SCENE)
        for angle in ("30 deg", "180 deg", "0°"):
            outcome = self.stylet("check", "scene.yaml", "--set", f"needle_angle={angle}",
                                  "--set", "targets.seed=[8.00001 cm, 3.2 cm]")
            self.assert_refused(outcome, "'targets.seed': (0.0800001, 0.032) m lies outside",
                                "0.08, 0.06) m")

    def test_round_off_beside_the_boundary_is_inside(self):
        self.write("scene.yaml", NEEDLE_SCENE)
        self.assert_code(self.stylet("check", "scene.yaml", "--set",
                                     "probes.p=[8.00000001 cm, 3.2 cm]"), 0)

    def test_what_cannot_be_seen(self):
        self.refuse("  step: 10 ms", "  step: 0,01 s", "'time.step'", "decimal comma; write 0.01 s")
        self.refuse("  step: 10 ms", "  step\u00a0: 10 ms", "U+00A0 (non-breaking space)")
        self.refuse("  plane: stress", "  plane: str\u200bess", "U+200B (zero-width space)")
        self.refuse("  plane: stress", "  plane: \u201cstress\u201d", "typographic quotes")

    def test_needle_that_misses(self):
        self.refuse("height: 3.2 cm", "height: 7 cm",
                    "'needles", "0.07", "misses the tissue", "which spans", line=False)

    def test_needle_that_would_leave_the_tissue(self):
        self.refuse("depth: 4 cm", "depth: 40 cm", "'needles.0.motion.0.insert'", "leaves the tissue at (0, 0.032) m")

    def test_region_that_the_mesh_lacks(self):
        self.refuse("    gland: {young", "    glund: {young",
                    "'tissue.regions'", "'glund'", "the mesh has: surrounding, gland", line=False)

    def test_tiny_snapshot_interval(self):
        """No endless loop: a snapshot a step at most."""
        self.write_changed(NEEDLE_SCENE, "snapshots: 100 ms", "snapshots: 1e-300 s")
        outcome = self.stylet("run", "scene.yaml", "--set", "needles.0.motion.0.depth=15 mm")
        self.assert_code(outcome, 0)

    def test_yaml_syntax(self):
        self.refuse("supports: {left", "supports: {{left", "not valid YAML")
        self.write_changed(NEEDLE_SCENE, "  step: 10 ms", "\tstep: 10 ms")
        self.assert_refused(self.stylet("run", "scene.yaml"), "scene.yaml:", "not valid YAML")

    def test_missing_scene(self):
        self.assert_refused(self.stylet("run", "nowhere.yaml"), "nowhere.yaml", "cannot be read",
                            "No such file")

    def test_folder_as_scene(self):
        self.assert_refused(self.stylet("check", "."), "cannot be read", "is a folder")

    def test_empty_scene(self):
        self.write("scene.yaml", "")
        self.assert_refused(self.stylet("run", "scene.yaml"), "scene.yaml", "mesh")

    def test_check_refuses_what_run_refuses(self):
        number = self.write_changed(NEEDLE_SCENE, "cutting_force: 1.7 N", "cutting_force: 1.7")
        self.assert_refused(self.stylet("check", "scene.yaml"), f"scene.yaml:{number}:")


if __name__ == "__main__":
    unittest.main()
