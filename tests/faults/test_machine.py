"""Faults beside the disk: signals on several ranks, two runs in one folder, another mesh, numbers that are
none, solvers that do not converge, memory that runs out, a clock that is put back."""

import hashlib
import json
import resource
import shutil
import signal
import time
import unittest

import h5py
import numpy as np
from scenes import DONE, NUMERICAL, OTHER, PATIENCE, SHORT, FaultTest, faults, on_ranks, own_lines
from stylet_cli import BLOCK_SCENE, block_mesh

BLOCK = BLOCK_SCENE.replace("  method: quasi_static\n", "  step: 1 ms\n  duration: 40 ms\n") + """\
loads:
  body:
    - force: [0 N/m^3, -9810 N/m^3]
output:
  checkpoint: {steps: 5}
"""


def sealed(path):
    """Gives a checkpoint that was changed the checksum of what is in it now."""
    data = path.read_bytes()
    at = data.rfind(b"\nstylet checkpoint, ")
    seal = b"\nstylet checkpoint, SHA-256 of all before: "
    if at >= 0:
        data = data[:at]
    path.write_bytes(data + seal + hashlib.sha256(data).hexdigest().encode() + b"\n")


class Machine(FaultTest):
    def ended(self, program):
        start = time.monotonic()
        err = own_lines(program.communicate(timeout=PATIENCE)[1])
        print(f"ended with {program.returncode} after {time.monotonic() - start:.1f} s: "
              f"{err.splitlines()[:1]}")
        return program.returncode, err

    def test_scheduler(self):
        """mpirun hands TERM and USR1 on."""
        for n in (1, 2):
            for sent in (signal.SIGTERM, signal.SIGUSR1):
                with self.subTest(ranks=n, signal=sent.name):
                    name = f"{n}{sent.name}"
                    many = ["--set", "time.step=0.1 ms",  # mpirun takes its time
                            "--set", "output.checkpoint.steps=500"]
                    program = self.start(n, "run", "scene.yaml", "--quiet", "--output", name, *SHORT,
                                         *many)
                    self.wait_for(program, (self.folder / name / "checkpoints/00000500.h5").exists)
                    program.send_signal(sent)
                    code, err = self.ended(program)
                    # mpirun hands TERM on, kills what is there a second later, and ends with its own code.
                    own = n > 1 and sent == signal.SIGTERM
                    self.assertEqual(code, OTHER if own else 128 + sent)
                    if not own:
                        self.assertIn("go on with --resume", err)
                    status, error = self.status(name)
                    self.assertEqual(status, "stopped")
                    self.assertIn("signal " + sent.name[3:], error)
                    outcome = self.run_short(n, name, "--resume", *many)
                    self.assert_code(outcome, DONE)
                    self.assertIn("going on at", outcome.out)

    def test_two_runs_in_one_folder(self):
        for n in (1, 2):
            program = self.start(n, "run", "scene.yaml", "--quiet", "--output", "part", *SHORT)
            self.wait_for(program, (self.folder / "part/history.csv").exists)
            self.send(program, signal.SIGSTOP)  # so that it is there as long as it takes
            for way in ([], ["--force"], ["--resume"]):
                self.assert_refused(self.run_short(1, "part", *way), "in use by process", "--output")
            self.send(program, signal.SIGCONT)
            self.assertEqual(self.ended(program)[0], DONE)
            self.assert_goes_on(n, "part")
            shutil.rmtree(self.folder / "part")

    def test_mesh_that_is_replaced(self):
        for n in (1, 2):
            with self.subTest(ranks=n):
                self.write("block.msh", block_mesh(4)[0])
                self.write("block.yaml", BLOCK)
                block = ["run", "block.yaml", "--output", f"block{n}"]
                stopped = on_ranks(n, self.folder, *block, "--until", "20 ms")
                self.assert_code(stopped, DONE)
                other = block_mesh(4)[0].replace(" 0.01 ", " 0.0101 ")
                self.write("block.msh", other)
                self.assert_refused(on_ranks(n, self.folder, *block, "--resume"), "mesh.file",
                                    "put the mesh back", "--force")
                self.write("block.msh", block_mesh(4)[0])
                self.assert_code(on_ranks(n, self.folder, *block, "--resume"), DONE)
                done = self.folder / f"block{n}/summary.json"
                before = json.loads(done.read_text())
                self.assertEqual(before["status"], "completed")
                # What is complete is so of another mesh.
                self.write("block.msh", other)
                self.assert_refused(on_ranks(n, self.folder, *block, "--resume"), "mesh.file")
                self.assertEqual(json.loads(done.read_text()), before)

    def test_mesh_that_is_replaced_in_mid_run(self):
        """It was read at the start, and is so told by its fingerprint."""
        text = block_mesh(4)[0]
        self.write("block.msh", text)
        self.write("block.yaml", BLOCK)
        program = self.start(1, "run", "block.yaml", "--quiet", "--output", "block")
        self.wait_for(program, (self.folder / "block/history.csv").exists)
        self.write("block.msh", "replaced")
        self.assertEqual(self.ended(program)[0], DONE)
        summary = json.loads((self.folder / "block/summary.json").read_text())
        self.assertEqual(summary["fingerprints"]["mesh"], hashlib.sha256(text.encode()).hexdigest())

    def test_what_is_not_a_number(self):
        self.assert_code(self.run_short(1, "part", "--until", "0.4 s"), DONE)
        shutil.copytree(self.folder / "part", self.folder / "whole_part")
        path = max((self.folder / "part/checkpoints").iterdir())
        for name, wrong in (("body/u", np.nan), ("body/v", np.inf), ("body/mesh/coordinates", np.nan),
                            ("counts/peak_needle_force", np.nan)):
            with self.subTest(column=name):
                shutil.copy(self.folder / "whole_part/checkpoints" / path.name, path)
                with h5py.File(path, "r+") as file:
                    column = file["state"][name]
                    values = column[()]
                    values.flat[values.size // 2] = wrong
                    column[...] = values
                sealed(path)
                for n in (1, 2) if name == "body/u" else (1,):
                    self.assert_refused(self.run_short(n, "part", "--resume"), "not a number", name,
                                        "--force")
        self.assertEqual(self.status("part")[0], "stopped")  # as it was

    def test_factor_that_is_not_a_number(self):
        """As by a fault of the memory, in mid-run."""
        for n in (1, 2):
            with self.subTest(ranks=n):
                wrong = self.run_short(n, "part", faulty=faults(nan=4))
                self.assert_code(wrong, NUMERICAL)
                self.assert_message(wrong, "not a number", "--resume")
                self.assertEqual(self.status("part")[0], "failed")
                self.assert_readable("part")
                self.assert_goes_on(n, "part")
                shutil.rmtree(self.folder / "part")

    def test_solver_that_does_not_converge(self):
        for n in (1, 2):
            with self.subTest(ranks=n):
                options = ["--", "-ksp_type", "cg", "-pc_type", "jacobi", "-ksp_max_it", "1"]
                wrong = self.run_short(n, "part", *options)
                self.assert_code(wrong, NUMERICAL)
                self.assert_message(wrong, "did not converge", "solver options")
                self.assertEqual(self.status("part")[0], "failed")
                self.assertIn("did not converge", self.status("part")[1])
                self.assert_goes_on(n, "part")
                shutil.rmtree(self.folder / "part")

    def test_memory_that_runs_out(self):
        """Below what the program needs to start nothing can be told."""
        self.write("big.yaml", (self.folder / "scene.yaml").read_text()
                   .replace("columns: 16", "columns: 160").replace("rows: 12", "rows: 120"))
        program = self.start(1, "run", "big.yaml", "--quiet", "--output", "part", *SHORT)
        self.wait_for(program, (self.folder / "part/summary.json").exists)
        with open(f"/proc/{program.pid}/statm") as file:
            size = int(file.read().split()[0]) * resource.getpagesize()
        resource.prlimit(program.pid, resource.RLIMIT_AS, (size + (2 << 20), size + (2 << 20)))
        code, err = self.ended(program)
        self.assertIn(code, (DONE, OTHER))
        if code == OTHER:
            self.assertIn("not enough memory", err)
            self.assertEqual(self.status("part")[0], "failed")
            self.assertIn("not enough memory", self.status("part")[1])

    def test_clock_that_is_put_back(self):
        for n in (1, 2):
            with self.subTest(ranks=n):
                outcome = self.run_short(n, "part", faulty=faults(on="00000007.h5", clock=86400))
                self.assert_code(outcome, DONE)
                self.assert_goes_on(n, "part")
                shutil.rmtree(self.folder / "part")


if __name__ == "__main__":
    unittest.main()
