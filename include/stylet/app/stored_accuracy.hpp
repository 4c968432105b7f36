// The convergence study that is stored beside a scene.
#pragma once

#include "stylet/scene/scene.hpp"
#include "stylet/simulation/accuracy.hpp"

#include <optional>
#include <string>

namespace stylet {

struct StoredAccuracy {
  std::optional<Accuracy> study = {};
  std::string missing = {};  ///< why the one that is there does not hold
};

/// Collective. Of the study beside the scene.
[[nodiscard]] StoredAccuracy stored_accuracy(const Scene& scene);

}  // namespace stylet
