#!/usr/bin/python3
"""Runs a job that must fail, and checks how it ends.

usage: check_failure.py EXIT_CODE TEXT COMMAND...

TEXT must be printed exactly once (empty: not checked). The job must end within ten seconds:
run_guarded waits two for the other ranks, the rest is the start of the job on a busy machine.
"""
import subprocess
import sys
import time

LONGEST = 10.0


def main():
    code, text, command = int(sys.argv[1]), sys.argv[2], sys.argv[3:]
    start = time.monotonic()
    try:
        job = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    except subprocess.TimeoutExpired:
        sys.exit("the job hangs")
    seconds = time.monotonic() - start
    problems = []
    if job.returncode != code:
        problems.append(f"exit code {job.returncode}, not {code}")
    if seconds > LONGEST:
        problems.append(f"took {seconds:.1f} s")
    if text and (job.stdout + job.stderr).count(text) != 1:
        problems.append(f"'{text}' is not printed once")
    if problems:
        sys.exit("; ".join(problems) + "\n" + job.stdout + job.stderr)


if __name__ == "__main__":
    main()
