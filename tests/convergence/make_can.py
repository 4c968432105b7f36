#!/usr/bin/python3
"""Writes an unstructured mesh of a cylinder in millimetres: radius 40, height 60, along z.

usage: make_can.py FILE [SIZE]

Surfaces bottom, side and top; region tissue. 1648 tetrahedra of the default size, 10 mm.
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
    body = gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, height, 40)
    gmsh.model.occ.synchronize()
    for _, surface in gmsh.model.getEntities(2):
        z = gmsh.model.occ.getCenterOfMass(2, surface)[2]
        name = {0: "bottom", height: "top"}.get(round(z), "side")
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, [surface]), name)
    gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, [body]), "tissue")
    gmsh.model.mesh.generate(3)
    gmsh.write(sys.argv[1])
    gmsh.finalize()


if __name__ == "__main__":
    main()
