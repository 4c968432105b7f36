#!/usr/bin/env python3
"""Time of a step against the number of triangles, with the needle moving.

The reference scene, its mesh refined 0 to --finest times; on each mesh the needle goes in by about
ten edges, in implicit and quasi-static steps of 1/8 edge and in explicit ones, so that every mesh
sees as many edits a step. Written: bench.csv and bench.png with the slope of each method.

  /usr/bin/python3 -B jobs/bench.py build/stylet out/bench --ranks 1 2 --finest 4
"""

import argparse
import csv
import json
import math
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
EDGE = 3e-3  # m, of the unrefined mesh
SPEED = 0.02  # m/s, of the needle
EXPLICIT = ["tissue.damping.stiffness_factor=null", "tissue.damping.mass_factor=200 1/s"]


def bandwidth():
    """GB/s of a = b + c on one core, best of five; 24 bytes an entry."""
    n = 1 << 24
    b, c, a = np.ones(n), np.ones(n), np.empty(n)
    best = math.inf
    for _ in range(5):
        start = time.perf_counter()
        np.add(b, c, out=a)
        best = min(best, time.perf_counter() - start)
    return 24 * n / best / 1e9


def run(stylet, folder, method, refine, ranks):
    edge = EDGE / 2**refine
    overrides = [
        f"mesh.refine={refine}",
        f"time.method={method}",
        f"time.step={edge / SPEED / 8} s",
        f"needles.0.motion=[insert: {{speed: {SPEED} m/s, depth: {10 * edge} m}}]",
        "expect=[]",
        "output={history: false}",
    ]
    if method == "explicit":
        overrides += EXPLICIT
    command = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    command += [stylet, "run", str(ROOT / "input/prostate.yaml"), "--output", str(folder), "--force",
                "--quiet"]
    for override in overrides:
        command += ["--set", override]
    outcome = subprocess.run(command, capture_output=True, text=True, check=False)
    if outcome.returncode != 0:
        sys.exit(f"bench.py: {' '.join(command)}\n{outcome.stderr}")
    summary = json.loads((folder / "summary.json").read_text())
    steps = summary["sub_steps"]
    return {"method": method, "ranks": ranks, "triangles": summary["n_triangles"], "steps": steps,
            "hand_overs": summary["hand_overs"],
            "step_ms": 1e3 * summary["wall_times"]["inserting"] / steps,
            "set_up_s": summary["wall_times"]["set_up"]}


def slope(rows):
    x = np.log([row["triangles"] for row in rows])
    y = np.log([row["step_ms"] for row in rows])
    return float(np.polyfit(x, y, 1)[0]) if len(rows) > 1 else math.nan


# Of an explicit step, read and written, a node (two triangles): gradients and corners of two
# triangles, three vectors of two numbers read, three written (which reads them too), two masses.
EXPLICIT_BYTES = 2 * 52 + 9 * 16 + 2 * 8


def draw(rows, speed, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(figsize=(6, 4.5), layout="constrained")
    for (method, ranks) in dict.fromkeys((row["method"], row["ranks"]) for row in rows):
        own = [row for row in rows if (row["method"], row["ranks"]) == (method, ranks)]
        axes.loglog([row["triangles"] for row in own], [row["step_ms"] for row in own],
                    "o-" if ranks == 1 else "s--",
                    label=f"{method}, {ranks} rank{'s' if ranks > 1 else ''}: slope {slope(own):.2f}")
    x = np.array(sorted({row["triangles"] for row in rows}))
    axes.loglog(x, 1e3 * EXPLICIT_BYTES * x / 2 / (1e9 * speed), "k:",
                label=f"memory's share of an explicit step, {speed:.0f} GB/s")
    axes.set_xlabel("triangles")
    axes.set_ylabel("time of a step with the needle moving (ms)")
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stylet")
    parser.add_argument("output", type=Path)
    parser.add_argument("--ranks", type=int, nargs="+", default=[1])
    parser.add_argument("--finest", type=int, default=3)
    parser.add_argument("--methods", nargs="+", default=["explicit", "implicit", "quasi_static"])
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    speed = bandwidth()
    print(f"memory bandwidth of one core: {speed:.1f} GB/s")
    rows = []
    print(f"{'method':13} {'ranks':>5} {'triangles':>9} {'steps':>6} {'step, ms':>9} {'set-up, s':>9}")
    for method in arguments.methods:
        for ranks in arguments.ranks:
            for refine in range(arguments.finest + 1):
                row = run(arguments.stylet, arguments.output / "run", method, refine, ranks)
                rows.append(row)
                print(f"{method:13} {ranks:5} {row['triangles']:9} {row['steps']:6} "
                      f"{row['step_ms']:9.4f} {row['set_up_s']:9.2f}", flush=True)
            own = [row for row in rows if row["method"] == method and row["ranks"] == ranks]
            print(f"{method}, ranks {ranks}: slope {slope(own):.2f}")
    with open(arguments.output / "bench.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    draw(rows, speed, arguments.output / "bench.png")
    print(f"files in {arguments.output}: bench.csv, bench.png")


if __name__ == "__main__":
    main()
