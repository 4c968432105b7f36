"""Scenes and meshes in space that can and cannot be run."""

import itertools
import json
import unittest

import h5py

from stylet_cli import DONE, SOURCE, CliTest, call, on_ranks

SCENE = """\
mesh:
  file: block.msh
tissue:
  regions:
    tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.3, density: 1000 kg/m^3}
supports: {left: roller, bottom: roller, back: roller}
loads:
  traction: [{surface: right, stress: [600 Pa, 0 Pa, 0 Pa]}]
probes: {corner: [2 cm, 2 cm, 2 cm]}
time: {method: quasi_static}
"""
N = 2  # bricks along an edge
SIDE = 0.02


def node(i, j, k):
    return 1 + i + (N + 1) * (j + (N + 1) * k)


def points():
    numbers = range(N + 1)
    return {node(i, j, k): [SIDE * i / N, SIDE * j / N, SIDE * k / N]
            for i, j, k in itertools.product(numbers, repeat=3)}


def tetrahedra():
    """Six a brick, around its diagonal."""
    cells = []
    for corner in itertools.product(range(N), repeat=3):
        for order in itertools.permutations(range(3)):
            at, path = list(corner), [node(*corner)]
            for axis in order:
                at[axis] += 1
                path.append(node(*at))
            cells.append(path)
    return cells


def sides(cells, x):
    """Faces on the planes at 0 and the right side, by the number of their surface."""
    faces = []
    for cell in cells:
        for face in itertools.combinations(cell, 3):
            for surface, (axis, value) in enumerate(((0, 0), (1, 0), (2, 0), (0, SIDE)), 1):
                if all(x[n][axis] == value for n in face):
                    faces.append((surface, face))
    return faces


def mesh(x=None, cells=None, faces=None, extra=(), names=()):
    """Gmsh 2.2 text. faces: (surface, nodes); extra: whole lines of elements without their number."""
    x = x or points()
    cells = tetrahedra() if cells is None else cells
    faces = sides(cells, x) if faces is None else faces
    named = ['2 1 "left"', '2 2 "bottom"', '2 3 "back"', '2 4 "right"', '3 1 "tissue"', *names]
    elements = [f"2 2 {surface} 1 {' '.join(map(str, face))}" for surface, face in faces]
    elements += [f"4 2 1 1 {' '.join(map(str, cell))}" for cell in cells]
    elements += extra
    return "\n".join(["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames",
                      str(len(named)), *named, "$EndPhysicalNames", "$Nodes", str(len(x)),
                      *(f"{n} {p[0]!r} {p[1]!r} {p[2]!r}" for n, p in x.items()), "$EndNodes",
                      "$Elements", str(len(elements)),
                      *(f"{i} {element}" for i, element in enumerate(elements, 1)),
                      "$EndElements", ""])


class Space(CliTest):
    def setUp(self):
        super().setUp()
        self.write("scene.yaml", SCENE)
        self.write("block.msh", mesh())

    def run_scene(self, *changes):
        return self.stylet("run", "scene.yaml", "--force", "--output", "out",
                           *itertools.chain(*(("--set", change) for change in changes)))

    def refuse(self, changes, *parts):
        outcome = self.run_scene(*([changes] if isinstance(changes, str) else changes))
        self.assert_refused(outcome, *parts)
        self.assertFalse((self.folder / "out").exists())

    def refuse_mesh(self, text, *parts):
        self.write("block.msh", text)
        self.refuse([], "block.msh", *parts)

    def corner(self):
        return json.loads((self.folder / "out/summary.json").read_text())["probes"]["corner"]

    def assert_pulled(self):
        """1 % along, -0.3 % across."""
        for value, exact in zip(self.corner(), (2e-4, -6e-5, -6e-5)):
            self.assertAlmostEqual(value, exact, delta=1e-13)

    def test_the_mesh_itself_is_good(self):
        self.assert_code(self.run_scene(), DONE)
        self.assert_pulled()

    def test_left_handed_tetrahedra_are_turned(self):
        cells = [[b, a, c, d] if i % 3 else [a, b, c, d]
                 for i, (a, b, c, d) in enumerate(tetrahedra())]
        self.write("block.msh", mesh(cells=cells))
        self.assert_code(self.run_scene(), DONE)
        self.assert_pulled()

    def test_inverted(self):
        """The middle node beyond the opposite faces of its tetrahedra."""
        x = points()
        x[node(1, 1, 1)] = [0.021, 0.0105, 0.0115]
        self.refuse_mesh(mesh(x), "tetrahedron", "overlaps", "same side of a shared face")

    def test_flat(self):
        x = points()
        x[node(1, 1, 1)] = x[node(1, 1, 0)][:2] + [0.0]
        self.refuse_mesh(mesh(x), "tetrahedron", "degenerate", "volume")

    def test_node_twice_in_a_tetrahedron(self):
        cells = tetrahedra()
        cells[5] = [cells[5][0], cells[5][1], cells[5][1], cells[5][3]]
        self.refuse_mesh(mesh(cells=cells), "tetrahedron", "nodes")

    def test_duplicate_tetrahedron(self):
        cells = tetrahedra()
        self.refuse_mesh(mesh(cells=cells + [cells[7]]), "tetrahedron", "duplicate")

    def test_a_missing_node(self):
        x = points()
        del x[node(1, 1, 1)]
        self.refuse_mesh(mesh(x, faces=sides(tetrahedra(), points())), f"node {node(1, 1, 1)}")

    def test_a_coordinate_that_is_no_number(self):
        self.refuse_mesh(mesh().replace("\n14 0.01 ", "\n14 nan "), "block.msh:", "not finite")

    def test_unconnected(self):
        x = points() | {n + 100: [p[0] + 1, p[1], p[2]] for n, p in points().items()}
        cells = tetrahedra()
        self.refuse_mesh(mesh(x, cells + [[n + 100 for n in cell] for cell in cells]),
                         "parts")

    def test_nodes_twice_at_an_inner_surface(self):
        """A crack between two halves that only look like one."""
        x = points()
        middle = {node(1, j, k): node(1, j, k) + 100 for j in range(3) for k in range(3)}
        x |= {copy: x[n] for n, copy in middle.items()}
        cells = [[middle.get(n, n) for n in cell] if max(x[n][0] for n in cell) > 0.015 else cell
                 for cell in tetrahedra()]
        self.refuse_mesh(mesh(x, cells), "are at the same place")

    def test_joined_along_an_edge_only(self):
        cells = [cell for cell in tetrahedra()
                 if (sum(points()[n][0] for n in cell) > 0.04) ==
                 (sum(points()[n][1] for n in cell) > 0.04)]
        self.refuse_mesh(mesh(cells=cells), "parts")

    def test_a_face_that_hangs(self):
        """One tetrahedron cut in two at an edge of the mesh, its neighbours as they were."""
        x, cells = points(), tetrahedra()
        a, b, c, d = cells[0]
        x[200] = [(p + q) / 2 for p, q in zip(x[a], x[d])]
        self.refuse_mesh(mesh(x, cells[1:] + [[a, b, c, 200], [200, b, c, d]]), "node 200",
                         "whose tetrahedron does not have it")

    def test_other_elements_beside_tetrahedra(self):
        brick = [node(*at) for at in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0),
                                      (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))]
        self.refuse_mesh(mesh(cells=tetrahedra()[6:], extra=["5 2 1 1 " + " ".join(map(str, brick))]),
                         "allowed")

    def test_quadratic_tetrahedra(self):
        ten = tetrahedra()[0] + [node(0, 0, 2)] * 6
        self.refuse_mesh(mesh(extra=["11 2 1 1 " + " ".join(map(str, ten))]), "allowed")

    def test_a_surface_that_is_no_face(self):
        faces = sides(tetrahedra(), points()) + [(1, (node(0, 0, 0), node(2, 0, 0), node(0, 2, 0)))]
        self.refuse_mesh(mesh(faces=faces), "left")

    def test_a_face_twice_in_a_surface(self):
        faces = sides(tetrahedra(), points())
        right = [face for face in faces if face[0] == 4]
        self.refuse_mesh(mesh(faces=faces + right[:1]), "right")

    def test_names_that_are_not_there(self):
        self.refuse("supports.side=fixed", "key 'supports'", "no surface named 'side'",
                    "left, bottom, back, right")
        self.refuse("loads.traction.0.surface=rihgt", "key 'loads.traction'", "rihgt")
        self.refuse("tissue.regions.gland={youngs_modulus: 1 kPa, poisson_ratio: 0.3, "
                    "density: 1 kg/m^3}", "tissue.regions", "gland")
        self.write("block.msh", mesh(names=['3 2 "gland"']).replace(" 4 2 1 1 ", " 4 2 2 1 ", 6))
        self.refuse([], "gland", "no material")

    def test_surfaces_with_two_conditions(self):
        self.refuse("prescribed=[{surface: left, displacement: [1 mm, null, null]}]",
                    "prescribed.0.displacement", "would have no effect")
        self.refuse(["prescribed=[{surface: left, displacement: [1 mm, null, null]}]",
                     "supports={left: fixed}"], "prescribed.0.surface", "a surface that is not held")
        stress = "{surface: right, stress: [1 Pa, 0 Pa, 0 Pa]}"
        self.refuse(f"loads.traction=[{stress}, {stress}]", "loads.traction.1.surface",
                    "one entry a surface")
        self.refuse(["prescribed=[{surface: right, displacement: [1 mm, 0 mm, 0 mm]}, "
                     "{surface: bottom, displacement: [2 mm, null, null]}]", "loads=null"],
                    "prescribed.1.displacement", "a point of surface 'right' too")

    def test_dimensions_that_do_not_fit(self):
        self.refuse(["tissue.plane=strain", "loads=null", "probes=null"], "block.msh:",
                    "allowed: a plane mesh")
        flat = mesh(cells=[], faces=[], extra=["2 2 1 1 1 2 5", "2 2 1 1 1 5 4"],
                    names=['2 9 "sheet"'])
        self.write("block.msh", flat)
        self.refuse([], "tissue.plane", "allowed: stress, strain", "mesh of triangles")

    def test_keys_of_the_plane(self):
        self.refuse("tissue.thickness=1 cm", "tissue.thickness", "only with tissue.plane")
        self.refuse("loads.traction.0={curve: right, force: [1 N/m, 0 N/m]}",
                    "loads.traction.0.curve", "a surface")
        self.refuse("probes.corner=[2 cm, 2 cm]", "probes.corner", "[x, y, z]")
        self.refuse("loads.body=[{force: [0 N/m^3, 1 N/m^3]}]", "loads.body.0.force", "[x, y, z]")
        self.refuse("prescribed=[{surface: right, displacement: [1 mm, null]}]",
                    "prescribed.0.displacement", "[x, y, z]")

    def test_what_is_of_the_plane(self):
        self.refuse(["needles=[{height: 1 cm, cutting: {cutting_force: 1 N}, motion: [{insert: "
                     "{speed: 1 cm/s, depth: 1 cm}}]}]"], "tissue.plane", "needles have height")
        self.refuse("procedure={file: p.csv}", "key 'procedure'", "not yet in space")
        self.refuse("targets={t: [1 cm, 1 cm]}", "key 'targets.t'", "[x, y, z]")
        self.refuse("image={}", "key 'image'", "not yet in space")
        self.refuse("needle_angle=90 deg", "key 'needle_angle'", "only with tissue.plane")
        for verb in ("tradeoff", "plan"):
            self.assert_refused(self.stylet(verb, "scene.yaml"), "scene.yaml")

    def test_needles_have_no_stable_step_of_their_own(self):
        outcome = self.stylet("stability", SOURCE / "input/prostate3d.yaml", "--output", "stable")
        self.assert_refused(outcome, "needles", "stable step")

    def test_tissue_that_nothing_holds(self):
        self.refuse("supports={left: roller, bottom: roller}", "key 'supports'", "moving along z")

    def test_size(self):
        """Before anything is made of it."""
        self.refuse("mesh.refine=9", "mesh.refine", "6.44245e+09 tetrahedra", "GB",
                    "allowed here: up to")
        self.assert_refused(self.stylet("converge", "scene.yaml", "--mesh-levels", 9),
                            "--mesh-levels", "tetrahedra", "GB", "fewer")

    def test_snapshots(self):
        """From two ranks; ParaView looks at them where it is installed."""
        self.assert_code(on_ranks(2, self.folder, "run", "scene.yaml", "--output", "out", "--set",
                                  "time={method: implicit, step: 1 ms, duration: 5 ms}", "--set",
                                  "output.snapshots=2 ms"), DONE)
        checker = SOURCE / "tests/python/check_snapshots.py"
        looked = call(["/usr/bin/python3", "-B", checker, "out"], self.folder)
        self.assert_code(looked, DONE)
        self.assertIn(" 0 problems", looked.out)
        with h5py.File(self.folder / "out/snapshots.h5") as file:
            step = file[[name for name in sorted(file) if name.startswith("step_")][-1]]
            self.assertEqual(step["u"].shape, ((N + 1) ** 3, 3))
            for field in ("stress_zz", "stress_yz", "stress_zx"):
                self.assertEqual(len(step[field]), 6 * N ** 3)

    def test_converge(self):
        outcome = self.stylet("converge", "scene.yaml", "--mesh-levels", 2, "--step-levels", 1,
                              "--no-picture", "--set", "tissue.regions.tissue.poisson_ratio=0.4",
                              "--set", "supports={left: fixed}")
        self.assert_code(outcome, DONE)
        self.assertIn("level with mesh.refine 1", outcome.err)
        study = json.loads((self.folder / "out/converge-scene/convergence.json").read_text())
        self.assertEqual([run["n_tetrahedra"] for run in study["runs"]], [48, 384])
        self.assertIn("probes.corner.2", study["quantities"])
        self.assertGreater(study["fields"]["mesh"][0][0], 0)


if __name__ == "__main__":
    unittest.main()
