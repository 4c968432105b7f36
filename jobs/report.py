#!/usr/bin/python3
"""One HTML page of a run: pictures, forces and energies over time, numbers with their bands, notes,
and where the run came from. Everything is inside the page: it can be sent and kept as one file."""

import argparse
import base64
import html
import io
import json
import sys
from pathlib import Path

from own_files import BadInput, OwnFiles

try:
    import matplotlib

    matplotlib.use("Agg")  # no display needed
    import matplotlib.pyplot as plt
    import numpy as np
except ImportError as error:
    sys.exit(f"report.py needs python3-numpy and python3-matplotlib: {error}")

import frames
from snapshots import open_run
from study_picture import COLOURS, DARK, read_json, style

EXAMPLES = """examples:
  jobs/report.py out/prostate
  jobs/report.py out/prostate --field von_mises
"""

NAME = "report.html"
MOST_POINTS = 2000  # of a curve; more are not seen

# What a page says first, if the summary has it: path, words, factor, unit.
NUMBERS = (
    ("peak_needle_force", "peak needle force", 1, "N"),
    ("widespread_strain.value", "strain exceeded on a thousandth of the tissue", 100, "%"),
    ("largest_strain.value", "largest strain anywhere", 100, "%"),
    ("worst_quality", "worst quality of a triangle (1 is equilateral)", 1, ""),
    ("punctures", "punctures of the membrane", 1, ""),
    ("hand_overs", "hand-overs of the tip to the next node", 1, ""),
    ("fallbacks", "advances along the needle because the mesh gave no direction", 1, ""),
    ("deformed_inversions", "most triangles turned over at a time (beyond small strain)", 1, ""),
    ("time", "end of the run", 1, "s"),
    ("steps", "steps", 1, ""),
    ("stable_step", "smallest stable step", 1e3, "ms"),
)
ENERGIES = (("external", "work of the hand, loads and moved curves"),
            ("dissipated", "dissipated by cutting, friction and damping"),
            ("kinetic", "kinetic"), ("strain", "strain"),
            ("edits", "added where nodes of the mesh moved"),
            ("balance_error", "lost or made by the time scheme"))
# Panels of history.csv: title, unit, columns with their words.
PANELS = (
    ("Force of the needle on the tissue (N)", (("force_needle", "needle"), ("force_tip", "tip"),
                                               ("force_friction", "friction"))),
    ("Energy (J)", (("external_energy", "work"), ("dissipated_energy", "dissipated"),
                    ("strain_energy", "strain"), ("kinetic_energy", "kinetic"),
                    ("balance_error", "balance error"))),
    ("Shaft nodes", (("n_stuck", "stuck"), ("n_sliding", "sliding"))),
    ("Worst quality of a triangle so far", (("worst_quality", ""),)),
)

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #1d2730; background: #fff; max-width: 62rem;
       margin: 2rem auto; padding: 0 1rem; }
h1 { margin-bottom: 0.2rem; } h2 { margin-top: 2.2rem; }
table { border-collapse: collapse; } td, th { text-align: left; padding: 0.25rem 1.2rem 0.25rem 0;
       border-bottom: 1px solid #e3e7ea; vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
img { max-width: 100%; } code, pre { font-size: 0.85rem; overflow-wrap: anywhere; }
pre { background: #f4f5f6; padding: 0.8rem; overflow-x: auto; white-space: pre; }
.state { padding: 0.6rem 0.9rem; border-left: 0.4rem solid #6a994e; background: #f4f5f6; }
.bad { border-color: #d1495b; } .note { border-color: #c28f00; }
"""


def at(tree, path):
    """A number of summary.json by its path, or none."""
    for part in path.split("."):
        if isinstance(tree, list) and part.isdigit() and int(part) < len(tree):
            tree = tree[int(part)]
        elif isinstance(tree, dict) and part in tree:
            tree = tree[part]
        else:
            return None
    return tree


def escape(value):
    return html.escape(str(value))


def shown(value):
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def with_band(summary, path, value, factor, unit):
    """As `stylet run` prints it: as many digits as the band has."""
    band = summary.get("uncertainty", {}).get(path)
    unit = f" {unit}" if unit else ""
    if not isinstance(value, (int, float)):
        return escape(value)
    if not band or not band["total"] > 0:
        return escape(shown(value * factor if factor != 1 else value) + unit)
    digits = max(0, 1 - int(np.floor(np.log10(factor * band["total"]))))
    parts = ", ".join(f"{part} {factor * band[part]:.{digits}f}"
                      for part in ("mesh", "step", "kernel") if part in band)
    return escape(f"{factor * value:.{digits}f} ± {factor * band['total']:.{digits}f}{unit} ({parts})")


def rows(pairs):
    """Lines of a table: words, and a number that is escaped already."""
    lines = [f'<tr><td>{escape(words)}</td><td class="number">{number}</td></tr>'
             for words, number in pairs]
    return "<table>\n" + "\n".join(lines) + "\n</table>" if lines else "<p>None.</p>"


def picture(figure, words):
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=100)
    plt.close(figure)
    return png(data.getvalue(), words)


def png(data, words):
    text = base64.b64encode(data).decode("ascii")
    return f'<img alt="{escape(words)}" src="data:image/png;base64,{text}">'


def history(path):
    """Columns by name, without units; lines that a killed run left short are dropped."""
    if not path.is_file():
        return {}
    with open(path, encoding="utf-8") as file:
        names = [name.split(" [")[0] for name in file.readline().rstrip("\n").split(",")]
        lines = [line.split(",") for line in file if line.endswith("\n")]
    try:
        table = np.array([line for line in lines if len(line) == len(names)], dtype=float)
    except ValueError as error:
        raise BadInput(f"{path}: cannot be read: {error}") from None
    return dict(zip(names, table.T)) if len(table) else {}


def thinned(time, values):
    """At most MOST_POINTS points, among them the extremes of each piece."""
    if len(time) <= MOST_POINTS:
        return time, values
    pieces = np.array_split(np.arange(len(time)), MOST_POINTS // 2)
    keep = sorted({i for p in pieces for i in (p[np.argmin(values[p])], p[np.argmax(values[p])])})
    return time[keep], values[keep]


def curves(table):
    panels = [(title, [c for c in columns if c[0] in table]) for title, columns in PANELS]
    others = sorted(name for name in table if name.endswith(("_ux", "_uy", "_fx", "_fy")))
    for ending, title in (("u", "Displacement of probes (m)"), ("f", "Force on curves (N)")):
        own = [(name, name) for name in others if name[-2] == ending]
        panels.append((title, own))
    panels = [(title, columns) for title, columns in panels if columns]
    if not panels or len(table["time"]) < 2:
        return ""
    height = (len(panels) + 1) // 2
    figure, grid = plt.subplots(height, 2, figsize=(10, 2.9 * height), sharex=True, squeeze=False,
                                layout="constrained")
    for axes, (title, columns) in zip(grid.flat, panels):
        for (name, words), colour in zip(columns, COLOURS):
            axes.plot(*thinned(table["time"], table[name]), color=colour, linewidth=1.3,
                      label=words or None)
        axes.set_title(title, fontsize=10, color=DARK)
        style(axes)
        if len(columns) > 1:
            axes.legend(fontsize=8)
    for axes in grid.flat[len(panels):]:
        axes.set_visible(False)
    for axes in grid[-1]:
        axes.set_xlabel("time (s)")
    return picture(figure, "forces, energies and contacts over time")


def moments(folder, field):
    if not (folder / "snapshots.h5").is_file():
        return "<p>The scene asks for no snapshots (<code>output.snapshots</code>).</p>"
    try:
        run = open_run(folder, field)
    except BadInput as error:
        if "holds no snapshot yet" not in str(error):
            raise
        return "<p>The run has left no snapshot.</p>"
    data = io.BytesIO()
    frames.write_panel(run, run.limits(), data, 90)
    return png(data.getvalue(), "six moments of the run: deformed mesh, needle, seeds, targets")


def state(summary):
    status = summary.get("status", "unknown")
    words = {"completed": "The run was completed.", "running": "The run is not over, or was killed."}
    text = escape(words.get(status, f"The run {status}."))
    if "error" in summary:
        text += " " + escape(summary["error"])
    blocks = [f'<p class="state{"" if status == "completed" else " bad"}">{text}</p>']
    for expected in summary.get("expectations", []):
        limits = " and ".join(f"{word} {shown(expected[key])}" for key, word in
                              (("min", "at least"), ("max", "at most")) if expected.get(key) is not None)
        met = expected.get("met")
        blocks.append(f'<p class="state{"" if met else " bad"}">Expected: '
                      f'{escape(expected["quantity"])} {escape(limits)} (SI); it is '
                      f'{escape(shown(expected.get("value")))}: {"met" if met else "not met"}.</p>')
    blocks += [f'<p class="state note">Note: {escape(note)}.</p>' for note in summary.get("notes", [])]
    return "\n".join(blocks)


def distrust(seed):
    """As the program says it behind the number."""
    over = seed.get("turned_over", 0)
    return f" <b>not to be trusted</b>: beyond small strain, triangles turned over: {over}" if over else ""


def seed_rows(summary):
    for i, seed in enumerate(summary.get("seeds", [])):
        name = f"'{seed['target']}'" if "target" in seed else f"{i}"
        if "placement_error" in seed:
            path = f"seeds.{i}.placement_error"
            yield (f"placement error of the seed for {name}",
                   with_band(summary, path, seed["placement_error"], 1e3, "mm") + distrust(seed))
        if "world" in seed:  # not beside a needle in space that is still in
            yield (f"seed {name} (needle {seed['needle']}, left at {shown(seed['implanted_at'])} s) lies at",
                   escape(", ".join(f"{1e3 * x:.3f}" for x in seed["world"]) + " mm"))
        yield (f"seed {name}: the tissue there had moved by",
               escape(f"{1e3 * seed['tip_displacement']:.3f} mm"))


def number_rows(summary):
    yield from seed_rows(summary)
    for path, words, factor, unit in NUMBERS:
        value = at(summary, path)
        if value is not None:
            yield words, with_band(summary, path, value, factor, unit)
    for kind, words, unit, factor in (("probes", "displacement of probe", "mm", 1e3),
                                      ("reactions", "force on curve", "N", 1)):
        for name, pair in summary.get(kind, {}).items():
            yield (f"{words} '{name}'",
                   escape(", ".join(f"{factor * x:.6g}" for x in pair) + f" {unit}"))


def bands(summary):
    if summary.get("uncertainty"):
        return ("<p>The bands behind ± are the numerical error of mesh and step, from the convergence "
                "study stored with the scene. The error of the model is not in them.</p>")
    return ("<p>No study of this scene is stored, so the numerical error of these numbers is not known: "
            "<code>stylet converge SCENE --store</code>.</p>")


def provenance(summary):
    pairs = [(name, f"{version}") for name, version in summary.get("versions", {}).items()]
    pairs += [(f"fingerprint of the {name}", f"<code>{escape(print_)}</code>")
              for name, print_ in summary.get("fingerprints", {}).items()]
    options = " ".join(summary.get("solver_options", [])) or "none"
    pairs.append(("solver options", f"<code>{escape(options)}</code>"))
    for key, words in (("n_triangles", "triangles"), ("n_tetrahedra", "tetrahedra"), ("n_nodes", "nodes"), ("n_ranks", "ranks")):
        if key in summary:
            pairs.append((words, escape(summary[key])))
    walls = summary.get("wall_times", {})
    if walls:
        parts = ", ".join(f"{name.replace('_', ' ')} {seconds:.2f}" for name, seconds in walls.items())
        pairs.append(("wall time, s", escape(f"{sum(walls.values()):.2f} ({parts})")))
    return rows(pairs)


def details(folder, name):
    if not (folder / name).is_file():
        return ""
    text = (folder / name).read_text(encoding="utf-8")
    return f"<details><summary>{name}</summary>\n<pre>{escape(text)}</pre></details>"


def page(folder, field):
    summary = read_json(folder / "summary.json", "stylet run")
    if "status" not in summary or "energy" not in summary and "error" not in summary:
        raise BadInput(f"{folder / 'summary.json'}: is not of stylet run")
    title = escape(f"{summary.get('scene', folder.name)}")
    energy = summary.get("energy", {})
    energies = [(words, escape(f"{1e3 * energy[key]:.5g} mJ")) for key, words in ENERGIES if key in energy]
    return f"""<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>{title}</title>
<style>{STYLE}</style></head>
<body>
<h1>{title}</h1>
{state(summary)}
<h2>What happened</h2>
{moments(folder, field)}
{curves(history(folder / "history.csv"))}
<h2>Numbers</h2>
{bands(summary)}
{rows(number_rows(summary))}
<h2>Energy</h2>
{rows(energies)}
<h2>Where it comes from</h2>
{provenance(summary)}
{details(folder, "scene.yaml")}
{details(folder, "summary.json")}
</body>
</html>
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLES,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("outdir", type=Path, help=f"output folder of a run; the page is OUTDIR/{NAME}")
    parser.add_argument("--field", default="displacement",
                        help="of the pictures: displacement (default), von_mises or another stored field")
    options = parser.parse_args()
    target = options.outdir / NAME
    try:
        text = page(options.outdir, options.field)
        own = OwnFiles(options.outdir)
        own.claim([NAME])
        target.write_text(text, encoding="utf-8")
        own.seal([NAME])
    except BadInput as error:
        print(f"report.py: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"report.py: {error}", file=sys.stderr)
        return 4
    print(f"page: {target}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
