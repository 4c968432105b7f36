#!/usr/bin/python3
"""Fails if a file includes what its room may not include.

usage: check_layers.py SOURCE_FOLDER
"""
import pathlib
import re
import sys

# Rooms on lower floors may be included, rooms beside or above may not.
FLOORS = {"base": 0, "petsc": 1, "geometry": 1, "mesh": 2, "fem": 3, "solvers": 4, "dynamics": 5,
          "needle": 5, "scene": 6, "image": 6, "output": 6, "simulation": 7, "study": 8, "view": 8,
          "app": 9}

# Rooms that may include less than their floor allows: names of rooms or of single headers.
ONLY = {
    "mesh": {"geometry", "base"},  # no PETSc
    "needle": {"mesh", "geometry", "base", "solvers/track_operator.hpp"},
    "scene": {"geometry", "base", "mesh/parameters.hpp", "fem/parameters.hpp",
              "dynamics/parameters.hpp", "needle/parameters.hpp"},
    "image": {"geometry", "base"},
    "output": {"mesh", "petsc", "geometry", "base"},
}

# Who may include a library: rooms or single files.
LIBRARIES = {
    r"yaml-cpp/": {"scene"},
    r"(hdf5|H5\w+|hdf5_hl)\.h": {"output"},
    r"petsc/private/": {"dynamics/central_difference_ts.cpp", "dynamics/state_products.cpp"},
    r"petsc\w*\.h": {"petsc", "fem", "solvers", "dynamics", "output", "simulation",
                      "study", "app"},
    r"slepc\w*\.h": {"petsc", "solvers"},
    r"metis\.h": {"mesh"},
    r"mpi\.h": {"petsc", "fem", "solvers", "dynamics", "output", "simulation",
                      "study", "view", "app"},
    r"(png|turbojpeg)\.h": {"image"},
    r"CLI/": {"app"},
    r"nlohmann/": {"output", "simulation", "study", "view", "app"},
    r"udunits2\.h": {"base"},
    r"(imgui|backends/imgui\w*)\.h": {"view"},
    r"GLFW/": {"view/window.cpp"},
    r"epoxy/egl\.h": {"view/offscreen.cpp"},
    r"epoxy/": {"view"},
}

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


def allowed_header(room, header):
    other = header.split("/")[0]
    if other == room:
        return True
    if room in ONLY:
        return other in ONLY[room] or header in ONLY[room]
    return FLOORS[other] < FLOORS[room]


def breaches_of(room, name, text):
    """What is wrong with a file `name` (without folder) of a room."""
    found = []
    for include in INCLUDE.findall(text):
        if include.startswith("stylet/"):
            header = include.removeprefix("stylet/")
            if header.split("/")[0] not in FLOORS:
                found.append(f"{room}/{name}: includes {include}, of an unknown room")
            elif not allowed_header(room, header):
                found.append(f"{room}/{name}: may not include {include}")
            continue
        for library, users in LIBRARIES.items():
            if re.match(library, include) and room not in users and f"{room}/{name}" not in users:
                found.append(f"{room}/{name}: may not include {include}, only {sorted(users)}")
            if re.match(library, include):
                break
    return found


def main():
    root = pathlib.Path(sys.argv[1])
    breaches = []
    files = 0
    for top in (root / "include" / "stylet", root / "src"):
        for path in sorted(top.rglob("*.?pp")):
            room = path.relative_to(top).parts[0]
            if room not in FLOORS:
                breaches.append(f"{path.relative_to(root)}: unknown room '{room}'")
                continue
            breaches += breaches_of(room, path.name, path.read_text(encoding="utf-8"))
            files += 1
    if files < 50:
        breaches.append(f"only {files} files found: is {root} the source folder?")
    if breaches:
        sys.exit("\n".join(breaches))


if __name__ == "__main__":
    main()
