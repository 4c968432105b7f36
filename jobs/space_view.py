"""A moment of a run in space, in perspective: the capsule, needle, seeds, targets and errors."""

import numpy as np
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from snapshots import error_words

CAPSULE = np.array([0.78, 0.42, 0.40])
LIGHT = np.array([0.4, -0.5, 0.77])
EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if bin(a ^ b).count("1") == 1]


def bounds(run):
    """Lowest and highest corner of all moments (cm)."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for step in run.steps:
        for points in (run.places(step), run.lines(step, "point_sets", "targets"),
                       run.lines(step, "point_sets", "seeds")):
            if len(points):
                low, high = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
    return low, high


def box(low, high):
    corners = np.array([[(low, high)[bits >> axis & 1][axis] for axis in range(3)] for bits in range(8)])
    return [corners[list(pair)] for pair in EDGES]


def draw(axes, run, step, extent, colours, *, final=False):
    """colours: of dark lines and of seeds. Errors are drawn in the last picture."""
    dark, bright = colours
    low, high = extent
    axes.clear()
    axes.add_collection3d(Line3DCollection(box(low, high), colors=dark, linewidths=0.6, alpha=0.5))
    flat = run.points(step)
    axes.plot(*run.plane.frame(flat.min(axis=0), flat.max(axis=0)).T, color=dark, linewidth=1, linestyle=":")
    corners = run.places(step)[run.interface(step)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)
    bright_side = 0.65 + 0.35 * np.abs(normals @ LIGHT) / lengths
    shades = np.column_stack([np.clip(bright_side[:, None] * CAPSULE, 0, 1), np.full(len(corners), 0.22)])
    axes.add_collection3d(Poly3DCollection(corners, facecolors=shades, linewidths=0))
    needle = run.lines(step, "polylines", "needle")
    if len(needle):
        inside = np.clip(needle, low - 0.15 * (high - low), high + 0.15 * (high - low))
        axes.plot(*inside.T, color=dark, linewidth=2.4)
    targets = run.lines(step, "point_sets", "targets")
    axes.plot(*targets.T, "+", color=dark, markersize=8, markeredgewidth=1.8)
    seeds = run.lines(step, "point_sets", "seeds")
    axes.plot(*seeds.T, "s", color=bright, markersize=5, markeredgecolor="white", markeredgewidth=0.7)
    if final:
        for seed, target, place in run.errors_in_space():
            axes.quiver(*target, *(place - target), color=bright, linewidth=1.6, arrow_length_ratio=0.25)
            axes.text(*place, "  " + error_words(seed), fontsize=8, color=dark, zorder=9)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low)
    axes.set_axis_off()
    for k, name in enumerate("xyz"):  # where the axes point, at the lowest corner
        tip = low.copy()
        tip[k] = high[k]
        axes.text(*tip, name, fontsize=9, color=dark, ha="center")
    axes.view_init(elev=22, azim=-62)
