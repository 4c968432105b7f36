#!/usr/bin/env python3
"""Instructions of a step by its parts, counted by valgrind's callgrind.

The reference scene, its mesh refined 0 to --finest times, with the needle moving by six edges in
steps of 1/8 edge, as in bench.py. A part contains what it calls. Printed: thousands of instructions
a step; written: profile.csv and callgrind's files, for kcachegrind.

  /usr/bin/python3 -B jobs/profile.py build/stylet out/profile
"""

import argparse
import csv
import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
EDGE = 3e-3  # m, of the unrefined mesh
SPEED = 0.02  # m/s, of the needle
PARTS = {
    "explicit": {
        "stylet::step": "K u and the fields, one pass",
        "stylet::ExplicitNewmark::energy": "energies, every 1/8 edge",
        "stylet::ExplicitNewmark::apply": "contacts and supports",
        "stylet::Body::apply": "edits: mesh, rows of K, stable step",
        "stylet::Needle::plan": "needle: plan of edits",
        "stylet::Needle::constraints": "needle: constraints",
        "stylet::Needle::review": "needle: contact laws",
        "stylet::take_step": "step",
    },
    "implicit": {
        "stylet::NearField::factor": "factor, once",
        "stylet::ImplicitNewmark::predict": "predictors, K u",
        "stylet::Cholesky::load": "forward solve",
        "stylet::Cholesky::respond": "backward solve",
        "stylet::EnergyLedger::measure": "energies",
        "stylet::ImplicitNewmark::attempt": "trials, condensed",
        "stylet::Body::apply": "edits: mesh, K, M",
        "stylet::take_step": "step",
    },
}


def counts(stylet, folder, method, refine):
    """Thousands of instructions a step, by function, and the number of triangles."""
    edge = EDGE / 2**refine
    overrides = [
        f"mesh.refine={refine}",
        f"time.method={method}",
        f"time.step={edge / SPEED / 8} s",
        f"needles.0.motion=[insert: {{speed: {SPEED} m/s, depth: {6 * edge} m}}]",
        "needles.0.cutting.cutting_force=0.4 N",
        "expect=[]",
        "output={history: false}",
    ]
    if method == "explicit":
        overrides += ["tissue.damping.stiffness_factor=null", "tissue.damping.mass_factor=200 1/s"]
    record = folder / f"callgrind.{method}.{refine}"
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={record}", stylet, "run",
               str(ROOT / "input/prostate.yaml"), "--output", str(folder / "run"), "--force",
               "--quiet"]
    for override in overrides:
        command += ["--set", override]
    outcome = subprocess.run(command, capture_output=True, text=True, check=False)
    if outcome.returncode != 0:
        sys.exit(f"profile.py: {' '.join(command)}\n{outcome.stderr}")
    summary = json.loads((folder / "run/summary.json").read_text())
    listing = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=99.9", record],
                             capture_output=True, text=True, check=True).stdout
    found = {}
    for line in listing.splitlines():
        match = re.match(r"\s*([\d,]+) .*?:(stylet::[\w:]+)\(", line)
        if match:
            thousands = int(match[1].replace(",", "")) / 1e3 / summary["sub_steps"]
            found[match[2]] = max(found.get(match[2], 0), thousands)
    return found, summary["n_triangles"]


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stylet")
    parser.add_argument("output", type=Path)
    parser.add_argument("--finest", type=int, default=2)
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    rows = []
    for method, parts in PARTS.items():
        columns = [counts(arguments.stylet, arguments.output, method, refine)
                   for refine in range(arguments.finest + 1)]
        print(f"{method + ', triangles:':32}" + "".join(f"{n:>9}" for _, n in columns))
        for function, part in parts.items():
            # What is not listed is below a thousandth of the run.
            values = [found.get(function, 0) for found, _ in columns]
            print(f"{part:32}" + "".join(f"{value:9.0f}" for value in values), flush=True)
            rows += [[method, n, part, function, f"{value:.1f}"]
                     for value, (_, n) in zip(values, columns)]
    with open(arguments.output / "profile.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["method", "triangles", "part", "function", "thousand instructions a step"])
        writer.writerows(rows)
    print(f"files in {arguments.output}: profile.csv, callgrind.METHOD.REFINE")


if __name__ == "__main__":
    main()
