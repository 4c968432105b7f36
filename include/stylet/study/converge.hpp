// How far a scene's numbers are from their limits: mesh and time step refined apart and together.
#pragma once

#include "stylet/scene/scene.hpp"
#include "stylet/study/richardson.hpp"
#include "stylet/study/study_folder.hpp"

#include <mpi.h>

#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

struct ConvergeOptions {
  StudyOptions study;
  int mesh_levels =
      3;  ///< the scene's mesh, and refined ones: every triangle split in four, or tetrahedron in eight
  int step_levels = 3;  ///< the scene's step, and halved ones
  bool store = false;   ///< write <scene>.accuracy.json beside the scene
};

// What a needle's kernel splits off wrongly goes with its radius squared; studies narrow it by this.
constexpr double kernel_ratio = std::numbers::sqrt2;
constexpr double kernel_order = 2;

/// Mesh, step and kernel of one run. Series of levels share runs.
struct Level {
  int refine = 0;
  double step = 0;    ///< s
  double kernel = 1;  ///< of needles in space: kernel_radius over the scene's
  friend bool operator==(const Level&, const Level&) = default;
};

struct Series {
  std::string name;               ///< mesh, step, joint or kernel
  std::vector<std::size_t> runs;  ///< coarsest first
};

struct LevelRun {
  Level level;
  int n_cells = 0;
  double seconds = 0;
  std::vector<double> values;  ///< one a quantity
};

struct Convergence {
  std::string folder;
  std::string stored;                   ///< path; empty if it was not
  std::vector<std::string> quantities;  ///< paths in summary.json
  std::vector<LevelRun> runs;
  std::vector<Series> series;
  /// [series][quantity]
  std::vector<std::vector<Extrapolation>> extrapolations;
  /// [series][level but the finest][moment]: relative distance of u from the finest level's.
  std::vector<std::vector<std::vector<double>>> field_distances;
  std::vector<double> moments;  ///< s; when fields are compared: at every implant, else at the end
};

/// Collective. Writes results.csv, convergence.json, fields/ and scenes/, prints tables and draws.
/// Throws NumericalError if a level failed: then there is no order.
Convergence converge(MPI_Comm comm, const Scene& scene, const ConvergeOptions& options);

/// Collective. convergence.json and, if asked for, the copy beside the scene, which says that it is of
/// the mesh file of this fingerprint; tables on rank 0's standard output.
void report(MPI_Comm comm,
            const Scene& scene,
            const Convergence& result,
            const std::string& mesh_fingerprint,
            bool quiet);

}  // namespace stylet
