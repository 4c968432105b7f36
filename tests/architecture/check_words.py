#!/usr/bin/python3
"""Fails on words that point to nowhere: links of pages, files that they name, sections that comments
cite; and on a README that is too long to be read.

usage: check_words.py SOURCE_FOLDER
"""
import pathlib
import re
import sys

LARGEST_README = 8192  # bytes

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)|^\[[^\]]+\]:\s+(\S+)", re.MULTILINE)
CODE = re.compile(r"`([^`\n]+)`")
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
# `tests/README.md`, `jobs/slurm/run.sbatch`: a file of the source tree, from its root.
TREE = re.compile(r"(?:cmake|examples|include|input|jobs|meshes|src|tests)/[\w./-]+\.[a-z0-9]+")
# What stands for any name.
PLACEHOLDER = re.compile(r"/NAME\b")
# In src/*.md `needle/track` or `needle/track.hpp` is a file of a room.
ROOM_FILE = re.compile(r"([a-z]+)/(\w+)(\.[hc]pp)?")
CITATION = re.compile(r"((?:[\w-]+/)*[\w-]+\.md)(?:,? sections? (\d+))?")


WRITTEN = {"report.md", "comparison.md"}  # by the program and its scripts, into their folders


def has_section(page, number):
    return re.search(rf"^## {number}\. ", page, re.MULTILINE) is not None


def breaches_of_page(root, name, text):
    """Of a page `name`, from the root."""
    found = []
    page = root / name
    for match in LINK.finditer(FENCE.sub("", text)):
        target = match[1] or match[2]
        if re.match(r"[a-z]+:", target):
            continue
        path, _, _ = target.partition("#")
        if path and not (page.parent / path).exists():
            found.append(f"{name}: links to {target}, which does not exist")
    for fence in [*FENCE.findall(text), *CODE.findall(FENCE.sub("", text))]:
        for path in TREE.findall(fence):
            if not PLACEHOLDER.search(path) and not (root / path).exists():
                found.append(f"{name}: names {path}, which does not exist")
    if name.startswith("src/"):
        rooms = {folder.name for folder in (root / "src").iterdir() if folder.is_dir()}
        for code in CODE.findall(FENCE.sub("", text)):
            match = ROOM_FILE.fullmatch(code)
            if not match or match[1] not in rooms:
                continue
            endings = [match[3]] if match[3] else [".hpp", ".cpp"]
            files = [f"src/{match[1]}/{match[2]}.cpp", f"include/stylet/{match[1]}/{match[2]}.hpp"]
            if not any((root / f).exists() and f.endswith(e) for f in files for e in endings):
                found.append(f"{name}: names {code}, which is no file of {match[1]}")
    if name == "README.md" and len(text.encode()) > LARGEST_README:
        found.append(f"{name}: {len(text.encode())} bytes, more than {LARGEST_README}: what belongs "
                     "to another page?")
    return found


def breaches_of_source(root, name, text):
    """Pages that a source file cites exist, beside it or from the root, and have the sections."""
    found = []
    for path, number in CITATION.findall(text):
        if path in WRITTEN:
            continue
        page = next((p for p in (root / path, (root / name).parent / path) if p.exists()), None)
        if page is None:
            found.append(f"{name}: cites {path}, which does not exist")
        elif number and not has_section(page.read_text(encoding="utf-8"), number):
            found.append(f"{name}: cites section {number} of {path}, which has none")
    return found


def main():
    root = pathlib.Path(sys.argv[1])
    breaches = []
    pages = [root / "README.md"]
    for top in ("examples", "include", "input", "jobs", "meshes", "src", "tests"):
        pages += sorted((root / top).rglob("*.md"))
    for path in pages:
        name = path.relative_to(root).as_posix()
        breaches += breaches_of_page(root, name, path.read_text(encoding="utf-8"))
    for top in ("include", "src", "tests"):
        for path in sorted((root / top).rglob("*.?pp")):
            name = path.relative_to(root).as_posix()
            breaches += breaches_of_source(root, name, path.read_text(encoding="utf-8"))
    if breaches:
        sys.exit("\n".join(breaches))


if __name__ == "__main__":
    main()
