#!/usr/bin/python3
"""Writes unstructured meshes of the element benchmarks.

usage: make_benchmark_meshes.py FOLDER [LEVELS]

square_1.msh, square_2.msh ...: the unit square with the curve `line` from (0.5, 0.5) to (1, 0.5);
cook_1.msh ...: Cook's membrane. Level k has about as many triangles as 2 (8 x 2^k)^2.
"""
import pathlib
import sys

import gmsh


def square(size):
    at = gmsh.model.geo.addPoint
    corners = [at(0, 0, 0, size), at(1, 0, 0, size), at(1, .5, 0, size), at(1, 1, 0, size),
               at(0, 1, 0, size)]
    lines = [gmsh.model.geo.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1])]
    inner = gmsh.model.geo.addLine(at(.5, .5, 0, size), corners[2])
    surface = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(lines)])
    gmsh.model.geo.synchronize()
    gmsh.model.mesh.embed(1, [inner], 2, surface)
    return surface, {"bottom": lines[:1], "right": lines[1:3], "top": lines[3:4],
                     "left": lines[4:], "line": [inner]}


def cook(size):
    at = gmsh.model.geo.addPoint
    corners = [at(0, 0, 0, size), at(48, 44, 0, size), at(48, 60, 0, size), at(0, 44, 0, size)]
    lines = [gmsh.model.geo.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1])]
    surface = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(lines)])
    gmsh.model.geo.synchronize()
    return surface, {"bottom": lines[:1], "right": lines[1:2], "top": lines[2:3], "left": lines[3:]}


def main():
    folder = pathlib.Path(sys.argv[1])
    levels = int(sys.argv[2]) if len(sys.argv) > 2 else 3
    folder.mkdir(parents=True, exist_ok=True)
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    for level in range(1, levels + 1):
        n = 8 * 2**level
        # An equilateral triangle has 0.43 of its side squared.
        for name, make, size in (("square", square, 1.075 / n), ("cook", cook, 1.075 * 38 / n)):
            gmsh.clear()
            surface, curves = make(size)
            for curve, lines in curves.items():
                gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, lines), curve)
            gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, [surface]), "tissue")
            gmsh.model.mesh.generate(2)
            gmsh.write(str(folder / f"{name}_{level}.msh"))
    gmsh.finalize()


if __name__ == "__main__":
    main()
