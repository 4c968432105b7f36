// A hand that reads its orders from a file: for pictures, films and tests.
//
//   0 s: height 3.2 cm        # a needle waits 2 cm in front of the skin
//   0 s: insert 2 cm/s
//   3.2 s: hold
//   3.2 s: seed
//   3.3 s: screenshot seed    # seed.png, and seed.json with the places of things
//
// The time is that of the script: what is undone does not turn it back.
#pragma once

#include <string>
#include <vector>

namespace stylet {

struct ScriptLine {
  double time = 0;  ///< s
  std::string command;
  std::string argument;  ///< the rest of the line
  std::string where;     ///< file:line
};

/// Throws InputError for what is no script; the arguments of commands are read when they are obeyed.
[[nodiscard]] std::vector<ScriptLine> read_script(const std::string& file_name,
                                                  const std::string& text);

/// Name and meaning of each command.
struct ScriptCommand {
  const char* name;
  const char* argument;
  const char* doc;
};
[[nodiscard]] const std::vector<ScriptCommand>& script_commands();

}  // namespace stylet
