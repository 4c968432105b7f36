"""What the pictures of studies share."""

import argparse
import json
import sys
from pathlib import Path

try:
    import matplotlib

    matplotlib.use("Agg")  # no display needed
    import matplotlib.pyplot as plt
    import numpy as np
except ImportError as error:
    sys.exit(f"{sys.argv[0]} needs python3-numpy and python3-matplotlib: {error}")

from own_files import BadInput, OwnFiles

DARK = "#1d2730"
COLOURS = ("#2a6f97", "#ff5a36", "#6a994e", "#7b4f9d", "#c28f00", "#3d3d3d")
SHOWN_IN = {"placement_error": (1e3, "mm"), "tip_displacement": (1e3, "mm"),
            "peak_needle_force": (1, "N")}


class Quantity:
    """A path in summary.json and the unit in which it is shown."""

    def __init__(self, path):
        self.path = path
        last = path.split(".")[-1]
        self.factor, self.unit = SHOWN_IN.get(last, (1, ""))
        self.label = last.replace("_", " ") + (f" ({self.unit})" if self.unit else "")


def style(axes):
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)


def read_json(path, verb):
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise BadInput(f"{path} is missing; is this the output folder of {verb}?") from None
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: cannot be read: {error}") from None


def run(draw, names, description, examples):
    """Parses the command line of such a script and calls draw(folder, quiet), which writes `names`."""
    parser = argparse.ArgumentParser(description=description, epilog=examples,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="output folder of the study")
    parser.add_argument("--quiet", action="store_true", help="print errors only")
    arguments = parser.parse_args()
    try:
        own = OwnFiles(arguments.folder)
        own.claim(names)
        draw(arguments.folder, arguments.quiet)
        own.seal(names)
    except BadInput as error:
        print(f"{sys.argv[0].split('/')[-1]}: {error}", file=sys.stderr)
        sys.exit(2)
