"""Mesh files that cannot be run."""

import json
import unittest

from stylet_cli import BLOCK_SCENE, CliTest, block_mesh


class BadMesh(CliTest):
    def refuse(self, text, *parts):
        self.write("scene.yaml", BLOCK_SCENE)
        self.write("block.msh", text)
        outcome = self.stylet("run", "scene.yaml")
        self.assert_refused(outcome, *parts)
        self.assertFalse((self.folder / "out").exists())
        return outcome

    def test_the_mesh_itself_is_good(self):
        self.write("scene.yaml", BLOCK_SCENE)
        self.write("block.msh", block_mesh()[0])
        self.assert_code(self.stylet("run", "scene.yaml"), 0)

    def test_clockwise_triangles_are_turned(self):
        """Exit 0, and the same numbers as with the triangles the right way round."""
        summaries = []
        for turned in (set(), {0, 3, 4}):
            self.write("scene.yaml", BLOCK_SCENE)
            self.write("block.msh", block_mesh(edit=lambda triangles: [
                (a, c, b) if i in turned else (a, b, c)
                for i, (a, b, c) in enumerate(triangles)])[0])
            self.assert_code(self.stylet("run", "scene.yaml", "--force", "--output", "out",
                                         "--set", "loads.body=[{force: [0 N/m^3, -1 kN/m^3]}]",
                                         "--set", "probes.p=[2 cm, 1 cm]"), 0)
            summaries.append(json.loads((self.folder / "out/summary.json").read_text())["probes"])
        self.assertEqual(*summaries)

    def test_folded_triangle(self):
        text, lines = block_mesh()
        old, new = "5 0.01 0.01 0", "5 0.025 0.0105 0"
        self.assertIn(old, text)
        self.refuse(text.replace(old, new), "block.msh:", "overlaps", "same side of a shared edge")

    def test_duplicate_triangle(self):
        text, lines = block_mesh(edit=lambda triangles: triangles + [triangles[3]])
        self.refuse(text, f"block.msh:{lines[8]}: triangle 11 (nodes 2, 6, 5",
                    "duplicate of triangle 6")

    def test_duplicate_triangle_at_the_side(self):
        text, lines = block_mesh(edit=lambda triangles: triangles + [triangles[0]])
        self.refuse(text, f"block.msh:{lines[8]}: triangle 11 (nodes 1, 2, 5",
                    "duplicate of triangle 3")

    def test_unnamed_region(self):
        text, lines = block_mesh(region=0)
        self.refuse(text, f"block.msh:{lines[0]}:", "unnamed region", 'Physical Surface("name")')

    def test_region_number_without_a_name(self):
        """The number is its name."""
        self.refuse(block_mesh(region=7)[0], "block.msh", "'tissue'", "the mesh has: 7")
        self.write("scene.yaml", BLOCK_SCENE.replace("    tissue:", "    7:"))
        self.assert_code(self.stylet("check", "scene.yaml"), 0)

    def test_truncated(self):
        text = block_mesh()[0]
        for part in (0.3, 0.5, 0.8):
            with self.subTest(part=part):
                cut = text[: int(part * len(text))]
                line = cut.rstrip("\n").count("\n") + 1
                outcome = self.refuse(cut, "block.msh:", "truncated?")
                self.assertRegex(outcome.err, rf"block.msh:({line}|{line + 1}):")

    def test_empty(self):
        self.refuse("", "block.msh:1:", "empty", "$MeshFormat")

    def test_other_text(self):
        self.refuse("solid\n", "block.msh:1:", "'solid'", "is this a Gmsh file?")

    def test_missing(self):
        self.write("scene.yaml", BLOCK_SCENE)
        self.assert_refused(self.stylet("run", "scene.yaml"), "block.msh", "cannot be read",
                            "No such file")


if __name__ == "__main__":
    unittest.main()
