#!/usr/bin/python3
"""Compares the campaigns of the paper's figures with what the paper says: comparison.md.

usage: figures.py FOLDER   (the folder of jobs/figures.sh)
"""

import csv
import json
import sys
from pathlib import Path


def curve(folder, name, **at):
    """x and y of one curve of a campaign, in increasing x."""
    statistics = json.loads((folder / name / "statistics.json").read_text(encoding="utf-8"))
    for entry in statistics["curves"]:
        if all(entry["at"].get(k) == v for k, v in at.items()):
            return zip(*sorted(zip(entry["x"], entry["y"])))
    raise KeyError(f"{name} has no curve at {at}")


def seconds(folder, name):
    with open(folder / name / "results.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return len({row["run"] for row in rows}), sum(float(row["wall_time [s]"]) for row in rows)


def falls(y):
    return all(b < a for a, b in zip(y, y[1:]))


def rises(y):
    return falls(y[::-1])


def ends(x, y, unit=""):
    return f"{y[0]:.2f} mm at {x[0]:g}{unit} to {y[-1]:.2f} mm at {x[-1]:g}{unit}"


def figure07(folder):
    x, y = curve(folder, "figure07")
    lowest = min(range(len(y)), key=lambda i: y[i])
    vee = falls(y[:lowest + 1]) and rises(y[lowest:])
    return ("almost zero 6.5 mm beyond the target",
            f"{y[lowest]:.2f} mm at {10 * (3.5 - x[lowest]):.1f} mm beyond, "
            f"{y[x.index(3.5)]:.2f} mm at the target, {y[0]:.1f} mm at {10 * (3.5 - x[0]):.0f} mm",
            vee and y[lowest] < 0.5)


def figure08(folder):
    x, y = curve(folder, "figure08")
    middle = x.index(0)
    return ("grows off the target's height", f"{y[0]:.2f}, {y[middle]:.2f}, {y[-1]:.2f} mm at "
            f"{x[0]:g}, 0, {x[-1]:g} mm", falls(y[:middle + 1]) and rises(y[middle:]))


def figure09(folder):
    x, y = curve(folder, "figure09")
    return "a sharper needle errs less", ends(x, y, " N"), rises(y)


def figure10(folder):
    x, y = curve(folder, "figure10")
    return "less friction, less error", ends(x, y, " times"), rises(y)


def figure11(folder):
    x, y = curve(folder, "figure11", damping="0.05")
    return "a faster needle errs less", ends(x, y, " times 2 cm/s") + " (reference scene)", falls(y)


def figure11_undamped(folder):
    x, y = curve(folder, "figure11", damping="0")
    return ("the same, from damping: without any", ends(x, y, " times 2 cm/s"),
            max(y) - min(y) < 0.3)


def figure11_friction(folder):
    x, y = curve(folder, "figure11_friction")
    return ("the same, from static friction", ends(x, y, " times 2 cm/s"), falls(y))


def figure12(folder):
    x, y = curve(folder, "figure12", stiffness_share="0")
    return ("stiffer tissue, moderately less error", ends(x, y, " times 60 kPa") +
            ", cutting force constant", falls(y))


def figure12_share(folder):
    x, y = curve(folder, "figure12", stiffness_share="1")
    return ("the same, moderate", ends(x, y, " times 60 kPa") + ", cutting force grows with it",
            falls(y))


def poisson(folder):
    x, y = curve(folder, "poisson", plane="stress")
    return ("constant in Poisson's ratio, 0.4 to 0.499", ends([0.4, 0.499], [y[0], y[-1]]) +
            ", plane stress", max(y) - min(y) < 0.3)


def poisson_strain(folder):
    x, y = curve(folder, "poisson", plane="strain")
    return ("the same", ends([0.4, 0.499], [y[0], y[-1]]) + ", plane strain", max(y) - min(y) < 0.3)


ROWS = [("7", figure07), ("8", figure08), ("9", figure09), ("10", figure10), ("11", figure11),
        ("11", figure11_undamped), ("11", figure11_friction), ("12", figure12),
        ("12", figure12_share), ("section VII", poisson), ("section VII", poisson_strain)]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = Path(sys.argv[1])
    lines = ["| paper's figure | the paper says | here | holds |", "|---|---|---|---|"]
    for figure, row in ROWS:
        try:
            says, here, holds = row(folder)
        except (FileNotFoundError, KeyError) as error:
            print(f"figures.py: left out: {error}", file=sys.stderr)
            continue
        lines.append(f"| {figure} | {says} | {here} | {'yes' if holds else 'no'} |")
    names = [d.name for d in sorted(folder.iterdir()) if (d / "results.csv").exists()]
    lines += ["", "| campaign | runs | core seconds |", "|---|---|---|"]
    lines += [f"| {name} | {n} | {s:.1f} |" for name in names for n, s in [seconds(folder, name)]]
    text = "\n".join(lines) + "\n"
    (folder / "comparison.md").write_text(text, encoding="utf-8")
    print(text + f"in {folder}: comparison.md and a picture a campaign")


if __name__ == "__main__":
    main()
