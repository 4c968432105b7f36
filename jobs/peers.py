#!/usr/bin/env python3
"""The same elastic block in DOLFINx and in Stylet, turn and turn about.

In the plane a block of 8 x 6 cm of triangles, in space one of 8 x 6 x 4 cm of tetrahedra (p1, six to a brick),
held at its left and pulled at its right side. static: one solve at rest; implicit: average acceleration; explicit
(in the plane): central difference with lumped mass. The same mesh, material and steps; the corner must end at the
same place before times count. DOLFINx factors once, by MUMPS and by CHOLMOD, both told that the matrix is positive
definite, and multiplies by its assembled K; the faster of the two counts.

Times are of one processor's core, not of the clock, and the least of several runs: other programs that run beside
cost them caches and memory's time only. Set-up is all that comes before the steps, the first solve included: of
DOLFINx from the mesh on, without forms' compilation; of Stylet all that the program takes beyond a mesh of one brick.
Written: peers.csv.

  /usr/bin/python3 -B jobs/peers.py build/stylet out/peers --meshes 96 20x14x8
"""

import argparse
import csv
import json
import math
import resource
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SIZE = (0.08, 0.06, 0.04)  # m
E, NU, RHO, THICKNESS = 60e3, 0.3, 1000.0, 0.01
PULL = 600.0  # Pa, on the right side
SPEED_OF_SOUND = math.sqrt(E / RHO / (1 - NU**2))
SOLVERS = ("mumps", "cholmod")


def bricks_of(mesh):
    """Columns and rows, and layers in space: 96 is 96 x 72, 20x14x8 is as it says."""
    n = [int(part) for part in mesh.split("x")]
    return n if len(n) == 3 else [n[0], n[0] * 3 // 4]


def n_cells(bricks):
    return math.prod(bricks) * (6 if len(bricks) == 3 else 2)


def steps_of(method, bricks):
    """Length (s) and number of steps: some seconds of them."""
    if method == "static":
        return 1e-3, 1
    if method == "implicit":
        return 1e-3, max(40, (6_000_000 if len(bricks) == 3 else 10_000_000) // n_cells(bricks))
    return 0.3 * SIZE[0] / bricks[0] / SPEED_OF_SOUND, 40_000_000 // n_cells(bricks)


def tetrahedra(bricks):
    """Nodes and cells of `mesh: {box: ...}`: bricks that are mirrored in their neighbours, cut in six each."""
    import numpy as np

    low = np.stack(np.meshgrid(*map(np.arange, bricks), indexing="ij"), -1).reshape(-1, 3)
    cells = []
    for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
        walk = [low + low % 2]
        for axis in order:
            walk.append(walk[-1].copy())
            walk[-1][:, axis] += np.where(low[:, axis] % 2 == 0, 1, -1)
        cells.append(np.stack(walk, 1))
    place = np.concatenate(cells)
    columns, rows, _ = bricks
    cells = (place[..., 2] * (rows + 1) + place[..., 1]) * (columns + 1) + place[..., 0]
    z, y, x = np.meshgrid(*(np.linspace(0, size, n + 1) for size, n in zip(SIZE[::-1], bricks[::-1])),
                          indexing="ij")
    return np.stack([x.ravel(), y.ravel(), z.ravel()], 1), cells


def mesh_of(bricks):
    import ufl
    from dolfinx import mesh
    from mpi4py import MPI

    if len(bricks) == 2:
        return mesh.create_rectangle(MPI.COMM_WORLD, [[0, 0], SIZE[:2]], bricks, mesh.CellType.triangle,
                                     diagonal=mesh.DiagonalType.right)
    nodes, cells = tetrahedra(bricks)
    return mesh.create_mesh(MPI.COMM_WORLD, cells, nodes,
                            ufl.Mesh(ufl.VectorElement("Lagrange", "tetrahedron", 1)))


def peer(method, name, solver):
    """Run in a process of its own: prints JSON."""
    import dolfinx
    import numpy as np
    import ufl
    from dolfinx import fem, mesh
    from petsc4py import PETSc

    bricks = bricks_of(name)
    dim = len(bricks)
    h, n_steps = steps_of(method, bricks)
    domain = mesh_of(bricks)
    space = fem.VectorFunctionSpace(domain, ("Lagrange", 1))
    u, w = ufl.TrialFunction(space), ufl.TestFunction(space)
    # Plane stress in the plane.
    mu, lame = E / 2 / (1 + NU), E * NU / (1 - NU**2 if dim == 2 else (1 + NU) * (1 - 2 * NU))
    thickness = THICKNESS if dim == 2 else 1

    def stress(x):
        return 2 * mu * ufl.sym(ufl.grad(x)) + lame * ufl.div(x) * ufl.Identity(dim)

    right = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[0], SIZE[0]))
    tags = mesh.meshtags(domain, dim - 1, np.sort(right), np.ones(len(right), dtype=np.int32))
    ds = ufl.Measure("ds", domain=domain, subdomain_data=tags)
    k_form = fem.form(thickness * ufl.inner(stress(u), ufl.grad(w)) * ufl.dx)
    m_form = fem.form(thickness * RHO * ufl.inner(u, w) * ufl.dx)
    pull_form = fem.form(thickness * PULL * w[0] * ds(1))

    start = time.process_time()
    held = fem.dirichletbc(np.zeros(dim), fem.locate_dofs_geometrical(
        space, lambda x: np.isclose(x[0], 0)), space)
    pull = fem.petsc.assemble_vector(pull_form)
    held_dofs = held.dof_indices()[0]
    k = fem.petsc.assemble_matrix(k_form)
    k.assemble()
    place, velocity, work = k.createVecRight(), k.createVecRight(), k.createVecRight()
    rhs, acceleration = k.createVecRight(), k.createVecRight()

    def free(x):
        x.array[held_dofs] = 0

    def factored(a):
        a.zeroRowsColumns(held_dofs, 1)
        a.setOption(PETSc.Mat.Option.SPD, True)
        ksp = PETSc.KSP().create(domain.comm)
        ksp.setOperators(a)
        ksp.setType("preonly")
        ksp.getPC().setType("cholesky")
        ksp.getPC().setFactorSolverType(solver)
        ksp.setUp()
        return ksp

    def mass():
        m = fem.petsc.assemble_matrix(m_form)
        m.assemble()
        return m

    if method == "static":
        free(pull)
        factored(k).solve(pull, place)
        n_steps = 0
    elif method == "implicit":
        m = mass()
        a = m.copy()
        a.axpy(h * h / 4, k, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        ksp = factored(a)
        m.zeroRowsColumns(held_dofs, 1)
        begin = PETSc.KSP().create(domain.comm)
        begin.setOperators(m)
        begin.setType("cg")
        begin.setTolerances(rtol=1e-12)
        pull.copy(rhs)
        free(rhs)
        begin.solve(rhs, acceleration)

        def step():
            place.axpy(h, velocity)
            place.axpy(h * h / 4, acceleration)
            k.mult(place, work)
            pull.copy(rhs)
            rhs.axpy(-1, work)
            free(rhs)
            velocity.axpy(h / 2, acceleration)
            ksp.solve(rhs, acceleration)
            place.axpy(h * h / 4, acceleration)
            velocity.axpy(h / 2, acceleration)
    else:
        one = k.createVecRight()
        one.set(1)
        inverse = k.createVecRight()
        mass().mult(one, inverse)
        inverse.reciprocal()
        free(inverse)
        acceleration.pointwiseMult(pull, inverse)

        def step():
            velocity.axpy(h / 2, acceleration)
            place.axpy(h, velocity)
            k.mult(place, work)
            work.aypx(-1, pull)
            acceleration.pointwiseMult(work, inverse)
            velocity.axpy(h / 2, acceleration)

    set_up = time.process_time() - start
    start = time.process_time()
    for _ in range(n_steps):
        step()
    stepping = time.process_time() - start
    if n_steps > 0:
        set_up += stepping / n_steps
    x = space.tabulate_dof_coordinates()
    corner = int(np.argmin(np.linalg.norm(x[:, :dim] - SIZE[:dim], axis=1)))
    print(json.dumps({"set_up_s": set_up, "step_ms": 1e3 * stepping / n_steps if n_steps else None,
                      "corner": [float(place.array[dim * corner + i]) for i in range(dim)],
                      "cells": domain.topology.index_map(dim).size_global,
                      "version": dolfinx.__version__}))


def run(command):
    """What it prints, and the time it took of the processor (s)."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    outcome = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if outcome.returncode != 0:
        sys.exit(f"peers.py: {' '.join(map(str, command))}\n{outcome.stderr}")
    return outcome.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def ours(stylet, folder, method, bricks, n_steps):
    h, _ = steps_of(method, bricks)
    if len(bricks) == 3:
        scene = ROOT / "input/box.yaml"
        columns, rows, layers = bricks
        overrides = [f"mesh.box={{size: [8 cm, 6 cm, 4 cm], columns: {columns}, rows: {rows}, layers: {layers}}}",
                     "tissue.formulation=p1", "probes={corner: [8 cm, 6 cm, 4 cm]}"]
    else:
        scene = ROOT / "input/block.yaml"
        columns, rows = bricks
        overrides = [f"mesh={{rectangle: {{size: [8 cm, 6 cm], columns: {columns}, rows: {rows}, "
                     "diagonals: one_way}}"]
    of_method = "quasi_static" if method == "static" else method
    overrides += ["supports={left: fixed}", "expect=[]", "output={history: false}",
                  f"time={{method: {of_method}, step: {h!r} s, duration: {n_steps * h!r} s"
                  + (", scheme: average_acceleration}" if method == "implicit" else "}")]
    command = [stylet, "run", scene, "--output", folder, "--force", "--quiet"]
    for override in overrides:
        command += ["--set", override]
    _, seconds = run(command)
    summary = json.loads((folder / "summary.json").read_text())
    if summary["sub_steps"] != n_steps:
        sys.exit(f"peers.py: {summary['sub_steps']} steps instead of {n_steps}")
    return seconds, summary["probes"]["corner"]


def measure_ours(stylet, folder, method, bricks):
    """Least times of three runs: one brick, one step, all steps."""
    _, n_steps = steps_of(method, bricks)
    one_brick = [4, 3] if len(bricks) == 2 else [1, 1, 1]
    least = [math.inf] * 3

    def turn():
        for i, (of, n) in enumerate(((one_brick, 1), (bricks, 1), (bricks, n_steps))):
            seconds, corner = ours(stylet, folder, method, of, n)
            least[i] = min(least[i], seconds)
        nothing, first, all_steps = least
        return {"set_up_s": first - nothing, "corner": corner, "cells": n_cells(bricks),
                "step_ms": 1e3 * (all_steps - first) / (n_steps - 1) if n_steps > 1 else None}

    return turn


def compare(arguments, method, mesh):
    """Rows of the table of one mesh."""
    bricks = bricks_of(mesh)
    solvers = SOLVERS if method != "explicit" else SOLVERS[:1]
    turns = {f"dolfinx {solver}" if method != "explicit" else "dolfinx":
             lambda s=solver: json.loads(run(["/usr/bin/python3", "-B", __file__, "-", arguments.output,
                                              "--peer", method, mesh, s])[0]) for solver in solvers}
    turns["stylet"] = measure_ours(arguments.stylet, arguments.output / "run", method, bricks)
    best = {}
    for _ in range(arguments.repeats):
        for program, turn in turns.items():
            found = turn()
            if program in best:
                for key in ("set_up_s", "step_ms"):
                    if found[key] is not None:
                        found[key] = min(found[key], best[program][key])
            best[program] = found
    stylet = best["stylet"]
    rows = []
    for program, found in best.items():
        apart = math.dist(found["corner"], stylet["corner"]) / math.hypot(*stylet["corner"])
        rows.append({"method": method, "mesh": mesh, "program": program, "apart": apart,
                     **{key: found[key] for key in ("cells", "set_up_s", "step_ms")}})
        step = f"{found['step_ms']:9.4f}" if found["step_ms"] is not None else 9 * " "
        print(f"{method:9} {found['cells']:8} {program:16} {found['set_up_s']:9.3f} {step}  {apart:.1e}",
              flush=True)
        if apart > 1e-9:
            sys.exit("peers.py: the programs do not solve the same problem")
    ratios = []
    for key, what in (("set_up_s", "set-up"), ("step_ms", "step")):
        # The start of a program varies by some hundredths of a second.
        if stylet[key] is not None and (key == "step_ms" or stylet[key] > 0.05):
            least = min(found[key] for program, found in best.items() if program != "stylet")
            ratios.append(f"{what} {least / stylet[key]:.2f}")
    print(f"  times as fast as the faster one: {', '.join(ratios)}", flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stylet")
    parser.add_argument("output", type=Path)
    parser.add_argument("--meshes", nargs="+", default=["24", "96", "384", "20x14x8", "26x26x25"])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--peer", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.peer:
        peer(*arguments.peer)
        return
    arguments.output.mkdir(parents=True, exist_ok=True)
    rows = []
    print(f"{'method':9} {'cells':>8} {'program':16} {'set-up, s':>9} {'step, ms':>9}  corner apart")
    for mesh in arguments.meshes:
        for method in ("static", "implicit") if "x" in mesh else ("implicit", "explicit"):
            rows += compare(arguments, method, mesh)
    with open(arguments.output / "peers.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    print(f"{arguments.output / 'peers.csv'}; with the needle moving: jobs/bench.sh")


if __name__ == "__main__":
    main()
