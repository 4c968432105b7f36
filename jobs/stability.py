#!/usr/bin/python3
"""Picture of a stability study: stable steps over the insertion, and energy of the implicit schemes."""

import argparse
import csv
import sys
from pathlib import Path

try:
    import matplotlib

    matplotlib.use("Agg")  # no display needed
    import matplotlib.pyplot as plt
except ImportError as error:
    sys.exit(f"stability.py needs python3-matplotlib: {error}")

from own_files import BadInput, OwnFiles

EXAMPLES = """examples:
  build/stylet stability input/prostate.yaml
  jobs/stability.py out/stability-prostate
"""

DARK = "#1d2730"
COLOURS = ("#2a6f97", "#ff5a36", "#6a994e")
SMALLEST = 1e-16  # energies below are round-off, and zero has no logarithm


def read(path):
    """Rows as dictionaries, without the units of the titles."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = [{name.split(" [")[0]: float(value) for name, value in row.items()}
                    for row in csv.DictReader(file)]
    except FileNotFoundError:
        raise BadInput(f"{path} is missing; is this the output folder of stylet stability?") from None
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise BadInput(f"{path}: cannot be read: {error}") from None
    if not rows:
        raise BadInput(f"{path}: holds no rows")
    return rows


def damping_text(row):
    if row["mass_factor"] > 0:
        return f"mass damping {row['mass_factor']:.3g} 1/s"
    if row["stiffness_factor"] > 0:
        return f"stiffness damping {row['stiffness_factor']:.3g} s"
    return "no damping"


def draw_limits(steps, ratios, rows):
    kinds = list(dict.fromkeys(damping_text(row) for row in rows))
    for kind, colour in zip(kinds, COLOURS):
        own = [row for row in rows if damping_text(row) == kind]
        depth = [1e3 * row["tip_depth"] for row in own]
        # Mass damping leaves the limit of the undamped tissue: dashes show both.
        line = "--" if "mass" in kind else "-"
        for name, marker in (("measured_step", "o"), ("predicted_step", "v")):
            label = kind if name == "measured_step" else None
            steps.plot(depth, [1e3 * row[name] for row in own], line, marker=marker, color=colour,
                       markersize=5, label=label)
        for name, marker in (("spectral_over_measured", "o"), ("predicted_over_measured", "v")):
            ratios.plot(depth, [row[name] for row in own], line, marker=marker, color=colour,
                        markersize=5)
    for marker, label in (("o", "measured"), ("v", "predicted")):
        steps.plot([], [], marker, color=DARK, label=label)
    for marker, label in (("o", "SLEPc / measured"), ("v", "predicted / measured")):
        ratios.plot([], [], marker, color=DARK, label=label)
    quality = [row for row in rows if damping_text(row) == kinds[0]]
    ratios.plot([1e3 * row["tip_depth"] for row in quality],
                [row["worst_quality"] for row in quality], ":", color="grey", label="worst quality")
    steps.set_ylabel("largest stable explicit step (ms)")
    ratios.set_ylabel("ratio")
    for axes in (steps, ratios):
        axes.set_xlabel("depth of the tip (mm)")
        axes.set_ylim(bottom=0)


def draw_growth(axes, rows):
    rows = sorted(rows, key=lambda row: row["step_over_limit"])
    step = [row["step_over_limit"] for row in rows]
    schemes = [name.removesuffix("_last") for name in rows[0] if name.endswith("_last")]
    for scheme, colour, width in zip(schemes, COLOURS, (4, 2, 1.5)):  # lines that coincide
        for kind, line in (("largest", "-"), ("last", "--")):
            axes.loglog(step, [max(SMALLEST, row[f"{scheme}_{kind}"]) for row in rows], line,
                        marker="o", markersize=4, color=colour, linewidth=width,
                        label=scheme.replace("_", " ") if kind == "largest" else None)
    axes.axvline(1, color="grey", linewidth=0.8)
    axes.plot([], [], "-", color=DARK, label="largest")
    axes.plot([], [], "--", color=DARK, label="at the end")
    axes.set_xlabel("implicit step / explicit limit")
    axes.set_ylabel("energy / energy at the start")


def main():
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLES,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("outdir", type=Path,
                        help="output folder of stylet stability; the picture is OUTDIR/stability.png")
    parser.add_argument("--dpi", type=int, default=110, help="resolution (default 110)")
    options = parser.parse_args()
    if options.dpi < 1:
        parser.error("--dpi must be at least 1")
    target = options.outdir / "stability.png"
    try:
        limits = read(options.outdir / "stability.csv")
        growth = read(options.outdir / "stability_implicit.csv")
        figure, axes = plt.subplots(1, 3, figsize=(15, 4.6), layout="constrained")
        draw_limits(axes[0], axes[1], limits)
        draw_growth(axes[2], growth)
        for one in axes:
            one.set_facecolor("#f4f5f6")
            one.grid(color="white")
            one.set_axisbelow(True)
            one.legend(fontsize=8)
        own = OwnFiles(options.outdir)
        own.claim([target.name])
        figure.savefig(target, dpi=options.dpi)
        own.seal([target.name])
    except BadInput as error:
        print(f"stability.py: {error}", file=sys.stderr)
        return 2
    except KeyError as error:
        print(f"stability.py: {options.outdir}: column {error} is missing", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"stability.py: {error}", file=sys.stderr)
        return 4
    print(f"picture: {target}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
