#include "stylet/mesh/gmsh_reader.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/validate.hpp"

#include "fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stylet;
  fuzz::may_refuse([&] {
    MeshData mesh = read_gmsh("m", fuzz::text_of(data, size));
    validate(mesh);
    fuzz::require(mesh.n_cells() > 0, "a mesh has cells");
    const Mesh valid(mesh);
    for (int c = 0; c < valid.n_cells(); ++c) {
      fuzz::require(valid.cell_measure(c) > 0, "cells have positive measure");
    }
    for (const auto& curve : mesh.curve_names) (void)valid.nodes_of(curve);
  });
  return 0;
}
