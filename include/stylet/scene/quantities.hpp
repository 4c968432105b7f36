// The numbers that a run's summary.json has, known before the run.
#pragma once

#include "stylet/scene/scene.hpp"

#include <optional>
#include <string>
#include <vector>

namespace stylet {

/// A number by its path in summary.json.
struct SummaryQuantity {
  std::string path;
  std::string unit;  ///< SI; empty: none
};

/// Of a run of this scene that comes to its end.
[[nodiscard]] std::vector<SummaryQuantity> summary_quantities(const Scene& scene);

/// SI unit of a number of any scene's summary; none if there is no such number.
[[nodiscard]] std::optional<std::string> unit_of_quantity(const std::string& path);

}  // namespace stylet
