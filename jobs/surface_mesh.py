#!/usr/bin/python3
"""Make a Gmsh mesh of tetrahedra of an organ and of a box of tissue around it.

The organ is a closed surface in an STL file, such as a segmented prostate. An STL file does not say
its unit: --unit does. The mesh is in metres (ASCII, format 4.1) and has

  volumes   prostate (--region) and surrounding
  surfaces  capsule (--surface) and the sides of the box: left, right (x), bottom, top (y), back, front (z)

Elements have --size on the surface and inside, and grow to --outer-size at the sides of the box. The
surface is meshed anew, on the triangles of the file. The same input gives the same bytes.

Exit codes: 0 done, 2 bad arguments or surface, 4 the mesh cannot be written.
"""

import argparse
import re
import sys

import numpy as np

import mesh_file
from closed_surface import Surface, closed, read_stl
from own_files import BadInput

EXAMPLES = """examples:
  surface_mesh.py prostate.stl prostate.msh --unit mm
  surface_mesh.py prostate.stl prostate.msh --unit mm --size 0.002 --outer-size 0.006 --margin 0.03
  surface_mesh.py prostate.stl prostate.msh --unit mm --axes IAR --centre
      of a file in patient axes of DICOM (x left, y posterior, z superior): x of the mesh points to
      inferior, y to anterior, z to right, so that needles from the perineum come through the right side
"""

MM = 1000.0  # metres to millimetres, in which Gmsh works
UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
SIDES = (("left", "right"), ("bottom", "top"), ("back", "front"))
PATIENT = {"L": (0, 1), "R": (0, -1), "P": (1, 1), "A": (1, -1), "S": (2, 1), "I": (2, -1)}
SMALLEST, LARGEST = 1.0, 1000.0  # mm; an organ of another size has another unit
MOST_TETRAHEDRA = 5e6
TETRAHEDRON = 0.25  # of the size's cube: what Gmsh's tetrahedra take
LOST = 0.1  # of the organ's volume, on elements that are too large for its shape
GOOD, POOR = 0.6, 0.1  # quality below which Gmsh improves elements, and of which a word is said
TETRAHEDRA, DELAUNAY = 4, 1  # Gmsh's numbers of an element and of a mesher


def parse_arguments(argv):
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("stl", help="STL file, binary or ASCII, of one closed surface")
    parser.add_argument("mesh", help="Gmsh file to write")
    parser.add_argument("--unit", choices=UNITS, required=True, help="unit of the STL file")
    parser.add_argument("--size", type=float, default=0.004,
                        help="element size on the surface and inside (m, default %(default)s)")
    parser.add_argument("--outer-size", type=float,
                        help="element size at the sides of the box (m, default: twice --size)")
    parser.add_argument("--margin", type=float,
                        help="tissue between organ and each side of the box (m, default 0.02)")
    parser.add_argument("--box", type=float, nargs=6, metavar=("X0", "Y0", "Z0", "X1", "Y1", "Z1"),
                        help="the box itself instead, in the axes of the mesh (m)")
    parser.add_argument("--axes", default="LPS", help="where x, y and z of the mesh point, as three of "
                        "L R A P S I; the file's are LPS (default %(default)s: as they are)")
    parser.add_argument("--centre", action="store_true",
                        help="the origin is in the middle (of volume) of the organ")
    parser.add_argument("--region", default="prostate", help="name of the organ (default %(default)s)")
    parser.add_argument("--surface", default="capsule",
                        help="name of its surface (default %(default)s)")
    parser.add_argument("--force", action="store_true", help="overwrite the mesh file")
    arguments = parser.parse_args(argv)
    if arguments.outer_size is None:
        arguments.outer_size = 2 * arguments.size
    if arguments.box is None and arguments.margin is None:
        arguments.margin = 0.02
    elif arguments.box is not None and arguments.margin is not None:
        parser.error("--margin and --box: allowed: one of them")
    for name in ("size", "outer_size", "margin"):
        value = getattr(arguments, name)
        if value is not None and not (np.isfinite(value) and value > 0):
            parser.error(f"--{name.replace('_', '-')} = {value}; allowed: above 0")
    if arguments.outer_size < arguments.size:
        parser.error(f"--outer-size = {arguments.outer_size}; allowed: --size = {arguments.size} or more")
    for name, taken in (("region", {"surrounding"}), ("surface", {n for pair in SIDES for n in pair})):
        value = getattr(arguments, name)
        if not re.fullmatch(r"[\w.-]+", value) or value in taken:
            parser.error(f"--{name} = '{value}'; allowed: letters, digits, _ . -, and none of "
                         + ", ".join(sorted(taken)))
    return arguments


def rotation(axes):
    """Rows: the axes of the mesh in those of the file."""
    if sorted(PATIENT[letter][0] if letter in PATIENT else -1 for letter in axes) == [0, 1, 2]:
        rows = np.zeros((3, 3))
        for row, letter in zip(rows, axes):
            row[PATIENT[letter][0]] = PATIENT[letter][1]
        if np.linalg.det(rows) > 0:
            return rows
        raise BadInput(f"--axes {axes}: mirrors the organ; allowed: right-handed axes, such as LPS, "
                       "RAS, IAR")
    raise BadInput(f"--axes {axes}; allowed: one of L R, one of A P and one of S I, in any order")


def placed(surface, arguments):
    """The surface in the axes of the mesh (mm)."""
    points = surface.points * UNITS[arguments.unit] @ rotation(arguments.axes).T
    extent = np.ptp(points, axis=0).max()
    if not SMALLEST <= extent <= LARGEST:
        raise BadInput(f"{arguments.stl}: is {extent:g} mm long if its unit is {arguments.unit}; "
                       f"allowed: {SMALLEST:g} to {LARGEST:g} mm: --unit")
    surface = Surface(points, surface.triangles)
    if arguments.centre:
        surface = Surface(points - surface.centroid(), surface.triangles)
    return surface


def box_around(surface, arguments):
    """Lowest and highest corner (mm)."""
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    if arguments.box is None:
        return low - MM * arguments.margin, high + MM * arguments.margin
    box = MM * np.reshape(arguments.box, (2, 3))
    if not np.all(np.isfinite(box)) or np.any(box[0] >= box[1]):
        raise BadInput(f"--box {' '.join(map(str, arguments.box))}; allowed: X0 < X1, Y0 < Y1, Z0 < Z1")
    for axis, names in enumerate(SIDES):
        for name, beyond in zip(names, (box[0] - low, high - box[1])):
            if beyond[axis] >= 0:
                raise BadInput(f"--box: the organ reaches {beyond[axis] / MM:.6g} m beyond the side "
                               f"'{name}'; allowed: a box around it, from "
                               f"{place(low)} to {place(high)} m")
    return box


def place(point):
    return " ".join(f"{x / MM:.4g}" for x in point)


def check_count(surface, box, arguments):
    """Before memory is asked for."""
    size, outer = MM * arguments.size, MM * arguments.outer_size
    organ = surface.volume()
    around = np.prod(box[1] - box[0]) - organ
    expected = organ / (TETRAHEDRON * size**3) + around / (TETRAHEDRON * (0.5 * (size + outer))**3)
    if expected > MOST_TETRAHEDRA:
        raise BadInput(f"--size {arguments.size:g}, --outer-size {arguments.outer_size:g}: some "
                       f"{expected:.3g} tetrahedra; allowed: up to {MOST_TETRAHEDRA:g}")


def add_organ(gmsh, surface):
    """Surfaces of the geometry that the triangles are."""
    tag = gmsh.model.addDiscreteEntity(2)
    gmsh.model.mesh.addNodes(2, tag, np.arange(1, len(surface.points) + 1), surface.points.ravel())
    gmsh.model.mesh.addElementsByType(tag, 2, [], surface.triangles.ravel() + 1)
    # No angle is an edge of the organ; parts that can be laid flat, so that they can be meshed anew.
    gmsh.model.mesh.classifySurfaces(np.pi, True, True, np.pi)
    gmsh.model.mesh.createGeometry()
    return [tag for _, tag in gmsh.model.getEntities(2)]


def add_box(geo, box):
    """Surfaces of the six sides by name."""
    corner = {}
    for bits in np.ndindex(2, 2, 2):
        corner[bits] = geo.addPoint(*(box[bit][axis] for axis, bit in enumerate(bits)))
    line = {}
    for a in corner:
        for b in corner:
            if a < b and sum(x != y for x, y in zip(a, b)) == 1:
                line[a, b] = geo.addLine(corner[a], corner[b])
                line[b, a] = -line[a, b]
    sides = {}
    for axis, names in enumerate(SIDES):
        for bit, name in enumerate(names):
            ring = [list(pair) for pair in ((0, 0), (1, 0), (1, 1), (0, 1))]
            ring = [tuple(pair[:axis] + [bit] + pair[axis:]) for pair in ring]
            loop = geo.addCurveLoop([line[a, b] for a, b in zip(ring, ring[1:] + ring[:1])])
            sides[name] = geo.addPlaneSurface([loop])
    return sides


def set_sizes(gmsh, organ, capsule, arguments, box, surface):
    """--size in the organ, from its surface on growing to --outer-size at the nearest side."""
    field = gmsh.model.mesh.field

    def add(kind, **values):
        tag = field.add(kind)
        for name, value in values.items():
            put = {list: field.setNumbers, str: field.setString}.get(type(value), field.setNumber)
            put(tag, name, value)
        return tag

    gap = min(np.min(surface.points.min(axis=0) - box[0]), np.min(box[1] - surface.points.max(axis=0)))
    size, outer = MM * arguments.size, MM * arguments.outer_size
    away = add("Distance", SurfacesList=capsule, NumPointsPerCurve=40)
    growing = add("Threshold", InField=away, SizeMin=size, SizeMax=outer, DistMin=0, DistMax=float(gap))
    seams = [tag for _, tag in gmsh.model.getBoundary([(2, tag) for tag in capsule], combined=False, oriented=False)]
    inside = add("Restrict", InField=add("MathEval", F=repr(size)), VolumesList=[organ], SurfacesList=capsule,
                 CurvesList=sorted(set(seams)))  # Distance is but that from samples of the surface
    field.setAsBackgroundMesh(add("Min", FieldsList=[growing, inside]))
    for option in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
        gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)


def build(gmsh, surface, box, arguments):
    """Returns the tags of the two volumes by name."""
    gmsh.clear()
    capsule = add_organ(gmsh, surface)
    geo = gmsh.model.geo
    sides = add_box(geo, box)
    inner, outer = geo.addSurfaceLoop(capsule), geo.addSurfaceLoop(list(sides.values()))
    volumes = {arguments.region: geo.addVolume([inner]), "surrounding": geo.addVolume([outer, inner])}
    geo.synchronize()
    set_sizes(gmsh, volumes[arguments.region], capsule, arguments, box, surface)
    surfaces = {arguments.surface: capsule, **{name: [tag] for name, tag in sides.items()}}
    for dim, groups in ((2, surfaces), (3, {name: [tag] for name, tag in volumes.items()})):
        for name, tags in groups.items():
            gmsh.model.setPhysicalName(dim, gmsh.model.addPhysicalGroup(dim, tags), name)
    # One thread, and not HXT, whose mesh depends on where things are in memory: always the same bytes.
    gmsh.option.setNumber("General.NumThreads", 1)
    gmsh.option.setNumber("Mesh.Algorithm3D", DELAUNAY)
    gmsh.option.setNumber("Mesh.OptimizeThreshold", GOOD)
    gmsh.model.mesh.generate(3)
    return volumes


class Measures:
    """Of the tetrahedra of a volume: quality as the program has it (mean ratio), in mm."""

    def __init__(self, points, cells):
        corners = points[cells]
        a, b, c = (corners[:, k] - corners[:, 0] for k in (1, 2, 3))
        volumes = np.sum(a * np.cross(b, c), axis=1) / 6
        edges = [np.linalg.norm(corners[:, i] - corners[:, j], axis=1) for i in range(4) for j in range(i)]
        squared = sum(edge**2 for edge in edges)
        self.number, self.volume, self.mean_edge = len(cells), float(np.sum(volumes)), np.mean(edges)
        self.quality = 12 * np.sign(volumes) * np.cbrt(3 * np.abs(volumes))**2 / squared

    def __str__(self):
        low, lower, middle = np.quantile(self.quality, [0, 0.01, 0.5])
        return (f"{self.number} tetrahedra, {self.volume / 1000:.2f} cm3, mean edge "
                f"{self.mean_edge:.2f} mm, quality from {low:.3f}, 1 % below {lower:.3f}, median "
                f"{middle:.3f}")


def measure(gmsh, volumes):
    """Number of nodes, and Measures by name."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    points = np.reshape(coordinates, (-1, 3))
    row = np.zeros(int(max(tags)) + 1, dtype=int)
    row[tags] = np.arange(len(tags))
    cells = {name: row[gmsh.model.mesh.getElementsByType(TETRAHEDRA, tag)[1]].reshape(-1, 4)
             for name, tag in volumes.items()}
    used = np.unique(np.concatenate([c.ravel() for c in cells.values()]))
    return len(used), {name: Measures(points, c) for name, c in cells.items()}


def check_measures(surface, box, arguments, measures):
    """What the mesh has to hold, whatever the mesher says."""
    whole = np.prod(box[1] - box[0])
    organ = measures[arguments.region]
    if (abs(sum(m.volume for m in measures.values()) - whole) > 1e-9 * whole
            or min(m.quality.min() for m in measures.values()) <= 0):
        raise BadInput(f"{arguments.stl}: the mesher left gaps or turned elements over; another "
                       "--size may help")
    lost = 1 - organ.volume / surface.volume()
    if abs(lost) > LOST:
        raise BadInput(f"--size {arguments.size:g}: the organ of the mesh has "
                       f"{organ.volume / 1000:.3g} cm3 of {surface.volume() / 1000:.3g}; allowed: "
                       f"{100 * LOST:g} % from it: a smaller --size")
    return lost


def run(gmsh, arguments):
    mesh_file.refuse_existing(arguments.mesh, arguments.force)
    surface, turned = closed(arguments.stl, read_stl(arguments.stl))
    surface = placed(surface, arguments)
    box = box_around(surface, arguments)
    check_count(surface, box, arguments)
    try:
        volumes = build(gmsh, surface, box, arguments)
    except Exception as error:  # gmsh knows no other
        raise BadInput(f"{arguments.stl}: cannot be meshed: {error}; another --size may help") from None
    nodes, measures = measure(gmsh, volumes)
    lost = check_measures(surface, box, arguments, measures)
    gmsh.option.setNumber("Mesh.ScalingFactor", 1 / MM)
    mesh_file.write(gmsh, arguments.mesh)
    if turned:
        print(f"{arguments.stl}: the inside was outside; turned round")
    print(f"{arguments.stl}: {len(surface.triangles)} triangles, {surface.volume() / 1000:.2f} cm3, from "
          f"({place(surface.points.min(axis=0))}) to ({place(surface.points.max(axis=0))}) m")
    print(f"{arguments.mesh}: {nodes} nodes, from ({place(box[0])}) to ({place(box[1])}) m")
    for name, values in measures.items():
        print(f"{name}: {values}")
    if min(m.quality.min() for m in measures.values()) < POOR:
        print(f"an element has a quality below {POOR}: explicit steps will be short; another --size or a larger "
              "margin may help")
    print(f"{100 * lost:.1f} % of the organ's volume is lost between its triangles and those of the mesh")


def main(argv=None):
    arguments = parse_arguments(argv)
    try:
        import gmsh  # late: --help and bad arguments need no mesher
    except ImportError:
        print("surface_mesh.py: the mesher is missing: apt-get install python3-gmsh", file=sys.stderr)
        return 2
    gmsh.initialize(["surface_mesh", "-v", "0"], readConfigFiles=False)  # its errors are raised
    try:
        run(gmsh, arguments)
    except BadInput as error:
        print(f"surface_mesh.py: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"surface_mesh.py: {error}", file=sys.stderr)
        return 4
    finally:
        gmsh.finalize()
    return 0


if __name__ == "__main__":
    sys.exit(main())
