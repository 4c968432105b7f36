"""Small inputs that would grow without bound or never end: refused, in little memory."""

import os
import resource
import shutil
import unittest

from stylet_cli import (BAD_INPUT, BLOCK_SCENE, DONE, NEEDLE_SCENE, OTHER, PROGRAM, CliTest, block_mesh,
                        call)

GIGABYTE = 1 << 30


def in_memory(size):
    """The process may have so many bytes of address space; a run of a small scene needs 0.3 GB."""
    return lambda: resource.setrlimit(resource.RLIMIT_AS, (size, size))


class HostileInput(CliTest):
    def refuse(self, arguments, *parts):
        outcome = self.stylet(*arguments, preexec_fn=in_memory(GIGABYTE))
        self.assert_refused(outcome, *parts)
        self.assertLess(len(outcome.err), 2000, "a message is no copy of the input")

    def test_stray_comma_and_bracket(self):
        self.write("scene.yaml", NEEDLE_SCENE)
        for value in (",5 ms", "5 ms]", "}", "[1, 2]]"):
            self.refuse(["check", "scene.yaml", "--set", f"time.step={value}"], "override")

    def test_null_character_in_a_number(self):
        self.write("scene.yaml", NEEDLE_SCENE.replace("1.7 N", '"1\\0.7 N"'))
        self.refuse(["check", "scene.yaml"], "scene.yaml:20:", "U+0000 (null character)")
        self.write("scene.yaml", NEEDLE_SCENE.replace("1.7 N", "1\0.7 N"))
        self.refuse(["check", "scene.yaml"], "scene.yaml:20:", "U+0000 (null character)")

    def test_latin_1(self):
        (self.folder / "scene.yaml").write_bytes(NEEDLE_SCENE.encode() + b"# gr\xf6\xdfer\n")
        line = NEEDLE_SCENE.count("\n") + 1
        self.refuse(["check", "scene.yaml"], f"scene.yaml:{line}:5:", "byte 0xF6 is not UTF-8")
        self.write("campaign.yaml", "scene: scene.yaml\noutputs: [time]\n"
                   "vary: {h: {key: needles.0.height, values: [3 cm]}}\n")
        self.refuse(["sweep", "campaign.yaml"], f"scene.yaml:{line}:5:", "byte 0xF6 is not UTF-8")

    def test_files_without_end(self):
        self.refuse(["check", "/dev/zero"], "/dev/zero", "is a device")
        self.write("scene.yaml", NEEDLE_SCENE)
        self.refuse(["check", "scene.yaml", "--set", "mesh={file: /dev/zero}"], "/dev/zero",
                    "is a device")

    def test_long_keys_and_aliases(self):
        items = "1," * 50_000
        for text in (f"? {'k' * 200_000}\n: [{items}]\n",
                     f"a: &a [{items}]\nb: &b [{'*a,' * 100}]\nc: [{'*b,' * 100}]\n",
                     f"a: &a {'x' * 200_000}\nb: [{'*a,' * 60_000}]\n", "[" * 400_000):
            self.write("scene.yaml", text)
            self.refuse(["check", "scene.yaml"], "scene.yaml:", "too large")

    def test_many_groups_of_many_elements(self):
        n = 20_000
        head = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
        nodes = "$Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n"
        tags = " ".join(map(str, range(1, n + 1)))
        lines = "\n".join(f"{i} 1 2" for i in range(2, n + 2))
        curve = (f"$Entities\n0 1 1 0\n1 0 0 0 1 0 0 {n} {tags} 0\n1 0 0 0 1 1 0 1 1 0\n$EndEntities\n"
                 f"{nodes}$Elements\n2 {n + 1} 1 {n + 1}\n2 1 2 1\n1 1 2 3\n1 1 1 {n}\n{lines}\n"
                 "$EndElements\n")
        triangles = "\n".join(f"{i} 1 2 3" for i in range(1, n + 1))
        surface = (f"$Entities\n0 0 1 0\n1 0 0 0 1 1 0 {n} {tags} 0\n$EndEntities\n"
                   f"{nodes}$Elements\n1 {n} 1 {n}\n2 1 2 {n}\n{triangles}\n$EndElements\n")
        self.write("scene.yaml", BLOCK_SCENE)
        self.write("block.msh", head + curve)
        self.refuse(["check", "scene.yaml"], "block.msh:", f"{n} physical groups; allowed: 64")
        self.write("block.msh", head + surface)
        self.refuse(["check", "scene.yaml"], "block.msh:", "two physical groups, '1' and '2'")

    def test_campaign_without_end(self):
        self.write("scene.yaml", NEEDLE_SCENE)
        self.write("campaign.yaml", "scene: scene.yaml\noutputs: [seeds.0.placement_error]\n"
                   "vary: {h: {key: needles.0.height, from: 3 cm, to: 4 cm}}\n"
                   "design: sobol\nsamples: 1000000000\n")
        self.refuse(["sweep", "campaign.yaml"], "campaign.yaml:5:", "'samples'", "at most 100000")

    def test_memory_runs_out(self):
        """Refused where it can be known, else exit code 1, in words, on one rank and on two."""
        self.write("scene.yaml", BLOCK_SCENE)
        self.write("block.msh", block_mesh(n=16)[0])
        outcome = self.stylet("check", "scene.yaml", "--set", "mesh.refine=5",
                              preexec_fn=in_memory(550 << 20))
        self.assert_refused(outcome, "'mesh.refine'", "GB of memory", "allowed here: up to 4")
        arguments = ["check", "scene.yaml", "--set", "mesh.refine=4"]
        # How much the libraries take beside the mesh is the machine's: from too little up to enough.
        codes = []
        for megabytes in range(280, 600, 10):
            outcome = self.stylet(*arguments, preexec_fn=in_memory(megabytes << 20))
            codes.append(outcome.code)
            if outcome.code == DONE:
                break
            with self.subTest(megabytes=megabytes):
                self.assertIn(outcome.code, (BAD_INPUT, OTHER))
                self.assert_message(outcome, "memory")
        self.assertIn(OTHER, codes)
        self.assertEqual(codes[-1], DONE)
        mpirun = [os.environ["STYLET_MPIEXEC"], "--oversubscribe", "-n", "2", shutil.which("sh"),
                  "-c", 'ulimit -v 400000; exec "$@"', "sh", PROGRAM]
        environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1",
                           OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                           OMPI_MCA_btl_vader_single_copy_mechanism="none")
        outcome = call([*mpirun, *arguments], self.folder, env=environment)
        self.assertNotEqual(outcome.code, 0)
        self.assertIn("memory", outcome.err)


if __name__ == "__main__":
    unittest.main()
