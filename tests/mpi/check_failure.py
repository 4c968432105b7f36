#!/usr/bin/python3
"""Runs a job that must fail, and checks how it ends.

usage: check_failure.py EXIT_CODE TEXT COMMAND...

TEXT must be printed exactly once (empty: not checked). A job that hangs fails; how long another
takes depends on the machine.
"""
import subprocess
import sys

LONGEST = 200  # s; run_guarded waits two for the other ranks


def main():
    code, text, command = int(sys.argv[1]), sys.argv[2], sys.argv[3:]
    try:
        job = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, check=False)
    except subprocess.TimeoutExpired:
        sys.exit("the job hangs")
    problems = []
    if job.returncode != code:
        problems.append(f"exit code {job.returncode}, not {code}")
    if text and (job.stdout + job.stderr).count(text) != 1:
        problems.append(f"'{text}' is not printed once")
    if problems:
        sys.exit("; ".join(problems) + "\n" + job.stdout + job.stderr)


if __name__ == "__main__":
    main()
