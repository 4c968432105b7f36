#!/usr/bin/python3
"""How fast the window is: pictures and simulated time against the clock, by method and mesh.

usage: window_speed.py [--seconds 8] [--most-levels 4] [--methods explicit quasi_static implicit]

Opens the window of input/prostate.yaml under Xvfb and lets a recorded hand push and pull the needle.
Meshes are refined until one does not keep up; xvfb-run is needed (bash jobs/install.sh --tests).
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
PROGRAM = os.environ.get("STYLET", str(ROOT / "build/stylet"))
HAND = "0 s: insert 2 cm/s\n2.75 s: hold\n2.75 s: seed\n3 s: retract 2 cm/s\n6 s: hold\n"
FIGURES = re.compile(r"([\d.]+) frames a second, real-time factor ([\d.]+), steps take ([\d.]+) %.*"
                     r"longest step ([\d.]+) ms, hand to picture ([\d.]+) ms")


def measure(method, level, seconds, folder):
    changes = [f"mesh.refine={level}", f"time.method={method}"]
    if method == "explicit":
        changes += ["tissue.damping.stiffness_factor=null", "tissue.damping.mass_factor=200 1/s"]
    options = [word for change in changes for word in ("--set", change)]
    record = folder / f"{method}-{level}"
    script = folder / "hand.txt"
    script.write_text(HAND)
    subprocess.run([PROGRAM, "view", str(ROOT / "input/prostate.yaml"), *options, "--script", str(script),
                    "--frames", str(folder), "--record", str(record)], check=True, capture_output=True)
    done = subprocess.run(["xvfb-run", "-a", "-s", "-screen 0 1366x768x24", PROGRAM, "view",
                           f"{record}-1/scene.yaml", "--no-record", "--seconds", str(seconds)],
                          check=True, capture_output=True, text=True)
    return [float(figure) for figure in FIGURES.search(done.stdout).groups()]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=8)
    parser.add_argument("--most-levels", type=int, default=4)
    parser.add_argument("--methods", nargs="+", default=["explicit", "quasi_static", "implicit"])
    asked = parser.parse_args()
    print("| method | triangles | frames a second | real time | time of steps, % | longest step, ms |\n|---|---:|---:|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        for method in asked.methods:
            for level in range(asked.most_levels + 1):
                frames, factor, busy, longest, _ = measure(method, level, asked.seconds, pathlib.Path(folder))
                print(f"| {method} | {1226 * 4 ** level} | {frames:.0f} | {factor:.2f} | {busy:.0f} | {longest:.0f} |")
                sys.stdout.flush()
                if factor < 0.5:
                    break


if __name__ == "__main__":
    main()
