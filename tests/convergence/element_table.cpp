// Prints, as Markdown, both element formulations against known answers.
//   element_table [LARGEST_N] [FOLDER]
// Squares of LARGEST_N x LARGEST_N cells at most (64); FOLDER holds Gmsh meshes square_1.msh,
// cook_1.msh, square_2.msh ... (make_benchmark_meshes.py).
#include "stylet/mesh/gmsh_reader.hpp"
#include "stylet/petsc/session.hpp"

#include "benchmarks.hpp"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

namespace {

using namespace stylet;
using namespace stylet::benchmark;

using Series = std::vector<MeshData>;
using Quantity = std::function<double(MeshData, Formulation)>;

MeshData from_file(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return read_gmsh(file.string(), text.str());
}

Series gmsh_series(const std::filesystem::path& folder, const std::string& name) {
  Series series;
  for (int level = 1;; ++level) {
    const auto file = folder / (name + "_" + std::to_string(level) + ".msh");
    if (!std::filesystem::exists(file)) return series;
    series.push_back(from_file(file));
  }
}

void rows(const char* what,
          double exact,
          const char* mesh,
          const Series& series,
          const Quantity& quantity) {
  for (const auto& [name, formulation] :
       {std::pair{"p1", Formulation::p1}, std::pair{"p1_averaged", Formulation::p1_averaged}}) {
    std::printf("| %s | %s | %s |", what, mesh, name);
    double last = 0;
    for (const auto& data : series) {
      last = quantity(data, formulation);
      std::printf(" %+.2f |", 100 * (last / exact - 1));
      std::fflush(stdout);
    }
    std::printf(" %.5g of %.6g |\n", last, exact);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const Session session(argc, argv);
  const int largest = argc > 1 ? std::atoi(argv[1]) : 64;
  struct Kind {
    const char* name;
    Series squares;
    Series cooks;
  };
  std::vector<Kind> kinds{{"one way", {}, {}}, {"alternating", {}, {}}};
  std::vector<int> sizes;
  for (int n = 16; n <= largest; n *= 2) sizes.push_back(n);
  for (const int n : sizes) {
    kinds[0].squares.push_back(square(n, Diagonals::one_way));
    kinds[0].cooks.push_back(cook(n, Diagonals::one_way));
    kinds[1].squares.push_back(square(n, Diagonals::alternating));
    kinds[1].cooks.push_back(cook(n, Diagonals::alternating));
  }
  if (argc > 2)
    kinds.push_back({"Gmsh", gmsh_series(argv[2], "square"), gmsh_series(argv[2], "cook")});
  std::printf("| problem, error in %% | mesh | element |");
  for (const int n : sizes) std::printf(" %d |", 2 * n * n);
  std::printf(" finest of exact |\n|---|---|---|");
  for (std::size_t i = 0; i < sizes.size(); ++i) std::printf("---:|");
  std::printf("---|\n");
  const auto each = [&](const std::string& what, double exact, bool on_cook, const Quantity& q) {
    for (const auto& kind : kinds) {
      rows(what.c_str(), exact, kind.name, on_cook ? kind.cooks : kind.squares, q);
    }
  };
  for (const auto& [nu, exact] : {std::pair{0.3, 21.9450}, {0.49, 18.7367}, {0.4999, 18.512}}) {
    each("Cook, nu " + std::to_string(nu).substr(0, 6), exact, true,
         [nu = nu](MeshData mesh, Formulation f) {
           return cook_displacements(std::move(mesh), nu, f).middle;
         });
  }
  for (const auto& [nu, exact] : {std::pair{0.3, 1.3689}, {0.49, 2.5095}}) {
    each("B, nu " + std::to_string(nu).substr(0, 4), exact, false,
         [nu = nu](MeshData mesh, Formulation f) { return stuck_force(std::move(mesh), nu, f); });
  }
  for (const auto& [nu, exact] : {std::pair{0.3, -0.515506}, {0.49, -0.250189}}) {
    each("C, nu " + std::to_string(nu).substr(0, 4), exact, false,
         [nu = nu](MeshData mesh, Formulation f) {
           return sliding_displacement(std::move(mesh), nu, f);
         });
  }
  for (const auto& [nu, exact] : {std::pair{0.3, std::vector{2.491907, 3.492991, 3.642831}},
                                  {0.49, std::vector{3.44668, 3.96050, 4.70961}}}) {
    for (std::size_t i = 0; i < 3; ++i) {
      each("clamped square, nu " + std::to_string(nu).substr(0, 4) + ", omega " +
               std::to_string(i + 1),
           exact[i], false, [nu = nu, i](MeshData mesh, Formulation f) {
             return clamped_frequencies(std::move(mesh), nu, f).at(i);
           });
    }
  }
  // No high-order value: the limit of p1_averaged on alternating diagonals, 128^2 and 256^2.
  for (const auto& [nu, limit] : {std::pair{0.499, 2.979}, {0.4999, 3.044}, {0.49999, 3.051}}) {
    each("B, nu " + std::to_string(nu).substr(0, 7), limit, false,
         [nu = nu](MeshData mesh, Formulation f) { return stuck_force(std::move(mesh), nu, f); });
  }
}
