"""A run in space as pictures need it: slices of the tissue where it is now, and surfaces in it."""

import numpy as np

from own_files import BadInput
from snapshots import CM, Run, text

NEAR = 0.5  # cm; what is farther from a slice is not drawn in it
AXES = {"x": 0, "y": 1, "z": 2}
FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])  # of a tetrahedron, outwards


class Plane:
    """Through a point (cm). A picture of it has `right` and `up`, and looks along -normal."""

    def __init__(self, point, normal):
        self.normal = normal / np.linalg.norm(normal)
        upright = np.eye(3)[1 if abs(self.normal[2]) > 0.7 else 2]
        self.up = upright - upright @ self.normal * self.normal
        self.up /= np.linalg.norm(self.up)
        self.right = np.cross(self.up, self.normal)
        if self.right[np.argmax(np.abs(self.right))] < 0:  # seen from behind: axes grow to the right
            self.normal, self.right = -self.normal, -self.right
        self.offset = point @ self.normal

    def height(self, points):
        return points @ self.normal - self.offset

    def flat(self, points):
        return np.stack([points @ self.right, points @ self.up], axis=-1)

    def frame(self, low, high):
        """Corners in space of a rectangle of the picture, (5, 3), the first one twice."""
        corners = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]), (low[0], low[1])]
        return np.array(corners) @ [self.right, self.up] + self.offset * self.normal

    def words(self):
        """What the axes of a picture show, and where the plane is."""
        sign = np.sign(self.normal[np.argmax(np.abs(self.normal))])
        return [*(f"{direction(axis)} (cm)" for axis in (self.right, self.up)),
                f"{direction(sign * self.normal)} = {sign * self.offset:.2f} cm"]


def direction(vector):
    named = [name for name, axis in AXES.items() if vector[axis] > 1 - 1e-12]
    return named[0] if named else "(" + ", ".join(f"{x:.2f}" for x in vector) + ")"


def edge_points(values, height, ends):
    """Linear fields where edges (..., 2 nodes) cross the plane; values: (n, components)."""
    a, b = height[ends[..., 0]], height[ends[..., 1]]
    t = (a / (a - b))[..., None]
    return (1 - t) * values[ends[..., 0]] + t * values[ends[..., 1]]


def cut(cells, height):
    """Where tetrahedra, or triangles, cross a plane: (cells, polygons) for each number of corners, each
    corner being an edge of two nodes. A node in the plane counts as below it."""
    above = height[cells] > 0
    cells = np.take_along_axis(cells, np.argsort(~above, axis=1, kind="stable"), axis=1)
    n, k = np.count_nonzero(above, axis=1), cells.shape[1]
    ways = {3: {1: [(0, 1), (0, 2)], 2: [(0, 2), (1, 2)]},
            4: {1: [(0, 1), (0, 2), (0, 3)], 3: [(0, 3), (1, 3), (2, 3)],
                2: [(0, 2), (0, 3), (1, 3), (1, 2)]}}[k]
    for count, edges in ways.items():
        found = np.flatnonzero(n == count)
        yield found, cells[found][:, np.array(edges)]


def interfaces(cells, region):
    """Triangles between cells of two regions, or the boundary where there is one region only."""
    faces = cells[:, FACES].reshape(-1, 3)
    of_cell = np.repeat(np.arange(len(cells)), 4)
    key = np.sort(faces, axis=1)
    order = np.lexsort(key.T)
    same = np.all(key[order[1:]] == key[order[:-1]], axis=1)
    first, second = order[:-1][same], order[1:][same]
    between = region[of_cell[first]] != region[of_cell[second]]
    if np.any(between):
        return faces[first[between]]
    inner = np.zeros(len(faces), dtype=bool)
    inner[first] = inner[second] = True
    return faces[~inner]


class SpaceRun(Run):
    """Draws like a run in the plane: what it hands out is a slice."""

    in_space = True

    def __init__(self, folder, field, through=None, normal=None):
        super().__init__(folder, field)
        self.plane = self.plane_of(through, normal)
        self.labels = self.plane.words()
        self.sliced = None, None  # the step that was asked for last
        self.surface = None, None

    def plane_of(self, through, normal):
        """By default that of the last needle's axis, else through the middle."""
        needle = next((line for step in reversed(self.steps)
                       if len(line := self.lines(step, "polylines", "needle")) > 1), None)
        if through is None:
            through = self.middle() if needle is None else needle[-1]
        if normal is None:
            normal = np.array([0.0, 0, 1])
            if needle is not None:
                along = needle[-1] - needle[0]
                along /= np.linalg.norm(along)
                normal = np.eye(3)[1 if abs(along[2]) > 0.9 else 2]
                normal = normal - normal @ along * along
        if not np.linalg.norm(normal) > 0:
            raise BadInput("--normal 0 0 0: allowed: a direction")
        plane = Plane(np.asarray(through, dtype=float), np.asarray(normal, dtype=float))
        heights = plane.height(self.places(self.steps[0]))
        if not heights.min() < 0 < heights.max():
            raise BadInput(f"--through {' '.join(f'{x:g}' for x in through)}: a slice there misses the "
                           f"tissue by {np.abs(heights).min():.3g} cm")
        return plane

    def middle(self):
        """Of the smallest region, or of all tissue."""
        step = self.steps[0]
        cells, region = self.cells(step), step["region"][:]
        smallest = np.argmin(np.bincount(region))
        points = self.places(step)[np.unique(cells[region == smallest])]
        return (points.min(axis=0) + points.max(axis=0)) / 2

    def places(self, step):
        """Nodes where they are now, in cm."""
        return (self.file[text(step.attrs["mesh"])]["coordinates"][:] + step["u"][:]) * CM

    def cells(self, step):
        return self.file[text(step.attrs["mesh"])]["connectivity"][:]

    def interface(self, step):
        """Triangles of nodes between regions: the capsule."""
        mesh = text(step.attrs["mesh"])
        if self.surface[0] != mesh:
            self.surface = mesh, interfaces(self.cells(step), step["region"][:])
        return self.surface[1]

    def slice(self, step):
        """points (n, 2), triangles (m, 3) of them, values of points or triangles, edges (k, 2, 2)."""
        if self.sliced[0] == step.name:
            return self.sliced[1]
        places, cells = self.places(step), self.cells(step)
        height, stored = self.plane.height(places), step[self.stored][:].astype(float)
        on_nodes = len(stored) == len(places)
        stored = stored.reshape(len(stored), -1) * self.factor
        points, triangles, values, edges, n = [], [], [], [], 0
        for found, polygons in cut(cells, height):
            corners = self.plane.flat(edge_points(places, height, polygons))
            of_corner = edge_points(stored, height, polygons) if on_nodes else None
            edges.append(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 2))
            start = n + np.arange(len(found))[:, None] * polygons.shape[1]
            n += corners.shape[0] * corners.shape[1]
            points.append(corners.reshape(-1, 2))
            for k in range(1, polygons.shape[1] - 1):  # a fan
                triangles.append(start + [0, k, k + 1])
                if not on_nodes:
                    values.append(stored[found])
            if on_nodes:
                values.append(of_corner.reshape(-1, stored.shape[1]))
        values = np.concatenate(values)
        values = np.linalg.norm(values, axis=1) if values.shape[1] > 1 else values[:, 0]
        self.sliced = step.name, (np.concatenate(points), np.concatenate(triangles), values,
                                  np.concatenate(edges))
        return self.sliced[1]

    def points(self, step):
        return self.slice(step)[0]

    def triangles(self, step):
        return self.slice(step)[1]

    def values(self, step):
        return self.slice(step)[2]

    def edges(self, step):
        return self.slice(step)[3]

    def outlines(self, step):
        """Where the slice crosses the capsule: lines (n, 2, 2)."""
        places = self.places(step)
        height = self.plane.height(places)
        return np.concatenate([self.plane.flat(edge_points(places, height, lines))
                               for _, lines in cut(self.interface(step), height)])

    def lines(self, step, kind, name):
        """Points of a polyline or point set in space, in cm, or none."""
        found = step.get(f"{kind}/{name}")
        return np.empty((0, 3)) if found is None else found[:] * CM

    def shape(self, step, kind, name):
        points = self.lines(step, kind, name)
        near = np.abs(self.plane.height(points)) <= NEAR
        if kind == "polylines":  # whole, or not at all
            near[:] = near.any()
        return self.plane.flat(points[near])

    def errors(self):
        """Of the seeds whose targets are near the slice; see Run.errors."""
        for seed, target, place in self.errors_in_space():
            if abs(self.plane.height(target)) <= NEAR:
                yield seed, self.plane.flat(target), self.plane.flat(place)

    def errors_in_space(self):
        return super().errors()
