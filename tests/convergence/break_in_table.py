#!/usr/bin/python3
"""Break-in: does the tip's place in the tissue have a limit at every depth? Markdown tables.

usage: break_in_table.py [--program build/stylet] [--scenes ...] [--tables depth,membrane]
                         [--depths 2,5,...] [--meshes 0-4] [--steps 20,5,1] [--laws ...]
                         [--planes ...] [--method quasi_static] [-j N] [--quick]

depth: the needle stops at a depth and leaves a seed there, whose target is the tip itself: the
displacement of the tissue at the tip (mm), on meshes of 1, 4, 16, ... times the triangles, for each
law and step. Orders and limits are Richardson's of the last three meshes; "none" where the changes
do not shrink. Marked are

  !  a value whose distance from that on the mesh before is more than TREND times the distance
     before (a tenth of a millimetre and 2 % are free): off the trend of the meshes;
  o  a tip that still stands on the skin;
  *  a value that is further from the median of all laws and steps on its mesh than 0.1 mm, 5 % and
     the way of the needle in one step, by which `lagged` may be late.

membrane: a polygon whose nearest edge is at the skin, 2 mm below it and in mid-tissue: for how long
it holds the tip (ms), how far the tip had come when it broke (mm), and the largest tip force (N).

Meshes from --long-steps-from on are run with the longest step only.
"""
import argparse
import concurrent.futures
import csv
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
TREND = 1.5
FREE_LENGTH, FREE_SHARE = 0.1, 0.02  # mm; of the value
OUTSIDE = 1e-3  # mm; a tip that is no deeper in the tissue is outside
AGREE_LENGTH, AGREE_SHARE = 0.1, 0.05
MEMBRANE_DEPTH = 0.03  # m, where the needle stops in the table of membranes


class Scene:
    """file: which scene; right, height: of the entry (m); speed (m/s); the rest: settings."""

    def __init__(self, file, right, height, speed, puncture_force, settings):
        self.file, self.right, self.height, self.speed = ROOT / file, right, height, speed
        self.puncture_force, self.settings = puncture_force, settings

    def stopped_at(self, depth):
        return {"needles.0.motion":
                f"[insert: {{speed: {self.speed} m/s, depth: {depth} m}}, implant]",
                "targets.seed": f"[{self.right - depth:.9g} m, {self.height} m]"}

    def membrane_at(self, depth):
        near, far = self.right - depth, 0.3 * self.right
        low, high = self.height - 0.012, self.height + 0.012
        corners = [(near, low), (near, high), (far, high), (far, low)]
        polygon = ", ".join(f"[{x:.9g} m, {y:.9g} m]" for x, y in corners)
        return {"membrane": f"{{polygon: [{polygon}], puncture_force: {self.puncture_force} N}}"}


SCENES = {
    "reference": Scene("input/prostate.yaml", 0.08, 0.032, 0.02, 2.55, {
        "expect": "null", "output.snapshots": "null", "time.until": "implanted"}),
    "break_in": Scene("tests/scenes/break_in.yaml", 0.07, 0.023, 0.01, 1.2, {}),
}
MEMBRANES = {"at the skin": 0.0, "2 mm below": 0.002, "mid-tissue": 0.02}


class Program:
    def __init__(self, path, settings):
        self.path, self.settings = path, settings

    def run(self, scene, settings, read):
        """What `read` finds in the folder of a run, or the first words of its refusal."""
        with tempfile.TemporaryDirectory() as name:
            command = [self.path, "run", str(scene.file), "--quiet", "--force", "--output", name]
            for key, value in (scene.settings | self.settings | settings).items():
                command += ["--set", f"{key}={value}"]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode != 0:
                return f"exit {done.returncode}: {done.stderr.strip()}"
            return read(pathlib.Path(name))


def placement(folder):
    """mm"""
    return 1e3 * json.loads((folder / "summary.json").read_text())["seeds"][0]["placement_error"]


def puncture(folder, right):
    """(ms held, mm of the tip when it broke, N at most)"""
    held, reached, peak, last = 0.0, math.nan, 0.0, 0.0
    with open(folder / "history.csv", newline="") as file:
        for row in csv.DictReader(file):
            time = float(row["time [s]"])
            peak = max(peak, float(row["force_tip [N]"] or 0))
            if row["membrane_held"] == "1":
                held += time - last
                reached = right - float(row["tip_world_x [m]"])
            last = time
    return 1e3 * held, 1e3 * reached, peak


def richardson(values):
    """Cells with order and limit of the last three values, each on a mesh twice as fine."""
    numbers = [v for v in values if v is not None]
    if len(numbers) < 3 or not all(isinstance(v, float) for v in numbers[-3:]):
        return ["", ""]
    a, b, c = numbers[-3:]
    if abs(c - b) < OUTSIDE:
        return ["", ""]
    if (b - a) / (c - b) <= 1:
        return ["none", ""]
    ratio = (b - a) / (c - b)
    return [f"{math.log2(ratio):.2f}", f"{c + (c - b) / (ratio - 1):.2f}"]


def off_trend(values):
    """Places of values whose distance from the one before has grown."""
    found = set()
    for i in range(2, len(values)):
        if not all(isinstance(v, float) for v in values[i - 2:i + 1]):
            continue
        free = FREE_LENGTH + FREE_SHARE * abs(values[i])
        if abs(values[i] - values[i - 1]) > TREND * abs(values[i - 1] - values[i - 2]) + free:
            found.add(i)
    return found


def header(columns):
    print("| " + " | ".join(columns) + " |\n|" + "---|" * len(columns))


def cell(value, marks, digits=2):
    if value is None:
        return ""
    return f"{value:.{digits}f}{marks}" if isinstance(value, float) else "refused"


def settings_of(given, plane, law, step, mesh):
    settings = {"tissue.plane": plane, "needles.0.cutting.law": law, "time.step": f"{step:g} ms",
                "mesh.refine": mesh}
    if given.method:
        settings["time.method"] = given.method
    return settings


def is_run(given, step, mesh):
    return mesh < given.long_steps_from or step == max(given.steps)


class Tally:
    def __init__(self):
        self.values, self.refusals, self.marked = 0, {}, 0

    def add(self, value, marks):
        if value is None:
            return
        self.values += 1
        self.marked += bool(marks)
        if isinstance(value, str):
            self.refusals[value] = self.refusals.get(value, 0) + 1

    def print(self):
        print(f"\n{self.values} runs, {sum(self.refusals.values())} refused, {self.marked} marked.")
        for message, n in self.refusals.items():
            print(f"- {n}: {message}")


def depth_tables(given, program, pool):
    for (name, scene), plane in ((s, p) for s in given.scenes for p in given.planes):
        jobs = {}
        for depth in given.depths:
            for law in given.laws:
                for step in given.steps:
                    for mesh in given.meshes:
                        if not is_run(given, step, mesh):
                            continue
                        settings = settings_of(given, plane, law, step, mesh)
                        jobs[depth, law, step, mesh] = pool.submit(
                            program.run, scene, settings | scene.stopped_at(1e-3 * depth),
                            placement)
        print(f"\n## {name}, plane {plane}: displacement of the tissue at the tip, mm\n")
        header(["depth, mm", "law", "step, ms"] + [f"mesh {m}" for m in given.meshes] +
               ["order", "limit"])
        tally = Tally()
        for depth in given.depths:
            found = {key[1:]: job.result() for key, job in jobs.items() if key[0] == depth}
            depth_rows(given, scene, depth, found, tally)
        tally.print()
        sys.stdout.flush()


def depth_rows(given, scene, depth, found, tally):
    median = {}
    for mesh in given.meshes:
        numbers = [v for key, v in found.items() if key[-1] == mesh and isinstance(v, float)]
        median[mesh] = statistics.median(numbers) if numbers else math.nan
    for law in given.laws:
        for step in given.steps:
            values = [found.get((law, step, mesh)) for mesh in given.meshes]
            trend = off_trend(values)
            cells = []
            for i, (mesh, value) in enumerate(zip(given.meshes, values)):
                marks = "!" if i in trend else ""
                if isinstance(value, float) and value > depth - OUTSIDE:
                    marks += "o"
                allowed = AGREE_LENGTH + AGREE_SHARE * abs(median[mesh]) + scene.speed * step
                if isinstance(value, float) and abs(value - median[mesh]) > allowed:
                    marks += "*"
                tally.add(value, marks)
                cells.append(cell(value, marks))
            cells += richardson(values)
            print(f"| {depth:g} | {law} | {step:g} | " + " | ".join(cells) + " |")


def membrane_tables(given, program, pool):
    for (name, scene), plane in ((s, p) for s in given.scenes for p in given.planes):
        jobs = {}
        for where, depth in MEMBRANES.items():
            for law in given.laws:
                for step in given.steps:
                    for mesh in given.meshes:
                        if not is_run(given, step, mesh):
                            continue
                        settings = settings_of(given, plane, law, step, mesh)
                        settings |= scene.stopped_at(MEMBRANE_DEPTH) | scene.membrane_at(depth)
                        jobs[where, law, step, mesh] = pool.submit(
                            program.run, scene, settings,
                            lambda folder, right=scene.right: puncture(folder, right))
        print(f"\n## {name}, plane {plane}: membrane that breaks at {scene.puncture_force} N: "
              "held, ms / tip when it broke, mm / largest tip force, N\n")
        header(["membrane", "law", "step, ms"] + [f"mesh {m}" for m in given.meshes] +
               ["order", "limit, mm"])
        tally = Tally()
        for where in MEMBRANES:
            for law in given.laws:
                for step in given.steps:
                    values = [jobs[where, law, step, mesh].result()
                              if is_run(given, step, mesh) else None for mesh in given.meshes]
                    reached = ["never held" if isinstance(v, tuple) and not v[0] > 0 else
                               v[1] if isinstance(v, tuple) else v for v in values]
                    trend = off_trend(reached)
                    cells = []
                    for i, value in enumerate(values):
                        marks = "!" if i in trend else ""
                        if isinstance(value, tuple) and not value[0] > 0:
                            marks += "*"  # never held
                        tally.add(value, marks)
                        cells.append(f"{value[0]:.0f} / {value[1]:.2f} / {value[2]:.3f}{marks}"
                                     if isinstance(value, tuple) else cell(value, marks))
                    cells += richardson(reached)
                    print(f"| {where} | {law} | {step:g} | " + " | ".join(cells) + " |")
        tally.print()
        sys.stdout.flush()


def numbers(kind):
    def parse(text):
        found = []
        for part in text.split(","):
            first, dash, last = part.partition("-")
            found += range(int(first), int(last) + 1) if dash else [kind(first)]
        return found
    return parse


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", default=ROOT / "build/stylet")
    parser.add_argument("--scenes", default="reference,break_in")
    parser.add_argument("--tables", default="depth,membrane")
    parser.add_argument("--depths", type=numbers(float), default=[2, 5, 10, 15, 20, 30, 45],
                        help="mm")
    parser.add_argument("--meshes", type=numbers(int), default=[0, 1, 2, 3, 4])
    parser.add_argument("--long-steps-from", type=int, default=4, metavar="MESH")
    parser.add_argument("--steps", type=numbers(float), default=[20, 5, 1], help="ms")
    parser.add_argument("--laws", default="consistent,lagged")
    parser.add_argument("--planes", default="stress,strain")
    parser.add_argument("--method", help="time.method instead of the scene's")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("-j", type=int, default=1, metavar="N", help="runs at a time")
    parser.add_argument("--quick", action="store_true", help="meshes 0 to 2, steps 20 and 5 ms")
    given = parser.parse_args()
    if given.quick:
        given.meshes, given.steps = [0, 1, 2], [20, 5]
    given.laws, given.planes = given.laws.split(","), given.planes.split(",")
    given.scenes = [(name, SCENES[name]) for name in given.scenes.split(",")]
    os.environ["OMP_NUM_THREADS"] = "1"
    program = Program(str(given.program), dict(item.split("=", 1) for item in given.set))
    tables = {"depth": depth_tables, "membrane": membrane_tables}
    with concurrent.futures.ThreadPoolExecutor(given.j) as pool:
        for name in given.tables.split(","):
            tables[name](given, program, pool)


if __name__ == "__main__":
    main()
