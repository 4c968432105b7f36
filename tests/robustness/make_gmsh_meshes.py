#!/usr/bin/python3
"""Makes the unstructured meshes of the robustness runs with the gmsh command, if there is one.

usage: make_gmsh_meshes.py FOLDER
"""
import pathlib
import shutil
import subprocess
import sys

# name, edge outside, edge at the outline (m), algorithm of gmsh, shape inside, stiffness contrast
MESHES = [
    ("coarse", 0.0055, 0.0055, 6, "ellipse", 1),
    ("meshadapt", 0.0040, 0.0040, 1, "ellipse", 10),
    ("delaunay", 0.0026, 0.0026, 5, "ellipse", 5),
    ("graded", 0.0060, 0.0008, 6, "ellipse", 10),
    ("coarse_inside", 0.0012, 0.0050, 5, "bone", 20),
    ("bone", 0.0020, 0.0020, 6, "bone", 20),
    ("fine", 0.00075, 0.00075, 6, "ellipse", 10),
]

OUTER = """
Point(1) = {{0, 0, 0, {outside}}};
Point(2) = {{0.08, 0, 0, {outside}}};
Point(3) = {{0.08, 0.06, 0, {outside}}};
Point(4) = {{0, 0.06, 0, {outside}}};
Line(1) = {{1, 2}}; Line(2) = {{2, 3}}; Line(3) = {{3, 4}}; Line(4) = {{4, 1}};
Curve Loop(1) = {{1, 2, 3, 4}};
"""
SHAPES = {
    "ellipse": """
Point(5) = {{0.035, 0.03, 0, {inside}}};
Point(6) = {{0.0525, 0.03, 0, {inside}}};
Point(7) = {{0.035, 0.043, 0, {inside}}};
Point(8) = {{0.0175, 0.03, 0, {inside}}};
Point(9) = {{0.035, 0.017, 0, {inside}}};
Ellipse(5) = {{6, 5, 6, 7}}; Ellipse(6) = {{7, 5, 6, 8}};
Ellipse(7) = {{8, 5, 6, 9}}; Ellipse(8) = {{9, 5, 6, 6}};
Curve Loop(2) = {{5, 6, 7, 8}};
""",
    "bone": """
Point(5) = {{0.012, 0.012, 0, {inside}}};
Point(6) = {{0.03, 0.008, 0, {inside}}};
Point(7) = {{0.048, 0.02, 0, {inside}}};
Point(8) = {{0.04, 0.042, 0, {inside}}};
Line(5) = {{5, 6}}; Line(6) = {{6, 7}}; Line(7) = {{7, 8}}; Line(8) = {{8, 5}};
Curve Loop(2) = {{5, 6, 7, 8}};
""",
}
NAMES = """
Plane Surface(1) = {2};
Plane Surface(2) = {1, 2};
Physical Surface("inner") = {1};
Physical Surface("tissue") = {2};
Physical Curve("bottom") = {1};
Physical Curve("right") = {2};
Physical Curve("top") = {3};
Physical Curve("left") = {4};
"""


def main():
    gmsh = shutil.which("gmsh")
    if gmsh is None:
        print("no gmsh command: the unstructured meshes are left out")
        return
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name, outside, inside, algorithm, shape, contrast in MESHES:
        geo = folder / f"{name}.geo"
        geo.write_text((OUTER + SHAPES[shape]).format(outside=outside, inside=inside) + NAMES)
        subprocess.run(
            [gmsh, "-2", "-format", "msh41", "-algo", {1: "meshadapt", 5: "del2d", 6: "front2d"}[algorithm],
             "-v", "1", str(geo), "-o", str(folder / f"{name}.msh")], check=True)
        (folder / f"{name}.regions").write_text(f"{max(outside, inside)} {contrast} tissue inner\n")


if __name__ == "__main__":
    main()
