#!/usr/bin/python3
"""Fails on files that are too long, on headers without #pragma once or without a first comment.

usage: check_style.py SOURCE_FOLDER
"""
import pathlib
import sys

MOST_LINES = 400

# Longer files and why they may be.
LONG = {
    "src/needle/needle.cpp": "one state machine: plan, constraints and review share its state",
}


def breaches_of(name, text):
    found = []
    lines = text.count("\n")
    if lines > MOST_LINES and name not in LONG:
        found.append(f"{name}: {lines} lines, more than {MOST_LINES}: does it do two things?")
    if lines <= MOST_LINES and name in LONG:
        found.append(f"{name}: {lines} lines: strike it off the list of long files")
    if name.endswith(".hpp"):
        if "\n#pragma once\n" not in text:
            found.append(f"{name}: no #pragma once")
        if not text.startswith("// "):
            found.append(f"{name}: does not begin with a comment that says what it is for")
    if "\t" in text or "\r" in text:
        found.append(f"{name}: tabs or carriage returns")
    return found


def main():
    root = pathlib.Path(sys.argv[1])
    breaches = []
    names = set()
    for top in ("include", "src", "tests"):
        for path in sorted((root / top).rglob("*.?pp")):
            name = path.relative_to(root).as_posix()
            names.add(name)
            breaches += breaches_of(name, path.read_text(encoding="utf-8"))
    breaches += [f"{name}: listed as long but not there" for name in LONG if name not in names]
    if breaches:
        sys.exit("\n".join(breaches))


if __name__ == "__main__":
    main()
