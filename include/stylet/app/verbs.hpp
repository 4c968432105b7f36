// The verbs of the program. Each is collective and returns the exit code.
#pragma once

#include "stylet/simulation/run.hpp"
#include "stylet/study/converge.hpp"
#include "stylet/study/plan.hpp"
#include "stylet/study/stability.hpp"
#include "stylet/study/sweep.hpp"
#include "stylet/study/tradeoff.hpp"

#include <string>
#include <vector>

namespace stylet {

struct SceneArguments {
  std::string file;
  std::vector<std::string> overrides;  ///< key=value
};

/// accuracy: wanted, such as '0.2 mm'; the study stored beside the scene then chooses mesh and step.
/// Empty: as the scene says.
int run_verb(SceneArguments arguments, RunOptions options, const std::string& accuracy);
int check_verb(const SceneArguments& arguments);
int modes_verb(const SceneArguments& arguments, int n);
int stability_verb(const SceneArguments& arguments, const StabilityOptions& options);
int converge_verb(const SceneArguments& arguments, const ConvergeOptions& options);
int plan_verb(const SceneArguments& arguments, PlanOptions options);
int tradeoff_verb(const SceneArguments& arguments, const TradeoffOptions& options);
/// scene.file is the campaign's.
int sweep_verb(const SceneArguments& arguments, const SweepOptions& options);
int schema_verb(bool markdown);

/// What the command line says to the window; the room `view` may not have been built.
struct ViewArguments {
  std::string script;
  std::string record;  ///< empty: out/view-<scene>
  bool records = true;
  std::string plan;
  std::string frames = "out/view";
  std::string size = "1280x800";
  double letters = 1;
  double seconds = 0;
};
int view_verb(const SceneArguments& arguments, const ViewArguments& view);

}  // namespace stylet
