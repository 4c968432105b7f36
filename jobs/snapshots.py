"""The snapshots of a run as pictures need them."""

import json

import h5py
import numpy as np
from PIL import Image

from own_files import BadInput

CM = 100.0  # metres to centimetres
# Shown name, factor and unit of the fields that have a customary unit of their own.
SHOWN = {
    "displacement": ("displacement", 1e3, "mm"),
    "von_mises": ("von Mises stress", 1e-3, "kPa"),
    "stress_xx": ("stress xx", 1e-3, "kPa"),
    "stress_yy": ("stress yy", 1e-3, "kPa"),
    "stress_xy": ("stress xy", 1e-3, "kPa"),
    "stress_zz": ("stress zz", 1e-3, "kPa"),
    "stress_yz": ("stress yz", 1e-3, "kPa"),
    "stress_zx": ("stress zx", 1e-3, "kPa"),
}


class Run:
    """The snapshots of an output folder of a run in the plane. Lengths are in cm."""

    in_space = False
    labels = ["x (cm)", "y (cm)", ""]  # of the axes of a picture, and where it is

    def __init__(self, folder, field):
        self.folder = folder
        for name in ("snapshots.h5", "summary.json"):
            if not (folder / name).is_file():
                raise BadInput(f"{folder / name} is missing; is this the output folder of a run "
                               "whose scene asks for snapshots?")
        try:
            self.file = h5py.File(folder / "snapshots.h5", "r")
        except OSError as error:
            raise BadInput(f"{folder / 'snapshots.h5'}: cannot be read: {error}") from None
        try:
            summary = json.loads((folder / "summary.json").read_text())
        except (OSError, ValueError) as error:
            raise BadInput(f"{folder / 'summary.json'}: cannot be read: {error}") from None
        self.seeds = summary.get("seeds", [])
        self.place = summary.get("image")
        self.texture = None
        self.steps = [self.file[name] for name in sorted(self.file) if name.startswith("step_")]
        if not self.steps:
            raise BadInput(f"{folder / 'snapshots.h5'}: holds no snapshot yet")
        self.field = field
        if field == "image":
            self.read_image()
            return
        self.stored = "u" if field == "displacement" else field
        if self.stored not in self.steps[0]:
            names = [n for n, v in self.steps[0].items() if isinstance(v, h5py.Dataset)]
            raise BadInput(f"--field {field}: the run has image, where its scene asks for one, "
                           "displacement, " + ", ".join(names))
        unit = text(self.steps[0][self.stored].attrs["unit"])
        self.label, self.factor, unit = SHOWN.get(field, (field.replace("_", " "), 1.0, unit))
        self.label += f" ({unit})" if unit else ""

    def read_image(self):
        if self.place is None:
            raise BadInput(f"--field image: {self.folder} has none: its scene has no key 'image'")
        with Image.open(self.folder / "image.png") as image:
            self.texture = np.asarray(image.convert("RGB"))

    def deformed_image(self, step, lower, upper):
        """The picture where the tissue is now, on a grid between two corners in cm."""
        height, width = self.texture.shape[:2]
        pixel = self.place["size"][0] * CM / width
        columns, rows = (int(np.ceil(extent / pixel)) for extent in upper - lower)
        canvas = np.zeros((rows, columns, 3), dtype=np.uint8)
        mesh = self.file[text(step.attrs["mesh"])]
        places = (mesh["coordinates"][:] - self.place["origin"]) / self.place["size"]
        places = places * [width, -height] + [0, height]  # in pixels of the picture
        now = (self.points(step) - lower) / pixel
        for corners in self.triangles(step):
            warp(self.texture, places[corners], canvas, now[corners])
        return canvas

    def points(self, step):
        """Nodes where they are now, in cm."""
        mesh = self.file[text(step.attrs["mesh"])]
        return (mesh["coordinates"][:] + step["u"][:, :2]) * CM

    def triangles(self, step):
        return self.file[text(step.attrs["mesh"])]["connectivity"][:]

    def values(self, step):
        values = step[self.stored][:] * self.factor
        return np.linalg.norm(values, axis=1) if values.ndim == 2 else values

    def shape(self, step, kind, name):
        """Points of a polyline or point set in cm, or none."""
        found = step.get(f"{kind}/{name}")
        return np.empty((0, 2)) if found is None else found[:] * CM

    def errors(self):
        """Seed as summary.json has it, its target and its place at the end."""
        for seed in self.seeds:
            if "target_point" in seed and seed.get("placement_error") is not None:
                yield seed, np.array(seed["target_point"]) * CM, np.array(seed["world"]) * CM

    def limits(self):
        """Colour range and axes that hold all snapshots."""
        low, high, corners = np.inf, -np.inf, []
        for step in self.steps:
            points = self.points(step)
            values = np.zeros(1) if self.texture is not None else self.values(step)
            # The few elements at the tip may be singular; they must not take all the colours.
            low = min(low, np.percentile(values, 0.5))
            high = max(high, np.percentile(values, 99.5))
            corners += [points.min(axis=0), points.max(axis=0)]
            needle = self.shape(step, "polylines", "needle")
            corners += list(needle)
        if low >= 0:
            low = 0.0
        elif high > 0:
            high = max(high, -low)
            low = -high
        if high <= low:
            high = low + 1.0
        corners = np.array(corners)
        margin = 0.03 * np.ptp(corners, axis=0).max()
        return (low, high), corners.min(axis=0) - margin, corners.max(axis=0) + margin


def warp(source, corners, canvas, now):
    """Copies a triangle of a picture to its place on the canvas; corners in pixels of either."""
    edges = np.array([now[1] - now[0], now[2] - now[0]]).T
    if np.linalg.det(edges) == 0:
        return
    low = np.maximum(np.floor(now.min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(now.max(axis=0)).astype(int), canvas.shape[1::-1])
    x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
    second, third = np.linalg.solve(edges, np.array([x.ravel() + 0.5, y.ravel() + 0.5])
                                    - now[0][:, None])
    inside = (second >= -1e-9) & (third >= -1e-9) & (second + third <= 1 + 1e-9)
    weights = np.array([1 - second - third, second, third])[:, inside]
    column, row = (corners.T @ weights).astype(int)
    known = (column >= 0) & (row >= 0) & (column < source.shape[1]) & (row < source.shape[0])
    canvas[y.ravel()[inside][known], x.ravel()[inside][known]] = source[row[known], column[known]]


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def error_words(seed):
    """Its placement error, with a word where the needle went beyond small strain."""
    doubt = ", not to be trusted" if seed.get("turned_over", 0) else ""
    return f"{1e3 * seed['placement_error']:.1f} mm{doubt}"


def open_run(folder, field, through=None, normal=None):
    """The run in the plane, or slices of the one in space: through a point (cm), across a direction."""
    from space import SpaceRun  # which is made of Run

    run = Run(folder, field)
    in_space = run.file[text(run.steps[0].attrs["mesh"])]["connectivity"].shape[1] == 4
    if in_space:
        return SpaceRun(folder, field, through, normal)
    if through is not None or normal is not None:
        raise BadInput(f"{folder}: is in the plane; --through and --normal are for slices in space")
    return run
