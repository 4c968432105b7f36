"""Whether two runs have left the same: history bit for bit, snapshots as they are read, summary but for
times."""

import csv
import json

import h5py
import numpy as np


def snapshots_of(path):
    """Name -> array or attributes, of everything in snapshots.h5."""
    found = {}

    def visit(name, item):
        for key, value in item.attrs.items():
            found[f"{name}@{key}"] = value
        if isinstance(item, h5py.Dataset):
            found[name] = item[()]

    with h5py.File(path) as file:
        for name in sorted(file):
            file[name].visititems(lambda inner, item, group=name: visit(f"{group}/{inner}", item))
            visit(name, file[name])
    return found


def summary_of(folder):
    summary = json.loads((folder / "summary.json").read_text())
    summary.pop("wall_times", None)
    return summary


def differences(one, other):
    """What is not the same in two folders, in words."""
    found = []
    if (one / "history.csv").read_bytes() != (other / "history.csv").read_bytes():
        a = (one / "history.csv").read_text().splitlines()
        b = (other / "history.csv").read_text().splitlines()
        at = next((i for i, (x, y) in enumerate(zip(a, b)) if x != y), min(len(a), len(b)))
        found.append(f"history.csv from row {at} on, of {len(a)} and {len(b)}")
    if (one / "snapshots.h5").exists() or (other / "snapshots.h5").exists():
        a, b = snapshots_of(one / "snapshots.h5"), snapshots_of(other / "snapshots.h5")
        if a.keys() != b.keys():
            found.append(f"snapshots.h5: {sorted(a.keys() ^ b.keys())[:5]}")
        found += [f"snapshots.h5: {key}" for key in a.keys() & b.keys()
                  if not np.array_equal(a[key], b[key])][:5]
        for name in ("snapshots.xdmf", "snapshots_needle.xdmf"):
            if (one / name).read_bytes() != (other / name).read_bytes():
                found.append(name)
    a, b = summary_of(one), summary_of(other)
    found += [f"summary.json: {key}: {a.get(key)} and {b.get(key)}"
              for key in sorted(a.keys() | b.keys()) if a.get(key) != b.get(key)]
    return found


def history_of(folder):
    """Titles and numbers."""
    with open(folder / "history.csv", newline="") as file:
        rows = list(csv.reader(file))
    return rows[0], np.array([[float(x) for x in row] for row in rows[1:]])


def largest_deviation(one, other):
    """Of any column of the history, relative to the largest number in it."""
    (titles, a), (_, b) = history_of(one), history_of(other)
    assert a.shape == b.shape, (a.shape, b.shape)
    size = np.maximum(np.abs(a).max(axis=0), 1e-300)
    known = np.array([not t.startswith(("balance_error", "solves", "iterations")) for t in titles])
    return float((np.abs(a - b).max(axis=0) / size)[known].max())
