// How long a step may be: measured over an insertion, beside what the program and SLEPc predict.
#pragma once

#include "stylet/fem/parameters.hpp"
#include "stylet/scene/scene.hpp"
#include "stylet/study/perturbation.hpp"

#include <mpi.h>
#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace stylet {

struct StabilityOptions {
  std::string output;  ///< folder; empty: out/stability-<name of the scene file>
  bool force = false;  ///< write into a folder that holds earlier results
  bool quiet = false;
  int samples = 8;  ///< moments of the insertion; the first is the mesh as it was made
};

/// Explicit steps (s) on mesh and constraints of one moment, mass lumped.
struct ExplicitLimit {
  double time = 0;       ///< s
  double tip_depth = 0;  ///< m, below the skin
  RayleighDamping damping;
  double predicted = 0;  ///< what ExplicitNewmark takes, without time.safety
  double spectral = 0;   ///< from the largest omega of M^-1 K (SLEPc)
  double measured = 0;   ///< by bisection with ExplicitNewmark
  double worst_quality = 0;
  double smallest_height = 0;  ///< m, of any triangle
};

/// Free undamped motion by one implicit scheme on mesh and constraints of mid-insertion.
struct ImplicitGrowth {
  ImplicitScheme scheme = ImplicitScheme::average_acceleration;
  double factor = 0;  ///< step over the measured explicit limit of that moment
  double step = 0;    ///< s
  EnergyGrowth energy;
};

/// The scene's whole insertion by one implicit scheme.
struct InsertionBalance {
  ImplicitScheme scheme = ImplicitScheme::average_acceleration;
  double factor = 0;
  double step = 0;      ///< s
  int steps = 0;        ///< taken
  double external = 0;  ///< J, work done by the hand
  /// Shares of it, at the end and the lowest of the run, by EnergyLedger: what the scheme lost.
  double balance_error = 0;
  double lowest_balance_error = 0;
  std::string failure;  ///< empty if it came to its end
};

struct Stability {
  std::string folder;
  std::vector<RayleighDamping> dampings;  ///< none, by mass, by stiffness
  bool mass_of_scene = false;             ///< the factor is the scene's
  bool stiffness_of_scene = false;
  std::vector<ExplicitLimit> limits;  ///< by moment, then by damping
  double middle_limit = 0;            ///< s; of `growths`
  double middle_depth = 0;            ///< m
  int growth_steps = 0;
  std::vector<ImplicitGrowth> growths;
  std::vector<InsertionBalance> balances;
};

[[nodiscard]] const char* name_of(ImplicitScheme scheme);

/// Collective. Measures, writes stability.csv, stability_implicit.csv and summary.json, and prints
/// tables. Throws InputError for tissue without mass.
Stability stability(MPI_Comm comm, const Scene& scene, const StabilityOptions& options);

/// Collective. The tables, into files of an existing folder and on rank 0's standard output. Returns
/// the summary.
[[nodiscard]] nlohmann::ordered_json report(MPI_Comm comm,
                                            const Scene& scene,
                                            const Stability& result,
                                            bool quiet);

}  // namespace stylet
