"""What the tests of faults share: a short scene, and runs that are brought to an end in the middle."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "cli"))
from stylet_cli import AS_ROOT, NEEDLE_SCENE, PROGRAM, CliTest, on_ranks, own_lines  # noqa: E402, F401

SOON = 10  # s within which every fault ends a run
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


class FaultTest(CliTest):
    def setUp(self):
        super().setUp()
        self.write("scene.yaml", NEEDLE_SCENE)

    def start(self, n, *arguments, **options):
        return self.background(command(n, *arguments), env=os.environ | AS_ROOT, text=True,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, **options)

    def wait_for(self, program, happened, patience=120):
        end = time.monotonic() + patience
        while not happened():
            if program.poll() is not None:
                return False
            self.assertLess(time.monotonic(), end, "has not happened")
            time.sleep(0.002)
        return True

    def kill(self, program):
        """All of it at once, as a machine that goes down."""
        for pid in [*ranks_of(program.pid), program.pid]:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        program.communicate()
