"""What the tests of the command line share: scenes, meshes and runs of the program.

The environment names the program (STYLET) and the source tree (STYLET_SOURCE).
"""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

PROGRAM = os.environ["STYLET"]
SOURCE = pathlib.Path(os.environ["STYLET_SOURCE"])
DONE, OTHER, BAD_INPUT, NUMERICAL, IO = 0, 1, 2, 3, 4
TIMEOUT = 600  # s; only a hang takes so long: the runs below take seconds, on a busy machine minutes
AS_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
           "OMPI_MCA_mpi_yield_when_idle": "1"}

# A needle in a block of two regions: small, yet with every part that can be wrong.
NEEDLE_SCENE = """\
mesh:
  rectangle:
    size: [8 cm, 6 cm]
    columns: 16
    rows: 12
    region: surrounding
    inner_regions:
      - {name: gland, polygon: [[2 cm, 2 cm], [5 cm, 2 cm], [5 cm, 4 cm], [2 cm, 4 cm]]}
tissue:
  plane: stress
  regions:
    gland: {youngs_modulus: 60 kPa, poisson_ratio: 0.4, density: 1000 kg/m^3}
    surrounding: {youngs_modulus: 50 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}
  damping:
    stiffness_factor: 0.05 s
supports: {left: fixed, top: fixed, bottom: fixed}
needles:
  - height: 3.2 cm
    cutting:
      cutting_force: 1.7 N
      tip_length: 6 mm
    friction:
      static_force: 195 N/m
      kinetic_force: 130 N/m
      stick_speed: 1 mm/s
      slip_speed: 1.5 mm/s
    motion:
      - insert: {speed: 2 cm/s, depth: 4 cm}
      - implant
      - retract: {speed: 2 cm/s}
      - settle
targets:
  seed: [4 cm, 3.2 cm]
time:
  step: 10 ms
output:
  snapshots: 100 ms
"""

# One element deep, no needle: for what happens before and around a run.
BLOCK_SCENE = """\
mesh:
  file: block.msh
tissue:
  plane: stress
  regions:
    tissue:
      youngs_modulus: 60 kPa
      poisson_ratio: 0.3
      density: 1000 kg/m^3
supports:
  left: fixed
time:
  method: quasi_static
"""


class Outcome:
    def __init__(self, code, out, err):
        self.code, self.out, self.err = code, out, err

    def __str__(self):
        return f"exit code {self.code}\nstdout: {self.out}\nstderr: {self.err}"


def own_lines(text):
    """Without what Open MPI's hwloc remarks where /sys is hidden."""
    return "".join(line for line in text.splitlines(True) if not line.startswith("[hwloc/"))


def call(command, cwd, **options):
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, errors="replace",
                          timeout=TIMEOUT, **options)
    return Outcome(done.returncode, done.stdout, own_lines(done.stderr))


def on_ranks(n, cwd, *arguments, environment=os.environ, **options):
    """The program on n ranks; mpirun's own environment is as the tests need it."""
    command = [PROGRAM, *map(str, arguments)]
    if n > 1:
        command = [os.environ["STYLET_MPIEXEC"], "--oversubscribe", "-n", str(n), *command]
    return call(command, cwd, env=environment | AS_ROOT, **options)


def block_mesh(n=2, edit=lambda triangles: triangles, region=1):
    """Gmsh 2.2 text of a 2 x 2 cm block of n x n squares; `edit` changes the list of triangles.

    Returns the text and the line number of each triangle.
    """
    def node(i, j):
        return j * (n + 1) + i + 1

    points = [(0.02 * i / n, 0.02 * j / n) for j in range(n + 1) for i in range(n + 1)]
    triangles, sides = [], []
    for j in range(n):
        for i in range(n):
            a, b, c, d = node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)
            triangles += [(a, b, c), (a, c, d)]
    for j in range(n):
        sides.append((node(0, j), node(0, j + 1)))
    triangles = edit(triangles)
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", '1 2 "left"',
             '2 1 "tissue"', "$EndPhysicalNames", "$Nodes", str(len(points))]
    lines += [f"{k} {x!r} {y!r} 0" for k, (x, y) in enumerate(points, 1)]
    lines += ["$EndNodes", "$Elements", str(len(sides) + len(triangles))]
    lines += [f"{k} 1 2 2 1 {a} {b}" for k, (a, b) in enumerate(sides, 1)]
    first_line = len(lines) + 1
    lines += [f"{k} 2 2 {region} 1 {a} {b} {c}"
              for k, (a, b, c) in enumerate(triangles, len(sides) + 1)]
    lines.append("$EndElements")
    return "\n".join(lines) + "\n", range(first_line, first_line + len(triangles))


class CliTest(unittest.TestCase):
    """Each test has an empty folder of its own, `self.folder`, in which the program runs."""

    def setUp(self):
        self.maxDiff = None
        holder = tempfile.TemporaryDirectory(prefix="stylet_cli_")
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def write(self, name, text):
        (self.folder / name).write_text(text, encoding="utf-8")

    def write_changed(self, text, old, new, name="scene.yaml"):
        """Writes `text` with its one `old` replaced; returns the number of the changed line."""
        self.assertEqual(text.count(old), 1, f"'{old}' is to be found once")
        self.write(name, text.replace(old, new))
        return text[: text.index(old)].count("\n") + 1

    def stylet(self, *arguments, **options):
        return call([PROGRAM, *map(str, arguments)], self.folder, **options)

    def background(self, command, **options):
        """A process that ends with the test."""
        process = subprocess.Popen(list(map(str, command)), cwd=self.folder, **options)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def unseal(self, folder):
        """Makes a folder what a killed program leaves: it cannot have fingerprints of its files."""
        marks = self.folder / folder / ".stylet"
        lines = marks.read_text().splitlines(True)
        marks.write_text("".join(line for line in lines if not line.startswith("sealed ")))

    def assert_code(self, outcome, code):
        self.assertEqual(outcome.code, code, str(outcome))

    def assert_message(self, outcome, *parts):
        """One message on stderr, with all these parts in it."""
        messages = [line for line in outcome.err.splitlines() if line.startswith("stylet: ")]
        self.assertEqual(len(messages), 1, f"one message is expected\n{outcome}")
        for part in parts:
            self.assertIn(str(part), outcome.err)
        self.assertNotRegex(outcome.err, re.compile("terminate called|MPI_ABORT|PETSC ERROR"))

    def assert_refused(self, outcome, *parts):
        self.assert_code(outcome, BAD_INPUT)
        self.assert_message(outcome, *parts)
