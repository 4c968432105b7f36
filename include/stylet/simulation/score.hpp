// How well a procedure went.
#pragma once

#include "stylet/simulation/simulation.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace stylet {

struct SeedScore {
  std::string target;                   ///< empty: none
  double time = 0;                      ///< of implantation (s)
  double error_now = 0;                 ///< distance in the world (m); none: NaN
  std::optional<double> error_at_rest;  ///< m; where tissue goes back to where it was
};

struct Score {
  std::vector<SeedScore> seeds;
  std::vector<std::string> missed;      ///< targets without a seed
  std::optional<double> mean_error;     ///< m; of the seeds with a target, at rest where known
  std::optional<double> largest_error;  ///< m
  double largest_force = 0;             ///< N, of a needle at the end of a step
  double time = 0;                      ///< s
};

/// Collective.
[[nodiscard]] Score score_of(const Simulation& simulation);
/// A few lines.
[[nodiscard]] std::string text_of(const Score& score);
[[nodiscard]] nlohmann::ordered_json json_of(const Score& score);

}  // namespace stylet
