"""Mesh files that cannot be run."""

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

    def test_clockwise_triangle_is_turned(self):
        def turn(triangles):
            a, b, c = triangles[3]
            return triangles[:3] + [(a, c, b)] + triangles[4:]

        self.write("scene.yaml", BLOCK_SCENE)
        self.write("block.msh", block_mesh(edit=turn)[0])
        self.assert_code(self.stylet("run", "scene.yaml"), 0)

    def test_duplicate_triangle(self):
        text, _ = block_mesh(edit=lambda triangles: triangles + [triangles[3]])
        self.refuse(text, "block.msh", "triangle 9 (nodes 2, 6, 5", "duplicate of triangle 4")

    def test_duplicate_triangle_at_the_side(self):
        text, _ = block_mesh(edit=lambda triangles: triangles + [triangles[0]])
        self.refuse(text, "block.msh", "triangle 9 (nodes 1, 2, 5", "duplicate of triangle 1")

    def test_unnamed_region(self):
        text, lines = block_mesh(region=0)
        self.refuse(text, f"block.msh:{lines[0]}:", "unnamed region", 'Physical Surface("name")')

    def test_region_number_without_a_name(self):
        text, lines = block_mesh(region=7)
        self.refuse(text, f"block.msh:{lines[0]}:", "physical surface 7 has no name")

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
