#!/usr/bin/python3
"""What `cmake --install` leaves: a library that find_package finds, a program that finds its scripts, a
manual page and completions.

The environment names the build (STYLET_BUILD, STYLET_BUILD_TYPE), the source tree (STYLET_SOURCE) and
CMake (STYLET_CMAKE, STYLET_CXX).
"""

import csv
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ["STYLET_SOURCE"])
BUILD = pathlib.Path(os.environ["STYLET_BUILD"])
CMAKE = os.environ["STYLET_CMAKE"]

# tests/library/examples/insertion.cpp builds the same in C++.
SCENE = """\
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 24, rows: 18}}
tissue:
  plane: stress
  regions: {tissue: {youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}
  damping: {stiffness_factor: 0.05 s}
supports: {left: fixed, top: fixed, bottom: fixed}
needles:
  - height: 3.2 cm
    cutting: {cutting_force: 1.7 N, tip_length: 6 mm}
    friction: {static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 1 mm/s,
               slip_speed: 1.5 mm/s}
    motion:
      - insert: {speed: 2 cm/s, depth: 4 cm}
probes: {ahead: [3.5 cm, 3.2 cm]}
time: {step: 10 ms}
"""

CAMPAIGN = """\
scene: scene.yaml
design: grid
vary:
  force: {key: needles.0.cutting.cutting_force, values: [1 N, 1.7 N]}
outputs: [peak_needle_force]
"""

# What the shell would do at a tab behind the words, the last of which is unfinished.
COMPLETE = r"""
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
_stylet
printf '%s\n' "${COMPREPLY[@]}"
"""


def call(*command, cwd=None, code=0):
    done = subprocess.run(list(map(str, command)), cwd=cwd, capture_output=True, text=True)
    if done.returncode != code:
        raise AssertionError(f"{command}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="stylet_library_")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        cls.prefix = cls.folder / "prefix"
        call(CMAKE, "--install", BUILD, "--prefix", cls.prefix)
        cls.program = cls.prefix / "bin/stylet"
        cls.share = cls.prefix / "share"
        (cls.folder / "scene.yaml").write_text(SCENE, encoding="utf-8")

    def configure(self, folder, code=0):
        return call(CMAKE, "-S", folder, "-B", folder / "build", "-DCMAKE_BUILD_TYPE=Release",
                    f"-DCMAKE_PREFIX_PATH={self.prefix}",
                    f"-DCMAKE_CXX_COMPILER={os.environ['STYLET_CXX']}", code=code)

    def test_program_with_the_library(self):
        """A scene made in C++ and the same scene as text give the same field.

        The program is stepped by hand, the other by `run`, on the same mesh: the numbers differ only
        by the digits of history.csv, at least ten.
        """
        example = self.folder / "example"
        shutil.copytree(SOURCE / "tests/library/examples", example)
        self.configure(example)
        call(CMAKE, "--build", example / "build")
        out = call(example / "build/insertion", cwd=self.folder).stdout
        values = {key: float(value) for key, value in map(str.split, out.splitlines())}
        call(self.program, "run", "scene.yaml", "--quiet", cwd=self.folder)
        with open(self.folder / "out/scene/history.csv", newline="", encoding="utf-8") as file:
            last = {key.split(" [")[0]: value for key, value in list(csv.DictReader(file))[-1].items()}
        self.assertLess(values["ahead_ux"], -1e-4)  # pushed along by the needle
        self.assertAlmostEqual(values["ahead_ux"] / float(last["ahead_ux"]), 1, delta=1e-9)
        self.assertAlmostEqual(values["time"], float(last["time"]), delta=1e-9)
        # Depth over speed; the sum of 200 steps.
        self.assertAlmostEqual(values["time"], 2, delta=1e-9)
        self.assertGreaterEqual(values["largest"], -values["ahead_ux"])

    def test_other_version_is_refused(self):
        other = self.folder / "other"
        other.mkdir()
        (other / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(other LANGUAGES CXX)\n"
            "find_package(stylet 9 REQUIRED)\n", encoding="utf-8")
        self.assertIn('requested version "9"', self.configure(other, code=1).stderr)

    def test_scripts_are_found(self):
        (self.folder / "campaign.yaml").write_text(CAMPAIGN, encoding="utf-8")
        drawn = call(self.program, "sweep", "campaign.yaml", cwd=self.folder)
        self.assertTrue((self.folder / "out/sweep-campaign/study.png").is_file(),
                        drawn.stdout + drawn.stderr)

    def test_scenes_are_whole(self):
        for scene in ("prostate", "block"):
            call(self.program, "check", self.share / f"stylet/input/{scene}.yaml", cwd=self.folder)

    @unittest.skipUnless(os.environ["STYLET_BUILD_TYPE"] == "Release",
                         "debugging information names the sources")
    def test_nothing_names_the_source_tree(self):
        naming = [path for path in self.prefix.rglob("*")
                  if path.is_file() and os.fsencode(SOURCE) in path.read_bytes()]
        self.assertEqual(naming, [])

    def options(self, *verb):
        """As --help prints them."""
        out = call(self.program, *verb, "--help").stdout.split("\nExamples:")[0]
        return re.findall(r"^  (?:-\w,)?(--[\w-]+)", out, re.MULTILINE)

    def verbs(self):
        out = call(self.program, "--help").stdout.split("Subcommands:\n")[1]
        return re.findall(r"^  (\w+) ", out.split("\n\n")[0], re.MULTILINE)

    def test_help_is_understood(self):
        self.assertGreater(len(self.verbs()), 8)
        self.assertIn("--accuracy", self.options("run"))
        self.assertIn("--no-picture", self.options("sweep"))

    def test_manual_page(self):
        page = self.share / "man/man1/stylet.1"
        text = page.read_text(encoding="utf-8").replace("\\-", "-")
        for verb in self.verbs():
            section = text.split(f".SS stylet {verb}\n")[1].split("\n.S")[0]
            for option in self.options(verb):
                self.assertIn(f"\\fB{option}\\fR", section)
        if shutil.which("groff"):
            shown = call("groff", "-man", "-ww", "-Tutf8", page)
            self.assertEqual(shown.stderr, "")
            self.assertIn("--ranks-per-run", re.sub("\x1b\\[\\d*m|.\b", "", shown.stdout))
        if shutil.which("man"):
            # man sets lines to the width of the terminal, here none.
            self.assertEqual(call("man", "--warnings", "-l", page).stderr, "")

    def complete(self, *words):
        script = self.share / "bash-completion/completions/stylet"
        return call("bash", "-c", COMPLETE, "bash", script, "stylet", *words).stdout.split()

    def test_bash_completion(self):
        self.assertEqual(sorted(self.complete("")),
                         sorted([*self.verbs(), *self.options(), "-h"]))
        self.assertEqual(self.complete("tr"), ["tradeoff"])
        for verb in self.verbs():
            self.assertEqual(sorted(self.complete(verb, "--")), sorted(self.options(verb)))
        self.assertEqual(self.complete("run", "in"), [])  # left to the names of files
        self.assertEqual(self.complete("run", "s.yaml", "--", "--"), [])  # PETSc's

    def test_other_completions(self):
        for shell, name, mark in (("zsh", "zsh/vendor-completions/_stylet", "'*{}["),
                                  ("fish", "fish/vendor_completions.d/stylet.fish", " -l {} ")):
            script = self.share / name
            text = script.read_text(encoding="utf-8")
            for verb in self.verbs():
                self.assertIn(verb, text)
                for option in self.options(verb):
                    self.assertIn(mark.format(option if shell == "zsh" else option[2:]), text)
            if shutil.which(shell):
                call(shell, "-n", script)


if __name__ == "__main__":
    unittest.main()
