"""What the tests of faults share: a short scene, and runs that are brought to an end in the middle."""

import csv
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from xml.etree import ElementTree

import h5py

sys.path.insert(0, str(Path(__file__).parent.parent / "cli"))
from compare import differences  # noqa: E402
from stylet_cli import (AS_ROOT, BAD_INPUT, DONE, IO, NEEDLE_SCENE, NUMERICAL, OTHER,  # noqa: E402, F401
                        PROGRAM, CliTest, call, on_ranks, own_lines)

SOON = 10  # s within which every fault ends a run, on an idle machine
PATIENCE = 120  # s after which it counts as hanging, on any
# Sixty steps, with all that a needle does, and a checkpoint and some snapshots every few of them.
SHORT = ["--set", "time.step=20 ms", "--set", "needles.0.motion.0.depth=1 cm",
         "--set", "needles.0.motion.3.duration=0.1 s", "--set", "output.checkpoint.steps=7",
         "--set", "output.snapshots=60 ms"]
LONG = ["--set", "time.step=0.1 ms", "--set", "output.checkpoint.steps=50"]  # minutes
METHODS = {
    "implicit": [],
    "average_acceleration": ["--set", "time.scheme=average_acceleration"],
    "generalised_alpha": ["--set", "time.scheme=generalised_alpha"],
    "quasi_static": ["--set", "time.method=quasi_static"],
    "explicit": ["--set", "time.method=explicit", "--set", "tissue.damping.stiffness_factor=null",
                 "--set", "tissue.damping.mass_factor=50 1/s"],
}


def command(n, *arguments):
    run = [PROGRAM, *map(str, arguments)]
    return run if n == 1 else [os.environ["STYLET_MPIEXEC"], "--oversubscribe", "-n", str(n), *run]


def ranks_of(launcher):
    """Process numbers of the program under mpirun."""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/stat") as file:
                parent = int(file.read().rsplit(")", 1)[1].split()[1])
            if parent == launcher and os.readlink(f"/proc/{pid}/exe") == os.path.realpath(PROGRAM):
                found.append(int(pid))
        except OSError:
            pass
    return sorted(found)


def shim():
    """The library of shim.c, made for the tests of this process."""
    if not hasattr(shim, "path"):
        folder = tempfile.TemporaryDirectory(prefix="stylet_shim_")
        shim.holder, shim.path = folder, f"{folder.name}/shim.so"
        subprocess.run(["cc", "-O1", "-shared", "-fPIC", Path(__file__).parent / "shim.c", "-o", shim.path,
                        "-ldl"], check=True)
    return shim.path


def faults(**asked):
    """Environment of a program that meets faults: faults(on="history.csv", full=1000)."""
    return {"LD_PRELOAD": shim()} | {f"FAULT_{k.upper()}": str(v) for k, v in asked.items()}


class FaultTest(CliTest):
    holder = tempfile.TemporaryDirectory(prefix="stylet_whole_")

    def setUp(self):
        super().setUp()
        self.write("scene.yaml", NEEDLE_SCENE)

    def run_short(self, n, name, *arguments, faulty=None):
        """The short scene on n ranks into a folder; the shim is the program's, not mpirun's."""
        program = ["env", *(f"{k}={v}" for k, v in (faulty or {}).items()),
                   *command(1, "run", "scene.yaml", "--output", name, *SHORT, *arguments)]
        if n > 1:
            program = [*command(n)[:-1], *program]
        start = time.monotonic()
        outcome = call(program, self.folder, env=os.environ | AS_ROOT)
        outcome.seconds = time.monotonic() - start
        return outcome

    def whole(self, n):
        """The folder of the short scene on n ranks, which nothing interrupted; made once."""
        folder = Path(FaultTest.holder.name) / f"whole{n}"
        if not folder.exists():
            self.assert_code(self.run_short(n, folder, "--quiet"), DONE)
        return folder

    def status(self, name):
        summary = json.loads((self.folder / name / "summary.json").read_text())
        return summary["status"], summary.get("error", "")

    def assert_readable(self, name):
        """Whatever is there can be read, whole but for a last row of the history."""
        folder = self.folder / name
        if (folder / "history.csv").exists():
            with open(folder / "history.csv", newline="") as file:
                rows = list(csv.reader(file))
            self.assertTrue(all(len(row) == len(rows[0]) for row in rows[:-1]))
        if (folder / "snapshots.h5").exists():
            with h5py.File(folder / "snapshots.h5") as file:
                file.visititems(lambda _, item: item[()] if isinstance(item, h5py.Dataset) else None)
        for path in folder.glob("*.xdmf"):
            ElementTree.parse(path)
        if (folder / "summary.json").exists():
            self.status(name)

    def assert_goes_on(self, n, name, *arguments):
        """As if nothing had happened. Returns what the program said."""
        outcome = self.run_short(n, name, "--resume", *arguments)
        self.assert_code(outcome, DONE)
        self.assertEqual(differences(self.whole(n), self.folder / name), [])
        return outcome.out

    def start(self, n, *arguments, faulty=None, **options):
        return self.background(command(n, *arguments), env=os.environ | AS_ROOT | (faulty or {}), text=True,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, **options)

    def wait_for(self, program, happened, patience=120):
        end = time.monotonic() + patience
        while not happened():
            if program.poll() is not None:
                return False
            self.assertLess(time.monotonic(), end, "has not happened")
            time.sleep(0.002)
        return True

    def send(self, program, sent):
        """To all of it at once."""
        for pid in [*ranks_of(program.pid), program.pid]:
            try:
                os.kill(pid, sent)
            except ProcessLookupError:
                pass

    def kill(self, program):
        """As a machine that goes down."""
        self.send(program, signal.SIGKILL)
        program.communicate()
