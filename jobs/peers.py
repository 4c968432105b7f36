#!/usr/bin/env python3
"""The same elastodynamic block in DOLFINx and in Stylet, turn and turn about.

A block of 8 x 6 cm, held at its left and pulled at its right side: average acceleration (DOLFINx:
Cholesky of MUMPS, factored once) and central difference with lumped mass (DOLFINx: a product with the
assembled K). Linear triangles, the same mesh and steps; the corner must end at the same place before
times count. Then Stylet's steps on the reference scene with the needle moving, which the peer cannot
do. Written: peers.csv.

  /usr/bin/python3 -B jobs/peers.py build/stylet out/peers --columns 24 96 768
"""

import argparse
import csv
import json
import math
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WIDTH, HEIGHT = 0.08, 0.06  # m
E, NU, RHO, THICKNESS = 60e3, 0.3, 1000.0, 0.01
PULL = 6.0  # N/m, on the right side
SPEED_OF_SOUND = math.sqrt(E / RHO / (1 - NU**2))


def steps_of(method, columns):
    """Length (s) and number of steps."""
    if method == "implicit":
        return 1e-3, 400 if columns < 100 else 20
    return 0.3 * WIDTH / columns / SPEED_OF_SOUND, 400 if columns < 400 else 60


def peer(method, columns):
    """Run in a process of its own: prints JSON."""
    import dolfinx
    import numpy as np
    import ufl
    from dolfinx import fem, mesh
    from mpi4py import MPI
    from petsc4py import PETSc

    h, n_steps = steps_of(method, columns)
    start = time.perf_counter()
    domain = mesh.create_rectangle(MPI.COMM_WORLD, [[0, 0], [WIDTH, HEIGHT]],
                                   [columns, columns * 3 // 4], mesh.CellType.triangle,
                                   diagonal=mesh.DiagonalType.right)
    space = fem.VectorFunctionSpace(domain, ("Lagrange", 1))
    u, w = ufl.TrialFunction(space), ufl.TestFunction(space)
    mu, lame = E / 2 / (1 + NU), E * NU / (1 - NU**2)  # plane stress

    def stress(x):
        return 2 * mu * ufl.sym(ufl.grad(x)) + lame * ufl.div(x) * ufl.Identity(2)

    held = fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(
        space, lambda x: np.isclose(x[0], 0)), space)
    right = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[0], WIDTH))
    tags = mesh.meshtags(domain, 1, np.sort(right), np.ones(len(right), dtype=np.int32))
    ds = ufl.Measure("ds", domain=domain, subdomain_data=tags)
    k_form = THICKNESS * ufl.inner(stress(u), ufl.grad(w)) * ufl.dx
    m_form = THICKNESS * RHO * ufl.inner(u, w) * ufl.dx
    pull = fem.petsc.assemble_vector(fem.form(PULL * w[0] * ds(1)))
    held_dofs = held.dof_indices()[0]
    k = fem.petsc.assemble_matrix(fem.form(k_form))
    k.assemble()
    m = fem.petsc.assemble_matrix(fem.form(m_form))
    m.assemble()
    place, velocity, work = k.createVecRight(), k.createVecRight(), k.createVecRight()
    rhs, acceleration = k.createVecRight(), k.createVecRight()

    def free(x):
        x.array[held_dofs] = 0

    if method == "implicit":
        a = m.copy()
        a.axpy(h * h / 4, k)
        a.zeroRowsColumns(held_dofs, 1)
        ksp = PETSc.KSP().create(domain.comm)
        ksp.setOperators(a)
        ksp.setType("preonly")
        ksp.getPC().setType("cholesky")
        ksp.getPC().setFactorSolverType("mumps")
        ksp.setUp()
        first = m.copy()
        first.zeroRowsColumns(held_dofs, 1)
        begin = PETSc.KSP().create(domain.comm)
        begin.setOperators(first)
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
        m.mult(one, inverse)
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

    set_up = time.perf_counter() - start
    start = time.perf_counter()
    for _ in range(n_steps):
        step()
    stepping = time.perf_counter() - start
    x = space.tabulate_dof_coordinates()
    corner = int(np.argmin(np.hypot(x[:, 0] - WIDTH, x[:, 1] - HEIGHT)))
    print(json.dumps({"set_up_s": set_up, "step_ms": 1e3 * stepping / n_steps,
                      "corner": [float(place.array[2 * corner + i]) for i in range(2)],
                      "triangles": domain.topology.index_map(2).size_global,
                      "version": dolfinx.__version__}))


def run(command):
    outcome = subprocess.run(command, capture_output=True, text=True, check=False)
    if outcome.returncode != 0:
        sys.exit(f"peers.py: {' '.join(map(str, command))}\n{outcome.stderr}")
    return outcome.stdout


def ours(stylet, folder, method, columns):
    h, n_steps = steps_of(method, columns)
    def timed(n):
        overrides = [
            "supports={left: fixed}", "expect=[]", "output={history: false}",
            f"mesh={{rectangle: {{size: [8 cm, 6 cm], columns: {columns}, rows: {columns * 3 // 4}, "
            "diagonals: one_way}}",
            f"time={{method: {method}, step: {h!r} s, duration: {n * h!r} s"
            + (", scheme: average_acceleration}" if method == "implicit" else "}"),
        ]
        command = [stylet, "run", ROOT / "input/block.yaml", "--output", folder, "--force", "--quiet"]
        for override in overrides:
            command += ["--set", override]
        run(command)
        summary = json.loads((folder / "summary.json").read_text())
        if summary["sub_steps"] != n:
            sys.exit(f"peers.py: {summary['sub_steps']} steps instead of {n}")
        return summary
    # The factor is made in the first steps: two runs tell it from the rest.
    few = timed(n_steps // 4)
    all_ = timed(n_steps)
    step = ((all_["wall_times"]["stepping"] - few["wall_times"]["stepping"])
            / (n_steps - n_steps // 4))
    wall = all_["wall_times"]
    return {"set_up_s": wall["set_up"] + wall["stepping"] - n_steps * step, "step_ms": 1e3 * step,
            "corner": all_["probes"]["corner"], "triangles": all_["n_triangles"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stylet")
    parser.add_argument("output", type=Path)
    parser.add_argument("--columns", type=int, nargs="+", default=[24, 96, 384])
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--peer", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.peer:
        peer(arguments.peer[0], int(arguments.peer[1]))
        return
    arguments.output.mkdir(parents=True, exist_ok=True)
    rows = []
    print(f"{'method':9} {'triangles':>9} {'program':8} {'set-up, s':>9} {'step, ms':>9}  corner, mm")
    for method in ("implicit", "explicit"):
        for columns in arguments.columns:
            best = {}
            for _ in range(arguments.repeats):
                turns = {
                    "dolfinx": lambda m=method, c=columns: json.loads(
                        run(["/usr/bin/python3", "-B", __file__, "-", arguments.output, "--peer", m,
                             str(c)])),
                    "stylet": lambda m=method, c=columns: ours(
                        arguments.stylet, arguments.output / "run", m, c),
                }
                for program, turn in turns.items():
                    found = turn()
                    if program in best:
                        for key in ("set_up_s", "step_ms"):
                            found[key] = min(found[key], best[program][key])
                    best[program] = found
            size = math.hypot(*best["dolfinx"]["corner"])
            apart = math.dist(best["dolfinx"]["corner"], best["stylet"]["corner"]) / size
            for program, found in best.items():
                rows.append({"method": method, "program": program, "apart": apart, **{
                    key: found[key] for key in ("triangles", "set_up_s", "step_ms")}})
                print(f"{method:9} {found['triangles']:9} {program:8} {found['set_up_s']:9.2f} "
                      f"{found['step_ms']:9.4f}  {1e3 * found['corner'][0]:.9f} "
                      f"{1e3 * found['corner'][1]:.9f}", flush=True)
            print(f"  corners {apart:.1e} apart; step {best['dolfinx']['step_ms'] / best['stylet']['step_ms']:.2f} "
                  f"times as fast, set-up {best['dolfinx']['set_up_s'] / best['stylet']['set_up_s']:.1f}")
            if apart > 1e-6:
                sys.exit("peers.py: the programs do not solve the same problem")
    with open(arguments.output / "peers.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    print(f"{arguments.output / 'peers.csv'}; with the needle moving: jobs/bench.sh")


if __name__ == "__main__":
    main()
