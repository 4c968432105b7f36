// The verbs and options of the program: one table, for what is read, what --help prints, the manual page
// and the completions of shells (src/app/pages.cpp).
#pragma once

#include "stylet/app/verbs.hpp"

#include <CLI/CLI.hpp>

#include <string>

namespace stylet {

/// What the command line asks for.
struct Asked {
  SceneArguments scene;
  RunOptions run;
  std::string accuracy;
  int n_modes = 0;
  StabilityOptions stability;
  ConvergeOptions converge;
  TradeoffOptions tradeoff;
  PlanOptions plan;
  SweepOptions sweep;
  ViewArguments view;
  bool markdown = false;
};

/// Parts of --help and of the manual page.
extern const char* const examples;
extern const char* const remarks;
extern const char* const exit_codes;

/// Declares all verbs; what is parsed later lands in `asked`.
void declare(CLI::App& app, Asked& asked);

}  // namespace stylet
