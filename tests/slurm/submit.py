#!/usr/bin/python3
"""Submits the scripts of jobs/slurm to a cluster of one node and checks what they leave.

Starts munged, slurmctld and slurmd with files in a folder of its own; exit code 77 (skipped) where they
are not installed or do not come up.
"""

import csv
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

SOURCE = pathlib.Path(os.environ["STYLET_SOURCE"])
sys.path[:0] = [str(SOURCE / "tests/cli"), str(SOURCE / "tests/faults")]
from compare import largest_deviation  # noqa: E402
from stylet_cli import AS_ROOT, NEEDLE_SCENE  # noqa: E402

SKIPPED = 77
PATIENCE = 120  # s for a job; it takes seconds on an idle machine
CAMPAIGN = """\
scene: scene.yaml
set: [time.until=implanted, output.snapshots=null, "time.step=20 ms"]
design: grid
vary:
  cutting_force: {key: needles.0.cutting.cutting_force, from: 1 N, to: 2 N, count: 6}
outputs: [seeds.0.placement_error, peak_needle_force]
"""


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Cluster:
    """One node named as this host; everything it writes is in `folder`."""

    def __init__(self, folder):
        self.folder = folder
        self.daemons = []
        for name in ("state", "spool", "run"):
            (folder / name).mkdir()
        key = folder / "munge.key"
        key.write_bytes(os.urandom(64))
        key.chmod(0o600)
        self.socket = folder / "run/munge.socket"
        host = socket.gethostname().split(".")[0]
        (folder / "slurm.conf").write_text(f"""\
ClusterName=stylet
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={self.socket}
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/run/slurmctld.pid
SlurmdPidFile={folder}/run/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
ReturnToService=2
SchedulerParameters=sched_interval=1,batch_sched_delay=1
SlurmdParameters=config_overrides
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")
        (folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")
        self.environment = os.environ | {
            "SLURM_CONF": str(folder / "slurm.conf"), "STYLET": os.environ["STYLET"],
            "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
            "OMPI_MCA_hwloc_base_binding_policy": "none"} | AS_ROOT

    def start(self):
        self.spawn("munged", "--foreground", "--force", f"--key-file={self.folder}/munge.key",
                   f"--socket={self.socket}", f"--pid-file={self.folder}/run/munge.pid",
                   f"--log-file={self.folder}/munge.log", f"--seed-file={self.folder}/munge.seed")
        self.wait_for(self.socket.exists, "munged")
        self.spawn("slurmctld", "-D")
        self.spawn("slurmd", "-D")
        self.wait_for(lambda: "idle" in self.call("sinfo", "--noheader", "--format=%T"), "the node")

    def spawn(self, *command):
        log = open(self.folder / f"{command[0]}.out", "wb")
        self.daemons.append(subprocess.Popen(command, env=self.environment, stdout=log, stderr=log))

    def call(self, *command, check=False):
        done = subprocess.run(command, cwd=self.folder, env=self.environment, text=True, timeout=60,
                              capture_output=True)
        if check and done.returncode != 0:
            sys.exit(f"{' '.join(map(str, command))}: {done.stderr}")
        return done.stdout.strip()

    def wait_for(self, happened, what, give_up=skip, seconds=30):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if happened():
                return
            time.sleep(0.2)
        logs = "\n".join(f"{p.name}: {p.read_text(errors='replace')[-600:]}"
                         for p in sorted(self.folder.glob("*.log")) + sorted(self.folder.glob("*.out")))
        give_up(f"{what} did not come up here\n{logs}")

    def submit(self, script, *arguments, options=()):
        return self.call("sbatch", "--parsable", *options, SOURCE / "jobs/slurm" / script, *arguments,
                         check=True)

    def next_turn(self, job):
        """Of a job that is requeued; not in two minutes, as Slurm would have it."""
        def is_pending():
            return "PENDING" in self.call("squeue", "--noheader", "--format=%T", "--jobs", job)

        self.wait_for(is_pending, "the requeued job", sys.exit, PATIENCE)
        time.sleep(2)  # a node takes no job back in the second in which it was revoked
        self.call("scontrol", "update", f"JobId={job}", "StartTime=now")

    def finish(self, *jobs):
        """Waits until all of them have ended, in whatever way."""
        going = {"PENDING", "RUNNING", "COMPLETING", "CONFIGURING", "REQUEUED", "SUSPENDED"}
        end = time.monotonic() + PATIENCE
        settled = 0  # a job that requeues itself has failed for a moment
        while time.monotonic() < end:
            states = self.call("squeue", "--noheader", "--states=all", "--format=%T", "--jobs",
                               ",".join(jobs)).split()
            settled = settled + 1 if states and not going.intersection(states) else 0
            if settled == 10:
                return
            time.sleep(0.2)
        sys.exit(f"jobs {jobs} do not end: {self.call('squeue', '--long')}\n{self.logs()}")

    def logs(self):
        return "\n".join(f"{p.name}:\n{p.read_text(errors='replace')}"
                         for p in sorted(self.folder.glob("stylet-*.log")))

    def stop(self):
        for daemon in reversed(self.daemons):
            daemon.send_signal(signal.SIGTERM)
        for daemon in self.daemons:
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()


def results(folder):
    """Rows without times and fingerprints of rows with them; none if there is no table."""
    if not (folder / "results.csv").exists():
        return []
    with open(folder / "results.csv", newline="") as file:
        return [{k: v for k, v in row.items() if not k.startswith(("wall_time", "fingerprint"))}
                for row in csv.DictReader(file)]


def alike(rows, others):
    """Texts the same, numbers but for the round-off of a checkpoint that only one of them has made."""
    def is_close(a, b):
        try:
            return a == b or abs(float(a) - float(b)) < 1e-9 * abs(float(a))
        except ValueError:
            return False

    return len(rows) == len(others) and all(
        row.keys() == other.keys() and all(is_close(row[key], other[key]) for key in row)
        for row, other in zip(rows, others))


def check(cluster):
    folder = cluster.folder
    (folder / "scene.yaml").write_text(NEEDLE_SCENE)
    (folder / "campaign.yaml").write_text(CAMPAIGN)
    cluster.call(os.environ["STYLET"], "sweep", "campaign.yaml", "--output", "plain", "--no-picture",
                 check=True)
    plain = results(folder / "plain")
    assert len(plain) == 6 and {row["status"] for row in plain} == {"done"}, plain

    # In two turns: it writes its state when its time is about to be over, and goes on from there.
    changes = ["--set", "time.until=implanted", "--set", "time.step=1 ms"]
    cluster.call(os.environ["STYLET"], "run", "scene.yaml", "--output", "whole", *changes, check=True)
    job = cluster.submit("run.sbatch", "scene.yaml", "fine", *changes)
    cluster.wait_for((folder / "fine/history.csv").exists, "the run", sys.exit, PATIENCE)
    cluster.call("scancel", "--batch", "--signal=USR1", job, check=True)
    cluster.next_turn(job)
    assert list((folder / "fine/checkpoints").iterdir()), cluster.logs()
    cluster.finish(job)
    assert '"status": "completed"' in (folder / "fine/summary.json").read_text(), cluster.logs()
    assert "going on at t = " in cluster.logs(), cluster.logs()
    assert largest_deviation(folder / "whole", folder / "fine") < 1e-10, cluster.logs()

    pool = cluster.submit("campaign_pool.sbatch", "campaign.yaml", "pool", "--no-picture")
    table = folder / "pool/results.csv"
    while not (table.exists() and len(table.read_text().splitlines()) > 1):
        if not cluster.call("squeue", "--noheader", "--jobs", pool):
            break
        time.sleep(0.02)
    cluster.call("scontrol", "requeue", pool)
    cluster.next_turn(pool)
    cluster.finish(pool)
    assert alike(results(folder / "pool"), plain), cluster.logs()

    array = cluster.submit("campaign_array.sbatch", "campaign.yaml", "array", "--no-picture",
                           options=["--array=1-3"])
    join = cluster.submit("campaign_pool.sbatch", "campaign.yaml", "array", "--join", "--no-picture",
                          options=[f"--dependency=afterany:{array}"])
    cluster.finish(array, join)
    assert results(folder / "array") == plain, cluster.logs()
    for part in (1, 2, 3):
        assert len(results(folder / f"array/part-{part}")) == 2, cluster.logs()
    assert "6 of them kept" in cluster.logs(), cluster.logs()
    print(cluster.logs())


def main():
    missing = [p for p in ("munged", "slurmctld", "slurmd", "sbatch", "mpirun") if not shutil.which(p)]
    if missing:
        skip(f"{', '.join(missing)} not installed (jobs/install.sh --slurm)")
    if os.geteuid() != 0:
        skip("the daemons need root")
    with tempfile.TemporaryDirectory(prefix="stylet_slurm_") as name:
        cluster = Cluster(pathlib.Path(name))
        try:
            cluster.start()
            check(cluster)
        finally:
            cluster.stop()


if __name__ == "__main__":
    main()
