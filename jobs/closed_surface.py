"""A surface of triangles from an STL file, and whether it encloses a body.

An STL file is a heap of triangles: nothing in it says that they meet, which side is out, or what unit
their numbers have.
"""

import math

import numpy as np

from own_files import BadInput

KNIFE = 1.0  # degrees; two triangles at an edge that enclose less lie on each other
CHUNK = 256  # triangles whose boxes are compared at a time with all that may reach them


class Surface:
    """points: (n, 3); triangles: (m, 3) rows of points, counter-clockwise from outside."""

    def __init__(self, points, triangles):
        self.points, self.triangles = points, triangles

    def corners(self):
        return self.points[self.triangles]

    def volume(self):
        a, b, c = (self.corners() - self.points.mean(axis=0)).transpose(1, 0, 2)
        return float(np.sum(a * np.cross(b, c))) / 6

    def centroid(self):
        middle = self.points.mean(axis=0)
        a, b, c = (self.corners() - middle).transpose(1, 0, 2)
        weights = np.sum(a * np.cross(b, c), axis=1)
        return middle + np.sum(weights[:, None] * (a + b + c), axis=0) / (4 * np.sum(weights))

    def turned_round(self):
        return Surface(self.points, self.triangles[:, ::-1])


def read_stl(path):
    """All triangles of the file, binary or ASCII, of all its solids; points at one place are one."""
    try:
        with open(path, "rb") as file:
            data = file.read()
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror}") from None
    facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    n = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) == 84 + n * facet.itemsize:
        corners = np.frombuffer(data, facet, n, 84)["corners"].astype(float)
    elif data.lstrip()[:5].lower() == b"solid":
        corners = corners_of_text(path, data.decode("latin-1").lower())
    else:
        raise BadInput(f"{path}: is no STL file, or not a whole one: neither text that begins with "
                       "'solid' nor binary of the length that it says")
    if len(corners) == 0:
        raise BadInput(f"{path}: holds no triangles")
    if not np.all(np.isfinite(corners)):
        raise BadInput(f"{path}: holds a coordinate that is not finite")
    # -0 is 0. Triangles with two corners at one place are nothing, and their neighbours meet.
    points, same = np.unique(corners.reshape(-1, 3) + 0.0, axis=0, return_inverse=True)
    triangles = same.reshape(-1, 3)
    return Surface(points, triangles[np.all(triangles != np.roll(triangles, 1, axis=1), axis=1)])


def corners_of_text(path, text):
    lines = [line.split() for line in text.splitlines() if line.strip()]
    count = {word: sum(line[0] == word for line in lines)
             for word in ("solid", "facet", "endfacet", "endsolid", "vertex")}
    if count["solid"] != count["endsolid"] or not (
            3 * count["facet"] == 3 * count["endfacet"] == count["vertex"]):
        raise BadInput(f"{path}: is no whole STL file: " + ", ".join(f"{n} {w}" for w, n in count.items()))
    try:
        values = [[float(word) for word in line[1:]] for line in lines if line[0] == "vertex"]
        return np.array(values, dtype=float).reshape(-1, 3, 3)
    except ValueError:
        raise BadInput(f"{path}: holds a vertex that is not three numbers") from None


def edges_of(triangles):
    """Directed edges, (3 m, 2); that of triangle t are rows t, m + t and 2 m + t."""
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


def place(point):
    return "(" + ", ".join(f"{x:.6g}" for x in point) + ")"


def check_edges(path, surface):
    """Every edge has two triangles, which pass it in opposite directions."""
    directed = edges_of(surface.triangles)
    edges, of_edge, uses = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True,
                                     return_counts=True)
    for wrong, what in ((uses == 1, "open edges: the surface is not closed"),
                        (uses > 2, "edges with more than two triangles: sheets that meet, or parts "
                                   "that touch")):
        if np.any(wrong):
            where = surface.points[edges[np.argmax(wrong)]].mean(axis=0)
            raise BadInput(f"{path}: {np.count_nonzero(wrong)} {what}, such as the one at "
                           f"{place(where)} in the file's unit; allowed: one closed surface")
    forward = np.bincount(of_edge, directed[:, 0] < directed[:, 1])
    if np.any(forward != 1):
        raise BadInput(f"{path}: {np.count_nonzero(forward != 1)} edges whose triangles disagree on "
                       "which side is outside; allowed: triangles that are oriented alike")


def check_one_shell(path, surface):
    """All triangles hang together at edges. Labels of neighbours spread until none changes."""
    m = len(surface.triangles)
    _, of_edge = np.unique(np.sort(edges_of(surface.triangles), axis=1), axis=0, return_inverse=True)
    pairs = np.argsort(of_edge, kind="stable").reshape(-1, 2) % m
    label = np.arange(m)
    while True:
        lowest = label[pairs].min(axis=1)
        new = label.copy()
        np.minimum.at(new, pairs[:, 0], lowest)
        np.minimum.at(new, pairs[:, 1], lowest)
        new = new[new]  # far faster than a ring of neighbours at a time
        if np.array_equal(new, label):
            break
        label = new
    sizes = np.unique(label, return_counts=True)[1]
    if len(sizes) > 1:
        raise BadInput(f"{path}: {len(sizes)} separate shells, of {', '.join(map(str, sizes[:6]))} "
                       "triangles; allowed: one organ a file")


def near_pairs(low, high):
    """Pairs of boxes that meet, each once, a chunk at a time."""
    order = np.argsort(low[:, 0], kind="stable")
    low, high = low[order], high[order]
    for start in range(0, len(order), CHUNK):
        chunk = slice(start, min(start + CHUNK, len(order)))
        end = np.searchsorted(low[:, 0], high[chunk, 0].max(), side="right")
        meet = np.all((low[None, start:end] <= high[chunk, None]) &
                      (high[None, start:end] >= low[chunk, None]), axis=2)
        i, j = np.nonzero(np.triu(meet, 1))
        yield order[start + i], order[start + j]


def pierces(surface, edges, triangles):
    """Whether an edge goes through a triangle that shares no corner with it; row by row."""
    p, q = surface.points[edges].transpose(1, 0, 2)
    a, b, c = surface.points[triangles].transpose(1, 0, 2)
    size = np.max(np.abs(np.stack([q, a, b, c]) - p), axis=(0, 2))

    def side(o, u, v, w):
        """Six times a volume, 0 where its sign is but rounding."""
        six = np.sum((u - o) * np.cross(v - o, w - o), axis=1)
        return np.where(np.abs(six) <= 1e-13 * size**3, 0, np.sign(six))

    across = side(a, b, c, p), side(a, b, c, q)
    through = np.stack([side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)])
    meets = across[0] * across[1] <= 0
    meets &= (across[0] != 0) | (across[1] != 0)  # in one plane: the mesher finds what overlaps
    meets &= np.all(through >= 0, axis=0) | np.all(through <= 0, axis=0)
    shared = np.any(edges[:, :, None] == triangles[:, None, :], axis=(1, 2))
    return meets & ~shared


def check_simple(path, surface):
    """No two triangles may meet, but neighbours at their common edge or corner."""
    directed = edges_of(surface.triangles)
    m = len(surface.triangles)
    corners = surface.corners()
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    _, of_edge = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True)
    pairs = np.argsort(of_edge, kind="stable").reshape(-1, 2) % m
    cosine = np.sum(normals[pairs[:, 0]] * normals[pairs[:, 1]], axis=1)
    folded = cosine < -math.cos(math.radians(KNIFE)) * lengths[pairs[:, 0]] * lengths[pairs[:, 1]]
    if np.any(folded):
        where = corners[pairs[np.argmax(folded), 0]].mean(axis=0)
        raise BadInput(f"{path}: the surface is folded onto itself at {place(where)} in the file's "
                       "unit; allowed: a surface that does not meet itself")
    for i, j in near_pairs(corners.min(axis=1), corners.max(axis=1)):
        for one, other in ((i, j), (j, i)):
            for k in range(3):
                found = pierces(surface, directed[k * m + one], surface.triangles[other])
                if np.any(found):
                    where = corners[one[np.argmax(found)]].mean(axis=0)
                    raise BadInput(f"{path}: the surface crosses itself at {place(where)} in the "
                                   "file's unit; allowed: a surface that does not meet itself")


def closed(path, surface):
    """The surface with its outside out, and whether it had to be turned round; refused if it does not
    enclose one body."""
    check_edges(path, surface)
    check_one_shell(path, surface)
    check_simple(path, surface)
    volume = surface.volume()
    if not abs(volume) > 0:
        raise BadInput(f"{path}: the surface encloses no volume")
    return (surface.turned_round(), True) if volume < 0 else (surface, False)
