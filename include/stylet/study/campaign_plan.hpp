// The runs of a campaign: points of its design, shifts of its windows, and the changes of the scene
// that make each of them.
#pragma once

#include "stylet/study/campaign.hpp"

#include <string>
#include <vector>

namespace stylet {

struct CampaignPoint {
  std::vector<std::string> values;  ///< one a variable, as in a scene
};

struct PlannedRun {
  std::vector<std::string> overrides;  ///< of the scene, without the campaign's `set`
  std::vector<std::size_t> points;     ///< one; several if a variable is taken on the way
  /// Of each point, where the outputs lie that belong to it: paths in summary.json.
  std::vector<std::vector<std::string>> outputs;
  std::size_t shift = 0;
};

struct CampaignPlan {
  std::vector<std::string> units;  ///< of the variables; empty: none or text
  std::vector<CampaignPoint> points;
  /// What the windows add: one text a window, as in a scene. One empty entry if there is no window.
  std::vector<std::vector<std::string>> shifts;
  std::vector<PlannedRun> runs;
};

/// scene: the scene's text with the campaign's `set` applied, for values that others are relative
/// to. Throws InputError for values that do not fit their unit, or keys that the scene does not
/// write where a factor or an offset needs their value.
[[nodiscard]] CampaignPlan plan_runs(const Campaign& campaign, const Node& scene);

}  // namespace stylet
