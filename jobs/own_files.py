"""Files that a script may replace: those that Stylet's program or its scripts wrote (.stylet).

The file .stylet of a folder is described in include/stylet/output/manifest.hpp.
"""

import hashlib
from pathlib import Path

LARGEST_END = 256 * 1024  # bytes; as in src/output/manifest.cpp


class BadInput(Exception):
    """Something the user can put right; ends the program with exit code 2."""


def seal_of(path):
    size = path.stat().st_size
    with open(path, "rb") as file:
        if size <= 2 * LARGEST_END:
            return hashlib.sha256(file.read()).hexdigest()
        seal = hashlib.sha256(file.read(LARGEST_END))
        file.seek(size - LARGEST_END)
        seal.update(file.read() + str(size).encode())
    return seal.hexdigest()


class OwnFiles:
    """What is ours in a folder. Nothing else is replaced or removed."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.marks = self.folder / ".stylet"
        self.entries = {}
        if self.marks.is_file():
            for line in self.marks.read_text(encoding="utf-8").splitlines()[1:]:
                state, name, *seal = line.split()
                self.entries[name] = seal[0] if state == "sealed" else ""

    def owns(self, name):
        path = self.folder / name
        if name not in self.entries or path.is_symlink() or not path.is_file():
            return False
        return self.entries[name] in ("", seal_of(path))

    def claim(self, names):
        """Before `names` are written: raises BadInput if one of them is not ours."""
        for name in names:
            path = self.folder / name
            if (path.exists() or path.is_symlink()) and not self.owns(name):
                raise BadInput(f"{path}: was not written by Stylet, or was changed since; it is not "
                               "replaced: move it away")
        self._add("".join(f"open {name}\n" for name in names))

    def seal(self, names):
        """After `names` were written."""
        self._add("".join(f"sealed {name} {seal_of(self.folder / name)}\n" for name in names
                          if (self.folder / name).is_file()))

    def _add(self, lines):
        start = "" if self.marks.exists() else "stylet jobs pictures\n"
        with open(self.marks, "a", encoding="utf-8") as file:
            file.write(start + lines)
        for line in lines.splitlines():
            state, name, *seal = line.split()
            self.entries[name] = seal[0] if state == "sealed" else ""
