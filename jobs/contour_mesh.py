#!/usr/bin/python3
"""Make a Gmsh mesh of soft tissue around a closed contour, such as a segmented prostate.

The contour is a CSV file with the header x_m,y_m and ordered points in metres. The tissue around it
is a rectangle; the needle comes from its right side. The mesh (ASCII, format 4.1) has

  surfaces  prostate, surrounding and, if asked for, tumour
  curves    left, right, bottom, top, prostate_outline and tumour_outline

Exit codes: 0 done, 2 bad arguments or contour, 4 the mesh cannot be written.
"""

import argparse
import sys

import numpy as np

import mesh_file
from own_files import BadInput

EXAMPLES = """examples:
  contour_mesh.py prostate.csv prostate.msh
  contour_mesh.py prostate.csv prostate.msh --size 0.002 --outer-size 0.005 --margin 0.03
  contour_mesh.py prostate.csv prostate.msh --tumour 0.01 0.005 0.012 0.010
"""


def parse_arguments(argv):
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("contour", help="CSV file with the header x_m,y_m (metres)")
    parser.add_argument("mesh", help="Gmsh file to write")
    parser.add_argument("--size", type=float, default=0.003,
                        help="element size on and inside the contour (m, default %(default)s)")
    parser.add_argument("--outer-size", type=float,
                        help="element size at the sides of the rectangle (m, default: twice --size)")
    parser.add_argument("--margin", type=float, default=0.02,
                        help="tissue between the contour and each side (m, default %(default)s)")
    parser.add_argument("--scale", type=float, default=1.0,
                        help="multiplies the contour about the origin (default %(default)s); the "
                        "other lengths are not scaled")
    parser.add_argument("--tumour", type=float, nargs=4, metavar=("X", "Y", "WIDTH", "HEIGHT"),
                        help="ellipse inside the scaled contour: centre and full extents (m)")
    parser.add_argument("--force", action="store_true", help="overwrite the mesh file")
    arguments = parser.parse_args(argv)
    if arguments.outer_size is None:
        arguments.outer_size = 2 * arguments.size
    for name in ("size", "outer_size", "margin", "scale"):
        value = getattr(arguments, name)
        if not (np.isfinite(value) and value > 0):
            parser.error(f"--{name.replace('_', '-')} = {value}; allowed: above 0")
    return arguments


def read_contour(path):
    """Points of the contour, one row each; the first is not repeated at the end."""
    try:
        with open(path, encoding="utf-8-sig") as file:
            lines = file.read().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}")
    header = lines[0].strip() if lines else ""
    if header.replace(" ", "") != "x_m,y_m":
        raise BadInput(f"{path}:1: header '{header}'; allowed: x_m,y_m (metres)")
    points = []
    for number, line in enumerate(lines[1:], start=2):
        if not line.strip():
            continue
        try:
            point = [float(word) for word in line.split(",")]
        except ValueError:
            point = []
        if len(point) != 2 or not np.all(np.isfinite(point)):
            raise BadInput(f"{path}:{number}: '{line}'; allowed: two numbers with a comma between")
        if not points or point != points[-1]:
            points.append(point)
    if len(points) > 1 and points[0] == points[-1]:
        points.pop()
    if len(points) < 3:
        raise BadInput(f"{path}: {len(points)} different points; allowed: 3 or more")
    return np.array(points)


def signed_area(points):
    x, y = points.T
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


def check_simple(path, points):
    """No two edges of the contour may meet, but neighbours in their common point."""
    n = len(points)
    ends = np.roll(points, -1, axis=0)

    def side(a, b, p):
        return (b[..., 0] - a[..., 0]) * (p[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (
            p[..., 0] - a[..., 0]
        )

    for i in range(n):
        others = np.arange(i + 2, n - 1 if i == 0 else n)
        a, b, c, d = points[i], ends[i], points[others], ends[others]
        apart = np.max(np.minimum(c, d) - np.maximum(a, b), axis=1, initial=-np.inf) > 0
        apart |= np.max(np.minimum(a, b) - np.maximum(c, d), axis=1, initial=-np.inf) > 0
        meets = (side(a, b, c) * side(a, b, d) <= 0) & (side(c, d, a) * side(c, d, b) <= 0) & ~apart
        if np.any(meets):
            j = others[np.argmax(meets)]
            raise BadInput(
                f"{path}: the contour crosses itself: the edges from points {i + 1} and {j + 1} meet"
            )
    if not abs(signed_area(points)) > 0:
        raise BadInput(f"{path}: the contour encloses no area")


def split_long_edges(points, size):
    """Keeps all points and adds more where they are farther apart than the element size."""
    pieces = []
    for a, b in zip(points, np.roll(points, -1, axis=0)):
        n = max(1, int(np.ceil(np.linalg.norm(b - a) / size - 1e-9)))
        pieces.append(a + np.arange(n)[:, None] / n * (b - a))
    return np.concatenate(pieces)


def tumour_points(tumour, size):
    x, y, width, height = tumour
    if not (np.all(np.isfinite(tumour)) and width > 0 and height > 0):
        raise BadInput(f"--tumour {x} {y} {width} {height}; allowed: width and height above 0")
    n = max(16, int(np.ceil(np.pi * 0.5 * (width + height) / size)))
    angle = 2 * np.pi * np.arange(n) / n
    return np.column_stack([x + 0.5 * width * np.cos(angle), y + 0.5 * height * np.sin(angle)])


def is_inside(polygon, point):
    """Even-odd rule."""
    (x0, y0), (x1, y1) = polygon.T, np.roll(polygon, -1, axis=0).T
    spans = (y0 > point[1]) != (y1 > point[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = x0 + (x1 - x0) * (point[1] - y0) / (y1 - y0)
    return bool(np.count_nonzero(spans & (point[0] < crossing)) % 2)


def add_loop(geo, points, size):
    """Straight lines through the points; returns the lines and their loop."""
    corners = [geo.addPoint(x, y, 0, size) for x, y in points]
    lines = [geo.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1])]
    return lines, geo.addCurveLoop(lines)


def build(gmsh, contour, tumour, arguments):
    geo = gmsh.model.geo
    low = contour.min(axis=0) - arguments.margin
    high = contour.max(axis=0) + arguments.margin
    box = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    sides, outer = add_loop(geo, box, arguments.outer_size)
    outline, inner = add_loop(geo, contour, arguments.size)
    surfaces = {"surrounding": geo.addPlaneSurface([outer, inner])}
    curves = {name: [line] for name, line in zip(("bottom", "right", "top", "left"), sides)}
    curves["prostate_outline"] = outline
    holes = [inner]
    if tumour is not None:
        curves["tumour_outline"], core = add_loop(geo, tumour, arguments.size)
        surfaces["tumour"] = geo.addPlaneSurface([core])
        holes.append(core)
    surfaces["prostate"] = geo.addPlaneSurface(holes)
    geo.synchronize()
    for line in outline + curves.get("tumour_outline", []):
        gmsh.model.mesh.setTransfiniteCurve(line, 2)  # its two ends and no more
    for dim, groups in ((1, curves), (2, {name: [tag] for name, tag in surfaces.items()})):
        for name, tags in groups.items():
            gmsh.model.setPhysicalName(dim, gmsh.model.addPhysicalGroup(dim, tags), name)
    gmsh.model.mesh.generate(2)


def measure(gmsh):
    """Numbers of nodes and triangles, and the worst 4 sqrt(3) area / (sum of squared edges)."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    row = {tag: i for i, tag in enumerate(tags)}
    _, corners = gmsh.model.mesh.getElementsByType(2)
    triangles = np.array([row[tag] for tag in corners]).reshape(-1, 3)
    a, b, c = (np.reshape(coordinates, (-1, 3))[triangles[:, k], :2] for k in range(3))
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    squared = sum(np.sum(edge**2, axis=1) for edge in (b - a, c - b, a - c))
    return len(np.unique(triangles)), len(triangles), np.min(4 * np.sqrt(3) * abs(area) / squared)


def run(arguments):
    contour = arguments.scale * read_contour(arguments.contour)
    check_simple(arguments.contour, contour)
    mesh_file.refuse_existing(arguments.mesh, arguments.force)
    if signed_area(contour) < 0:
        contour = contour[::-1]
    tumour = None
    if arguments.tumour is not None:
        tumour = tumour_points(arguments.tumour, arguments.size)
        inside = all(is_inside(contour, point) for point in tumour)
        if not inside or any(is_inside(tumour, point) for point in contour):
            raise BadInput("--tumour reaches out of the contour; allowed: inside it")
    contour = split_long_edges(contour, arguments.size)

    import gmsh  # late: --help and bad input need no mesher

    gmsh.initialize(["contour_mesh", "-v", "2"])
    try:
        build(gmsh, contour, tumour, arguments)
        n_nodes, n_triangles, worst = measure(gmsh)
        mesh_file.write(gmsh, arguments.mesh)
    finally:
        gmsh.finalize()
    print(f"{arguments.mesh}: {n_nodes} nodes, {n_triangles} triangles, worst quality {worst:.3f}")


def main(argv=None):
    arguments = parse_arguments(argv)
    try:
        run(arguments)
    except BadInput as error:
        print(f"contour_mesh.py: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"contour_mesh.py: {error}", file=sys.stderr)
        return 4
    return 0


if __name__ == "__main__":
    sys.exit(main())
