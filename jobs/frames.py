#!/usr/bin/python3
"""Pictures of a run: one PNG a snapshot, an animation, and a panel of six moments. Of a run in space they
show a slice, through the needle if there is one, and beside it the capsule in perspective."""

import argparse
import sys
from pathlib import Path

try:
    import matplotlib

    matplotlib.use("Agg")  # no display needed
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.collections import LineCollection
    from matplotlib.patheffects import withStroke
    from matplotlib.ticker import MaxNLocator
    from matplotlib.tri import Triangulation
    from PIL import Image

    import space_view
    from snapshots import error_words, open_run, text
except ImportError as error:
    sys.exit(f"frames.py needs python3-h5py, python3-matplotlib and python3-pil: {error}")

from own_files import BadInput, OwnFiles

EXAMPLES = """examples:
  jobs/frames.py out/prostate
  jobs/frames.py out/prostate --field von_mises --every 5 --dpi 150
  jobs/frames.py out/prostate --no-gif
  jobs/frames.py out/prostate --field image
  jobs/frames.py out/prostate3d --through 3.5 3 3 --normal x --field von_mises
"""

DARK = "#1d2730"
SEED = "#ff5a36"
MAX_TRIANGLES_WITH_EDGES = 20000  # more edges would hide the colours


def colour_map(colours):
    return "RdBu_r" if colours[0] < 0 else "viridis"


def draw(axes, run, step, view, *, scale=1.0, final=False):
    """One moment. `scale` thins lines and markers in small panels."""
    lower, upper = view[1:]
    if run.texture is None:
        draw_field(axes, run, step, view[0], scale)
    else:
        draw_image(axes, run, step, lower, upper)

    membrane = run.shape(step, "polylines", "membrane")
    if len(membrane):
        closed = np.vstack([membrane, membrane[:1]])
        axes.plot(*closed.T, color="white", linewidth=1.8 * scale,
                  path_effects=[withStroke(linewidth=3.2 * scale, foreground=DARK)])
    if run.in_space:
        axes.add_collection(LineCollection(run.outlines(step), colors="white", linewidths=1.6 * scale, path_effects=[
            withStroke(linewidth=3 * scale, foreground=DARK)]))
    needle = run.shape(step, "polylines", "needle")
    if len(needle):
        axes.plot(*needle.T, color="#dfe5ea", linewidth=2.6 * scale, solid_capstyle="butt",
                  path_effects=[withStroke(linewidth=4.4 * scale, foreground=DARK)], zorder=4)
    targets = run.shape(step, "point_sets", "targets")
    axes.plot(*targets.T, "+", color="white", markersize=11 * scale,
              markeredgewidth=2.2 * scale, zorder=5,
              path_effects=[withStroke(linewidth=4.2 * scale, foreground=DARK)])
    seeds = run.shape(step, "point_sets", "seeds")
    axes.plot(*seeds.T, "s", color=SEED, markersize=6 * scale, markeredgecolor="white",
              markeredgewidth=0.9 * scale, zorder=6)
    if final:
        draw_errors(axes, run, scale)

    axes.set_xlim(lower[0], upper[0])
    axes.set_ylim(lower[1], upper[1])
    axes.set_aspect("equal")
    axes.set_facecolor("#f4f5f6" if run.texture is None else "black")
    for locate in (axes.xaxis, axes.yaxis):
        locate.set_major_locator(MaxNLocator(nbins=5, integer=True))
    axes.tick_params(labelsize=9 * scale + 1, length=3)
    phase = text(step.attrs["phase"])
    axes.set_title(f"{step.attrs['time']:.2f} s" + (f"   {phase}" if phase else ""),
                   fontsize=11 * scale + 1, color=DARK)


def draw_image(axes, run, step, lower, upper):
    """The picture as the tissue deforms it, with less echo behind the needle: the probe is below."""
    canvas = run.deformed_image(step, lower, upper)
    axes.imshow(canvas, origin="lower", extent=(lower[0], upper[0], lower[1], upper[1]),
                interpolation="bilinear")
    needle = run.shape(step, "polylines", "needle")
    if len(needle):
        start, end = needle
        behind = np.array([start, end, [end[0], upper[1]], [start[0], upper[1]]])
        axes.fill(*behind.T, color="black", alpha=run.place["shadow"], linewidth=0, zorder=2)


def draw_field(axes, run, step, colours, scale):
    points, triangles, values = run.points(step), run.triangles(step), run.values(step)
    mesh = Triangulation(points[:, 0], points[:, 1], triangles)
    look = {"cmap": colour_map(colours), "vmin": colours[0], "vmax": colours[1]}
    if len(values) == len(points):
        axes.tripcolor(mesh, values, shading="gouraud", **look)
    else:
        axes.tripcolor(mesh, facecolors=values, **look)
    if len(triangles) <= MAX_TRIANGLES_WITH_EDGES:
        colour = DARK if colours[0] < 0 else "white"  # the middle of a signed field is white
        look = {"linewidth": 0.35 * scale, "alpha": 0.3}
        if run.in_space:  # quadrangles too
            axes.add_collection(LineCollection(run.edges(step), colors=colour, **look))
        else:
            axes.triplot(mesh, color=colour, **look)


def draw_errors(axes, run, scale):
    """From each target to its seed, with the distance that summary.json gives."""
    for seed, target, place in run.errors():
        axes.plot(*np.array([target, place]).T, color=SEED, linewidth=2 * scale, zorder=5.5,
                  path_effects=[withStroke(linewidth=3.4 * scale, foreground="white")])
        axes.annotate(error_words(seed), (target + place) / 2,
                      xytext=(0, 13 * scale), textcoords="offset points", ha="center",
                      fontsize=10 * scale + 1, color=DARK, zorder=7,
                      bbox={"boxstyle": "round,pad=0.25", "facecolor": "white",
                            "edgecolor": "none", "alpha": 0.9})


def add_colourbar(figure, axes, run, view, **place):
    if run.texture is not None:
        return
    low, high = view[0]
    scale = plt.cm.ScalarMappable(plt.Normalize(low, high), colour_map(view[0]))
    # Values outside the range of the colours exist by choice (see Run.limits).
    bar = figure.colorbar(scale, ax=axes, extend="both" if low < 0 else "max", **place)
    bar.set_label(run.label)
    bar.outline.set_visible(False)


def size_of_axes(view, width):
    extent = view[2] - view[1]
    return width, width * extent[1] / extent[0]


def name_axes(axes, run, *, along=True, up=True):
    if along:
        axes.set_xlabel(run.labels[0])
    if up:
        axes.set_ylabel(run.labels[1])


def write_frames(run, steps, view, folder, dpi):
    """Returns the paths of the pictures."""
    width, height = size_of_axes(view, 6.6)
    figure = plt.figure(figsize=((1.9 if run.in_space else 1) * width + 1.9, height + 1.0), layout="constrained")
    axes = figure.add_subplot(1, 2 if run.in_space else 1, 1)
    add_colourbar(figure, axes, run, view, pad=0.02, fraction=0.046)
    if run.in_space:
        perspective, extent = figure.add_subplot(1, 2, 2, projection="3d"), space_view.bounds(run)
    paths = []
    for i, step in enumerate(steps):
        axes.clear()
        final = step == run.steps[-1]
        draw(axes, run, step, view, final=final)
        name_axes(axes, run)
        if run.in_space:
            axes.set_title("   ".join([axes.get_title(), run.labels[2]]), fontsize=12, color=DARK)
            space_view.draw(perspective, run, step, extent, (DARK, SEED), final=final)
        paths.append(folder / f"frame_{i:04d}.png")
        figure.savefig(paths[-1], dpi=dpi)
    plt.close(figure)
    return paths


def write_gif(run, paths, target, view):
    pictures = [Image.open(path).convert("RGB") for path in paths]
    # One palette for all, so that colours do not flicker; half of its source are the field's own
    # colours, so that they do not show steps.
    source = pictures[len(pictures) // 2].copy()
    if run.texture is None:
        colours = plt.get_cmap(colour_map(view[0]))(np.linspace(0, 1, source.height // 2),
                                                    bytes=True)
        strip = np.repeat(colours[:, None, :3], source.width, axis=1)
        source.paste(Image.fromarray(strip), (0, source.height // 2))
    palette = source.quantize(256)
    pictures = [p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures]
    durations = [120] * (len(pictures) - 1) + [2000]  # ms; the result stays longer
    pictures[0].save(target, save_all=True, append_images=pictures[1:], duration=durations, loop=0)


def six_moments(run):
    """As in Fig. 1 of the paper: start, insertion, implanted seed, retraction, result."""
    last = len(run.steps) - 1
    seeded = next((i for i, s in enumerate(run.steps) if "point_sets/seeds" in s), None)
    if seeded is None:
        wanted = np.linspace(0, last, 6)
    else:
        wanted = [0, seeded / 3, 2 * seeded / 3, seeded, (seeded + last) / 2, last]
    return [run.steps[int(round(i))] for i in wanted]


def write_panel(run, view, target, dpi):
    width, height = size_of_axes(view, 4.0)
    figure, grid = plt.subplots(2, 3, figsize=(3 * width + 1.6, 2 * (height + 0.5)),
                                sharex=True, sharey=True, layout="constrained")
    for i, (axes, step) in enumerate(zip(grid.flat, six_moments(run))):
        draw(axes, run, step, view, scale=0.8, final=i == 5)
        axes.set_title(f"({'abcdef'[i]})  " + axes.get_title(), fontsize=10, color=DARK)
    for axes in grid[1]:
        name_axes(axes, run, up=False)
    for axes in grid[:, 0]:
        name_axes(axes, run, along=False)
    add_colourbar(figure, grid, run, view, pad=0.01, fraction=0.03, aspect=30)
    figure.savefig(target, dpi=dpi)
    plt.close(figure)


def direction_of(words):
    """--normal as a vector, or None."""
    if words is None:
        return None
    if len(words) == 1 and words[0] in ("x", "y", "z"):
        return np.eye(3)["xyz".index(words[0])]
    try:
        direction = np.array([float(word) for word in words])
    except ValueError:
        direction = np.empty(0)
    if len(direction) != 3 or not np.all(np.isfinite(direction)):
        raise BadInput(f"--normal {' '.join(words)}; allowed: x, y, z or three numbers")
    return direction


def main():
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLES,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("outdir", type=Path, help="output folder of a run; pictures go to OUTDIR/frames")
    parser.add_argument("--field", default="displacement",
                        help="displacement (default), image, von_mises or another stored field")
    parser.add_argument("--through", type=float, nargs=3, metavar=("X", "Y", "Z"),
                        help="of a run in space: a point of the slice (cm; default: the needle's tip, else the "
                        "middle of the smallest region)")
    parser.add_argument("--normal", nargs="+", metavar="N", help="x, y, z or three numbers: the slice is across it "
                        "(default: along the needle's axis, and across z)")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="every Nth snapshot")
    parser.add_argument("--dpi", type=int, default=110, help="resolution (default 110)")
    parser.add_argument("--no-gif", action="store_true", help="no animation")
    options = parser.parse_args()
    if options.every < 1 or options.dpi < 1:
        parser.error("--every and --dpi must be at least 1")
    try:
        run = open_run(options.outdir, options.field, options.through, direction_of(options.normal))
        view = run.limits()
        folder = options.outdir / "frames"
        folder.mkdir(exist_ok=True)
        # The last snapshot is the result: it is shown whatever the stride.
        chosen = sorted(set(range(0, len(run.steps), options.every)) | {len(run.steps) - 1})
        own = OwnFiles(options.outdir)
        names = [f"frames/frame_{i:04d}.png" for i in range(len(chosen))] + ["frames/overview.png"]
        names += [] if options.no_gif else ["frames/overview.gif"]
        own.claim(names)
        for old in folder.iterdir():  # of a longer series
            if own.owns(f"frames/{old.name}"):
                old.unlink()
        paths = write_frames(run, [run.steps[i] for i in chosen], view, folder, options.dpi)
        write_panel(run, view, folder / "overview.png", options.dpi)
        if not options.no_gif:
            write_gif(run, paths, folder / "overview.gif", view)
        own.seal(names)
    except BadInput as error:
        print(f"frames.py: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"frames.py: {error}", file=sys.stderr)
        return 4
    print(f"{len(paths)} pictures and the overview in {folder}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
