#!/usr/bin/python3
"""Placement error of the reference scene under mesh and step refinement, as Markdown tables.

usage: scene_table.py FOLDER [--program build/stylet] [--tables mesh,law,step,damping,strain,onset] [--finest 2]

The needle is pushed 3 mm beyond the usual depth. E is the mean, over the last 6 mm of its way and
over needle heights of 30.5, 32 and 33.5 mm, of the distance between the needle's tip and the place
in the tissue at rest that it stands in: the placement error of a seed that would be left there for
a target there. FOLDER keeps one line a run (runs.csv): what is there is not run again.
"""
import argparse
import csv
import itertools
import json
import pathlib
import subprocess
import time

import numpy as np

HEIGHTS = ("32 mm", "30.5 mm", "33.5 mm")
START, SPEED, WINDOW = 0.08, 0.02, (0.032, 0.038)  # m, m/s, m
BASE = {"expect": "null", "output.snapshots": "null", "time.step": "10 ms", "time.until": "settled",
        "needles.0.motion": "[{insert: {speed: 2 cm/s, position: 3.2 cm}}]"}
SCENE = pathlib.Path(__file__).resolve().parents[2] / "input/prostate.yaml"


def placement(folder, height):
    """Mean (m) of the error over the window."""
    with open(folder / "history.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    column = lambda name: np.array([float(row[name]) for row in rows])
    needle = START - SPEED * column("time [s]")
    error = np.hypot(column("tip_reference_x [m]") - needle, column("tip_reference_y [m]") - height)
    inside = (needle > WINDOW[0] - 1e-9) & (needle < WINDOW[1] + 1e-9)
    x, e = -needle[inside], error[inside]
    if len(e) < 2:
        raise ValueError("the window holds less than two steps")
    return np.trapz(e, x) / (x[-1] - x[0])


class Runs:
    def __init__(self, program, folder):
        self.program, self.folder = program, folder
        folder.mkdir(parents=True, exist_ok=True)
        self.table = folder / "runs.csv"
        self.known = {}
        if self.table.exists():
            with open(self.table, newline="") as file:
                self.known = {row[0]: row[1:] for row in csv.reader(file)}

    def one(self, height, settings):
        """(E in mm or None, seconds, what went wrong)."""
        settings = BASE | {"needles.0.height": height} | settings
        key = json.dumps(settings, sort_keys=True)
        if key not in self.known:
            out = self.folder / "run"
            command = [self.program, "run", str(SCENE), "--quiet", "--force", "--output", str(out)]
            for name, value in settings.items():
                command += ["--set", f"{name}={value}"]
            start = time.monotonic()
            done = subprocess.run(command, capture_output=True, text=True)
            seconds = f"{time.monotonic() - start:.1f}"
            if done.returncode == 0:
                error = 1e3 * placement(out, float(height.split()[0]) / 1e3)
                self.known[key] = [f"{error:.6f}", seconds, ""]
            else:
                self.known[key] = ["", seconds, " ".join(done.stderr.split())[-300:]]
            with open(self.table, "a", newline="") as file:
                csv.writer(file).writerow([key] + self.known[key])
        error, seconds, reason = self.known[key]
        return (float(error) if error else None), float(seconds), reason

    def mean(self, settings, n_heights):
        found = [self.one(height, settings)[0] for height in HEIGHTS[:n_heights]]
        return None if None in found else sum(found) / len(found)

    def row(self, name, columns, n_heights):
        """One line of a table; columns: settings of each."""
        values = [self.mean(settings, n) for settings, n in zip(columns, n_heights)]
        text = [f"{v:.3f}" if v is not None else "refused" for v in values]
        orders = ["" for _ in values]
        for i in range(2, len(values)):
            if None in values[i - 2:i + 1]:
                continue
            ratio = (values[i - 2] - values[i - 1]) / ((values[i - 1] - values[i]) or np.nan)
            orders[i] = f" ({np.log2(ratio):.1f})" if ratio > 0 else " (-)"
        print(f"| {name} | " + " | ".join(t + o for t, o in zip(text, orders)) + " |", flush=True)


SCHEMES = {"backward Euler": {"time.scheme": "backward_euler"},
           "generalised alpha, rho 0.8": {"time.scheme": "generalised_alpha",
                                          "time.rho_infinity": "0.8"},
           "average acceleration": {"time.scheme": "average_acceleration"}}
TIPS = {"6 mm tip": {}, "point tip": {"needles.0.cutting.tip_length": "0 mm"}}
LAWS = {"consistent": {}, "lagged": {"needles.0.cutting.law": "lagged"},
        "increment": {"needles.0.cutting.law": "increment"}}
TRIANGLES = [1226 * 4**level for level in range(5)]


def header(first, columns):
    print(f"| {first} | " + " | ".join(columns) + " |\n|---|" + "---:|" * len(columns))


def mesh_rows(runs, name, settings, finest):
    """At one height as far as asked for, and the mean of three where that is cheap."""
    settings = settings | {"time.step": "20 ms"}  # moves E by 0.005 mm, see the table of steps
    for n_heights, last in ((1, finest), (3, min(finest, 2))):
        runs.row(f"{name}, {n_heights} height" + "s" * (n_heights > 1),
                 [settings | {"mesh.refine": level} for level in range(last + 1)],
                 [n_heights] * (last + 1))


def mesh_table(runs, finest):
    header("E, mm (order)", [f"{TRIANGLES[level]}" for level in range(finest + 1)])
    for tip, settings in TIPS.items():
        mesh_rows(runs, "plane stress, " + tip, settings, finest)


def strain_table(runs, finest):
    header("E, mm (order)", [f"{TRIANGLES[level]}" for level in range(finest + 1)])
    for nu, formulation in itertools.product(("0.3", "0.49", "0.4999"), ("p1", "p1_averaged")):
        settings = {"tissue.plane": "strain", "tissue.formulation": formulation} | {
            f"tissue.regions.{region}.poisson_ratio": nu for region in ("prostate", "surrounding")}
        runs.row(f"nu {nu}, {formulation}",
                 [settings | {"time.step": "20 ms", "mesh.refine": level}
                  for level in range(finest + 1)], [1] * (finest + 1))


def increment_of(step):
    """A quarter more than the needle travels in a step."""
    return {"needles.0.cutting.increment": f"{1.25 * SPEED * float(step.split()[0]):g} mm"}


def law_table(runs, finest):
    """Mesh refinement of what the tables of meshes leave out: 6 mm tip, steps of 10 ms."""
    header("E, mm (order)", [f"{TRIANGLES[level]}" for level in range(finest + 1)])
    for (scheme, a), (law, b) in itertools.product(SCHEMES.items(), LAWS.items()):
        settings = a | b | {"time.step": "10 ms"}
        if law == "increment":
            settings |= increment_of("10 ms")
        runs.row(f"{scheme}, {law}", [settings | {"mesh.refine": level}
                                      for level in range(finest + 1)], [1] * (finest + 1))


def step_table(runs, _):
    steps = ("40 ms", "20 ms", "10 ms", "5 ms", "2.5 ms", "1.25 ms")
    header("E, mm (order)", steps)
    for (scheme, a), (tip, b), (law, c) in itertools.product(SCHEMES.items(), TIPS.items(),
                                                             LAWS.items()):
        columns = [a | b | c | {"time.step": step} for step in steps]
        if law == "increment":
            columns = [column | increment_of(step) for column, step in zip(columns, steps)]
        runs.row(f"{scheme}, {tip}, {law}", columns, [1] * len(steps))


def damping_table(runs, _):
    """Average acceleration with less and less of what the reference scene damps and rubs."""
    steps = ("20 ms", "10 ms", "5 ms", "2.5 ms")
    header("E, mm (order)", steps)
    without = {"": {}, ", no friction": {"needles.0.friction": "null"},
               ", no damping": {"tissue.damping": "null"}}
    for (scheme, a), (name, b) in itertools.product(SCHEMES.items(), without.items()):
        runs.row(f"{scheme}, 6 mm tip{name}", [a | b | {"time.step": step} for step in steps],
                 [1] * len(steps))


def held(folder):
    """Time (ms) that the membrane held the tip, largest force of the tip meanwhile (N), largest change of
    the needle's force between rows of the first 0.2 s but for the first three (N)."""
    with open(folder / "history.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    column = lambda name: np.array([float(row[name]) for row in rows])
    time, tip, holds = column("time [s]"), column("force_tip [N]"), column("membrane_held") > 0
    early = tip[3:][time[3:] < 0.2]
    return (1e3 * np.diff(time, prepend=0)[holds].sum(), tip[holds].max(initial=0),
            np.abs(np.diff(early)).max(initial=0))


def onset_table(runs, _):
    """The reference scene itself, until it is implanted, in every scheme: what begins suddenly."""
    steps = ("5 ms", "2.5 ms", "1.25 ms", "0.3 ms")
    alpha = {f"generalised alpha, rho {rho}": {"time.scheme": "generalised_alpha",
                                               "time.rho_infinity": rho}
             for rho in ("0", "0.5", "0.8", "1")}
    mass = {"tissue.damping": "{mass_factor: 200 1/s}"}
    rows = {"backward Euler": SCHEMES["backward Euler"]} | alpha | {
        "average acceleration": SCHEMES["average acceleration"],
        "backward Euler, lumped, mass damping 200 1/s": mass | {"tissue.mass": "lumped"},
        "explicit, mass damping 200 1/s": mass | {"time.method": "explicit"}}
    header("placement error, mm; held, ms; tip's force then, N; its jumps before, N; peak force, N", steps)
    for name, settings in rows.items():
        cells = []
        for step in steps:
            out = runs.folder / "run"
            command = [runs.program, "run", str(SCENE), "--quiet", "--force", "--output", str(out)]
            for key, value in (settings | {"time.step": step, "expect": "null",
                                           "output.snapshots": "null",
                                           "time.until": "implanted"}).items():
                command += ["--set", f"{key}={value}"]
            if subprocess.run(command, capture_output=True, text=True).returncode != 0:
                cells.append("refused")
                continue
            summary = json.loads((out / "summary.json").read_text())
            time_held, force, jump = held(out)
            cells.append(f"{1e3 * summary['seeds'][0]['placement_error']:.3f}; {time_held:.1f}; "
                         f"{force:.2f}; {jump:.3f}; {summary['peak_needle_force']:.3f}")
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--program", default="build/stylet")
    parser.add_argument("--tables", default="mesh,law,step,damping,strain")
    parser.add_argument("--finest", type=int, default=2, help="finest level of refinement, 0 to 4")
    given = parser.parse_args()
    runs = Runs(given.program, given.folder)
    tables = {"mesh": mesh_table, "law": law_table, "step": step_table, "damping": damping_table,
              "strain": strain_table, "onset": onset_table}
    for name in given.tables.split(","):
        print(f"\n{name}\n")
        tables[name](runs, given.finest)


if __name__ == "__main__":
    main()
