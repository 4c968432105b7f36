#!/usr/bin/python3
"""Writes an unstructured mesh of a cylinder in millimetres: radius 40, height 60, along z.

usage: make_can.py FILE [SIZE [DEPTH]]

Surfaces bottom, side and top; region tissue, and region deep below that depth, with faces of tetrahedra
between them. 1648 tetrahedra of the default size, 10 mm.
"""
import sys

import gmsh


def main():
    size = float(sys.argv[2]) if len(sys.argv) > 2 else 10
    height = 60
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    gmsh.option.setNumber("Mesh.MeshSizeMin", size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    ends = [0, height] if len(sys.argv) < 4 else [0, height - float(sys.argv[3]), height]
    parts = [(3, gmsh.model.occ.addCylinder(0, 0, low, 0, 0, high - low, 40))
             for low, high in zip(ends, ends[1:])]
    if len(parts) > 1:
        gmsh.model.occ.fragment(parts[:1], parts[1:])  # one surface between them
    gmsh.model.occ.synchronize()
    flat = {round(z): None for z in ends} | {0: "bottom", height: "top"}
    surfaces = {"bottom": [], "side": [], "top": []}
    for _, surface in gmsh.model.getEntities(2):
        name = flat.get(round(gmsh.model.occ.getCenterOfMass(2, surface)[2]), "side")
        if name:
            surfaces[name].append(surface)
    for name, tags in surfaces.items():
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, tags), name)
    for _, part in gmsh.model.getEntities(3):
        z = gmsh.model.occ.getCenterOfMass(3, part)[2]
        name = "tissue" if z > ends[-2] else "deep"
        gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, [part]), name)
    gmsh.model.mesh.generate(3)
    gmsh.write(sys.argv[1])
    gmsh.finalize()


if __name__ == "__main__":
    main()
