#!/usr/bin/python3
"""The architecture checks find breaches: a check that never fails shows nothing."""
import unittest

import check_layers
import check_style


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

    def test_needle_sees_plain_constraints_only(self):
        self.assertEqual(self.breaches("needle", "x.cpp", '"stylet/solvers/constraint_set.hpp"'), 0)
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


if __name__ == "__main__":
    unittest.main()
