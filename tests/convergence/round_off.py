#!/usr/bin/python3
"""Noise floor of the placement error: the reference scene in other numberings of its mesh.

usage: round_off.py PROGRAM [RUNS] [--most MM] [KEY=VALUE ...]

Nodes and elements of the mesh are shuffled, so that every sum is taken in another order and the
factor is another one. The physics is the same: what differs is round-off, stopping tolerances and
what the needle's decisions make of them. Prints E of each run and the spread, and fails if that is
more than --most.
"""
import argparse
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

SCENE = pathlib.Path(__file__).resolve().parents[2] / "input/prostate.yaml"
MESH = SCENE.parent.parent / "meshes/prostate.msh"


def shuffled(text, seed):
    """A Gmsh 2.2 file with its nodes and elements in another order, under other numbers."""
    draw = random.Random(seed)
    lines = text.splitlines()
    nodes, elements = lines.index("$Nodes"), lines.index("$Elements")
    end_nodes, end_elements = lines.index("$EndNodes"), lines.index("$EndElements")
    old = [line.split() for line in lines[nodes + 2:end_nodes]]
    draw.shuffle(old)
    new_of_old = {node[0]: str(i + 1) for i, node in enumerate(old)}
    cells = [line.split() for line in lines[elements + 2:end_elements]]
    draw.shuffle(cells)
    for i, cell in enumerate(cells):
        first = 3 + int(cell[2])
        corners = [new_of_old[node] for node in cell[first:]]
        turn = draw.randrange(3) if len(corners) == 3 else 0
        cell[0], cell[first:] = str(i + 1), corners[turn:] + corners[:turn]
    return "\n".join(lines[:nodes + 2] + [" ".join([new_of_old[n[0]]] + n[1:]) for n in old] +
                     lines[end_nodes:elements + 2] + [" ".join(c) for c in cells] +
                     lines[end_elements:]) + "\n"


def placement_error(program, folder, settings):
    command = [program, "run", str(SCENE), "--quiet", "--force", "--output", str(folder / "out"),
               "--set", "expect=null", "--set", "output.snapshots=null"]
    for setting in settings:
        command += ["--set", setting]
    subprocess.run(command, check=True)
    return json.loads((folder / "out/summary.json").read_text())["seeds"][0]["placement_error"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("runs", nargs="?", type=int, default=10)
    parser.add_argument("settings", nargs="*", metavar="KEY=VALUE")
    parser.add_argument("--most", type=float, default=math.inf, help="largest spread (mm)")
    given = parser.parse_args()
    errors = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run(["gmsh", str(MESH), "-save", "-format", "msh22", "-v", "2", "-o",
                        str(folder / "mesh22.msh")], check=True)
        text = (folder / "mesh22.msh").read_text()
        for seed in range(given.runs):
            mesh = folder / "mesh.msh"
            mesh.write_text(shuffled(text, seed) if seed else text)
            errors.append(1e3 * placement_error(given.program, folder,
                                                [f"mesh.file={mesh}"] + given.settings))
            print(f"{errors[-1]:.15f} mm", flush=True)
    spread = max(errors) - min(errors)
    print(f"{given.runs} numberings: spread {spread:.1e} mm")
    if spread > given.most:
        sys.exit(f"more than {given.most:g} mm")


if __name__ == "__main__":
    main()
