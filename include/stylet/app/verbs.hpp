// The verbs of the program. Each is collective and returns the exit code.
#pragma once

#include "stylet/simulation/run.hpp"
#include "stylet/study/stability.hpp"
#include "stylet/study/sweep.hpp"

#include <string>
#include <vector>

namespace stylet {

struct SceneArguments {
  std::string file;
  std::vector<std::string> overrides;  ///< key=value
};

int run_verb(const SceneArguments& arguments, const RunOptions& options);
int check_verb(const SceneArguments& arguments);
int modes_verb(const SceneArguments& arguments, int n);
int stability_verb(const SceneArguments& arguments, const StabilityOptions& options);
/// scene.file is the campaign's.
int sweep_verb(const SceneArguments& arguments, const StudyOptions& options);
int schema_verb(bool markdown);

}  // namespace stylet
