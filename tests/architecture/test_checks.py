#!/usr/bin/python3
"""The architecture checks find breaches: a check that never fails shows nothing."""
import pathlib
import tempfile
import unittest

import check_layers
import check_style
import check_words


class Layers(unittest.TestCase):
    def breaches(self, room, name, *includes):
        text = "".join(f"#include {include}\n" for include in includes)
        return len(check_layers.breaches_of(room, name, text))

    def test_floors(self):
        self.assertEqual(self.breaches("fem", "x.cpp", '"stylet/mesh/mesh.hpp"', "<vector>"), 0)
        self.assertEqual(self.breaches("mesh", "x.cpp", '"stylet/fem/element.hpp"'), 1)
        self.assertEqual(self.breaches("mesh", "x.cpp", '"stylet/petsc/owned.hpp"'), 1)
        self.assertEqual(self.breaches("petsc", "x.cpp", '"stylet/geometry/points.hpp"'), 1)
        self.assertEqual(self.breaches("output", "x.cpp", '"stylet/scene/scene.hpp"'), 1)
        self.assertEqual(self.breaches("base", "x.cpp", '"stylet/nowhere/x.hpp"'), 1)

    def test_needle_sees_its_track_only(self):
        self.assertEqual(self.breaches("needle", "x.cpp", '"stylet/solvers/track_operator.hpp"'), 0)
        self.assertEqual(self.breaches("needle", "x.cpp", '"stylet/solvers/constraint_set.hpp"'), 1)
        self.assertEqual(self.breaches("needle", "x.cpp", '"stylet/dynamics/state.hpp"'), 1)
        self.assertEqual(self.breaches("needle", "x.hpp", '"stylet/fem/element.hpp"'), 1)
        self.assertEqual(self.breaches("needle", "x.hpp", "<petscmat.h>", "<petscksp.h>"), 2)

    def test_scene_sees_parameters_only(self):
        self.assertEqual(self.breaches("scene", "x.hpp", '"stylet/fem/parameters.hpp"'), 0)
        self.assertEqual(self.breaches("scene", "x.hpp", '"stylet/needle/needle.hpp"'), 1)

    def test_libraries(self):
        self.assertEqual(self.breaches("scene", "x.cpp", "<yaml-cpp/yaml.h>"), 0)
        self.assertEqual(self.breaches("app", "x.cpp", "<yaml-cpp/yaml.h>"), 1)
        self.assertEqual(self.breaches("simulation", "x.cpp", "<hdf5.h>"), 1)
        private = "<petsc/private/tsimpl.h>"
        self.assertEqual(self.breaches("dynamics", "central_difference_ts.cpp", private), 0)
        self.assertEqual(self.breaches("dynamics", "state.cpp", private), 1)


class Style(unittest.TestCase):
    def test_length(self):
        self.assertEqual(len(check_style.breaches_of("src/a.cpp", "x\n" * 400)), 0)
        self.assertEqual(len(check_style.breaches_of("src/a.cpp", "x\n" * 401)), 1)

    def test_headers(self):
        self.assertEqual(len(check_style.breaches_of("a.hpp", "// A thing.\n#pragma once\n")), 0)
        self.assertEqual(len(check_style.breaches_of("a.hpp", "int x;\n")), 2)
        self.assertEqual(len(check_style.breaches_of("a.cpp", "\tint x;\n")), 1)


class Words(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.root = pathlib.Path(scratch.name)
        for name in ("src/mesh/mesh.cpp", "input/a.yaml"):
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            (self.root / name).touch()
        (self.root / "src/MODEL.md").write_text("## 4. Edits\n")

    def of_page(self, text, name="src/MODEL.md"):
        return len(check_words.breaches_of_page(self.root, name, text))

    def of_source(self, text):
        return len(check_words.breaches_of_source(self.root, "src/mesh/mesh.cpp", text))

    def test_links(self):
        self.assertEqual(self.of_page("[a](../input/a.yaml#b) [c](https://example.org) [d](#e)"), 0)
        self.assertEqual(self.of_page("[a](input/a.yaml) ![b](c.png)\n\n[d]: nowhere.md"), 3)

    def test_files_in_code(self):
        self.assertEqual(self.of_page("`run input/a.yaml` `mesh/mesh` `mesh/mesh.cpp` `u/v` `input/NAME.yaml`"), 0)
        self.assertEqual(self.of_page("`run input/b.yaml` `mesh/mush` `mesh/mesh.hpp`\n```sh\njobs/x.sh\n```"), 4)

    def test_length_of_the_readme(self):
        self.assertEqual(self.of_page("x" * 8192, "README.md"), 0)
        self.assertEqual(self.of_page("x" * 8193, "README.md"), 1)
        self.assertEqual(self.of_page("x" * 8193), 0)

    def test_citations(self):
        self.assertEqual(self.of_source("// src/MODEL.md, section 4; writes report.md"), 0)
        self.assertEqual(self.of_source("// model.md, section 4; src/MODEL.md, section 5"), 2)


if __name__ == "__main__":
    unittest.main()
