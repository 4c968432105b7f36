#!/usr/bin/python3
"""Checks the snapshots of an output folder: arrays, shapes, references, and that ParaView opens them.

The ParaView part is skipped if there is no pvpython. Exit code 0, or 1 with what is wrong.
"""

import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

FIELDS = {"u": 3, "v": 3, "von_mises": 1, "node_state": 1, "region": 1}  # name: components
REFERENCE = re.compile(r'Dimensions="([\d ]+)"[^>]*>snapshots\.h5:([^<]+)<')

# Runs inside pvpython: what ParaView's default reader sees.
PARAVIEW = """
import json, sys
from paraview.simple import OpenDataFile, WarpByVector
def bounds(source, t):
    source.UpdatePipeline(t)
    return list(source.GetDataInformation().DataInformation.GetBounds())
def names(arrays):
    return [arrays.GetArray(i).Name for i in range(arrays.GetNumberOfArrays())]
tissue = OpenDataFile(sys.argv[1] + "/snapshots.xdmf")
tissue.UpdatePipeline()
times = tissue.TimestepValues
times = list(times) if hasattr(times, "__len__") else [times]
tissue.UpdatePipeline(times[0])  # without a time nothing is read
warp = WarpByVector(Input=tissue, Vectors=["POINTS", "u"])
seen = {"times": times, "nodes": names(tissue.PointData), "cells": names(tissue.CellData),
        "n_points": tissue.GetDataInformation().GetNumberOfPoints(),
        "n_cells": tissue.GetDataInformation().GetNumberOfCells(),
        "warped": [bounds(warp, t) for t in times]}
if sys.argv[2] == "1":
    needle = OpenDataFile(sys.argv[1] + "/snapshots_needle.xdmf")
    needle.UpdatePipeline()
    seen["needle_times"] = len(needle.TimestepValues)
with open(sys.argv[3], "w") as file:
    json.dump(seen, file)
"""

problems = []


def expect(condition, message):
    if not condition:
        problems.append(message)


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def steps_of(file):
    return [file[name] for name in sorted(file) if name.startswith("step_")]


def check_arrays(file):
    expect({"program", "version", "format"} <= set(file.attrs), "program, version or format missing")
    before = -np.inf
    for index, step in enumerate(steps_of(file)):
        name = step.name
        expect({"time", "phase", "index", "mesh"} <= set(step.attrs), f"{name}: attribute missing")
        expect(step.attrs["index"] == index, f"{name}: index is {step.attrs['index']}")
        expect(step.attrs["time"] > before, f"{name}: time does not increase")
        before = step.attrs["time"]
        mesh = file[text(step.attrs["mesh"])]
        n_nodes, n_cells = len(mesh["coordinates"]), len(mesh["connectivity"])
        for field, components in FIELDS.items():
            if field not in step:
                problems.append(f"{name}: {field} is missing")
                continue
            shape = step[field].shape
            columns = shape[1] if len(shape) == 2 else 1
            expect(shape[0] in (n_nodes, n_cells) and columns == components,
                   f"{name}/{field}: shape {shape}")
            expect(np.isfinite(step[field][:]).all(), f"{name}/{field}: not finite")
        step.visititems(lambda path, item: expect(
            not isinstance(item, h5py.Dataset) or "unit" in item.attrs, f"{name}/{path}: no unit"))


def check_meshes(file):
    """Every mesh is used, in the order of the steps, and differs from the one before."""
    used = []
    for step in steps_of(file):
        mesh = text(step.attrs["mesh"])
        if not used or used[-1] != mesh:
            used.append(mesh)
    meshes = sorted(name for name in file if name.startswith("mesh_"))
    expect(used == meshes, f"meshes {meshes} are used as {used}")
    for old, new in zip(meshes, meshes[1:]):
        expect(file[old].attrs["mesh_version"] != file[new].attrs["mesh_version"],
               f"{new}: stored again although its version did not change")
    for name in meshes:
        connectivity = file[name]["connectivity"][:]
        expect(0 <= connectivity.min() and connectivity.max() < len(file[name]["coordinates"]),
               f"{name}: connectivity names nodes that do not exist")


def check_references(folder, file):
    for name in ("snapshots.xdmf", "snapshots_needle.xdmf"):
        for extent, path in REFERENCE.findall((folder / name).read_text()):
            if path not in file:
                problems.append(f"{name}: {path} does not exist")
                continue
            shape = " ".join(map(str, file[path].shape))
            expect(shape == extent, f"{name}: {path} is {shape}, said to be {extent}")
    n_times = (folder / "snapshots.xdmf").read_text().count("<Time ")
    expect(n_times == len(steps_of(file)), f"snapshots.xdmf: {n_times} times")


def check_paraview(folder, file):
    if shutil.which("pvpython") is None:
        print("pvpython is absent: ParaView not checked")
        return
    has_needle = "<Time " in (folder / "snapshots_needle.xdmf").read_text()
    with tempfile.TemporaryDirectory() as scratch:
        script, answer = Path(scratch) / "look.py", Path(scratch) / "seen.json"
        script.write_text(PARAVIEW)
        run = subprocess.run(["pvpython", script, folder, str(int(has_needle)), answer],
                             capture_output=True, text=True, check=False)
        if not answer.exists():
            problems.append(f"pvpython failed with code {run.returncode}: {run.stderr[-300:]}")
            return
        seen = json.loads(answer.read_text())
    steps = steps_of(file)
    expect(np.allclose(seen["times"], [s.attrs["time"] for s in steps]), "ParaView: other times")
    expect({"u", "v", "node_state"} <= set(seen["nodes"]), f"ParaView: node fields {seen['nodes']}")
    expect({"von_mises", "region"} <= set(seen["cells"]), f"ParaView: cell fields {seen['cells']}")
    mesh = file[text(steps[0].attrs["mesh"])]
    expect(seen["n_points"] == len(mesh["coordinates"]), f"ParaView: {seen['n_points']} points")
    expect(seen["n_cells"] == len(mesh["connectivity"]), f"ParaView: {seen['n_cells']} cells")
    for step, warped in zip(steps, seen["warped"]):
        places = file[text(step.attrs["mesh"])]["coordinates"][:]
        dim = places.shape[1]
        points = places + step["u"][:, :dim]
        own = np.ravel(np.column_stack([points.min(axis=0), points.max(axis=0)]))
        # ParaView warps in the precision of the points; 1e-6 of the size is far below a pixel.
        expect(np.allclose(warped[:2 * dim], own, atol=1e-6 * np.ptp(points)),
               f"ParaView: {step.name} moves to {warped[:2 * dim]} instead of {own}")
    if has_needle:
        n = sum(any(len(step.get(kind, {})) for kind in ("polylines", "point_sets")) for step in steps)
        expect(seen["needle_times"] == n, f"ParaView: {seen['needle_times']} needle times, not {n}")


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: check_snapshots.py OUTDIR")
    folder = Path(sys.argv[1])
    with h5py.File(folder / "snapshots.h5", "r") as file:
        expect(steps_of(file), "no snapshots")
        check_arrays(file)
        check_meshes(file)
        check_references(folder, file)
        check_paraview(folder, file)
        print(f"{len(steps_of(file))} snapshots, {len(problems)} problems")
    for problem in problems[:20]:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
