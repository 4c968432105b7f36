#include "stylet/view/script.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/base/units.hpp"

#include <algorithm>
#include <sstream>

namespace stylet {

namespace {

std::string trimmed(const std::string& text) {
  const char* const blank = " \t\r";
  const auto first = text.find_first_not_of(blank);
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

}  // namespace

const std::vector<ScriptCommand>& script_commands() {
  static const std::vector<ScriptCommand> commands{
      {"height", "LENGTH", "of the needle, while it is outside"},
      {"insert", "SPEED", "push until another order"},
      {"retract", "SPEED", "pull until another order"},
      {"hold", "", "keep the needle still"},
      {"seed", "[TARGET]", "leave one at the tip; for the nearest target that has none"},
      {"limit", "SPEED", "of the hand"},
      {"set", "KEY=VALUE", "a number that may change while the simulation runs"},
      {"method", "NAME", "implicit, quasi_static or explicit; all anew"},
      {"undo", "", "the last seed or needle"},
      {"restart", "", "all anew"},
      {"colours", "NAME", "none, displacement or von_mises"},
      {"show", "NAME", "picture, mesh, contacts, names, panel or help"},
      {"hide", "NAME", "likewise"},
      {"letters", "FACTOR", "their size"},
      {"pan", "LENGTH, LENGTH", "the camera goes so far to the right and up"},
      {"zoom", "FACTOR", "closer, towards the middle"},
      {"fit", "", "the whole tissue"},
      {"screenshot", "NAME", "NAME.png, and NAME.json with the places of things"},
      {"film", "RATE", "pictures frame_00000.png, ... so many a second; 0 ends it"}};
  return commands;
}

std::vector<ScriptLine> read_script(const std::string& file_name, const std::string& text) {
  std::vector<ScriptLine> lines;
  std::vector<std::string> names;
  for (const auto& command : script_commands()) names.emplace_back(command.name);
  std::istringstream in(text);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    ScriptLine read;
    read.where = file_name + ":" + std::to_string(number);
    const auto colon = line.find(':');
    if (colon == std::string::npos) {
      throw InputError(read.where + ": '" + line + "'; allowed: TIME: COMMAND, such as 2 s: seed");
    }
    try {
      read.time = to_si(trimmed(line.substr(0, colon)), "s");
    } catch (const InputError& error) {
      throw InputError(read.where + ": " + error.what());
    }
    const std::string rest = trimmed(line.substr(colon + 1));
    const auto space = rest.find(' ');
    read.command = rest.substr(0, space);
    if (space != std::string::npos) read.argument = trimmed(rest.substr(space));
    if (std::ranges::find(names, read.command) == names.end()) {
      throw InputError(read.where + ": '" + read.command +
                       "' is no command; allowed: " + join(names));
    }
    if (!lines.empty() && read.time < lines.back().time) {
      throw InputError(read.where + ": the time goes back, from " + exact(lines.back().time) +
                       " s; allowed: lines in the order of time");
    }
    lines.push_back(std::move(read));
  }
  return lines;
}

}  // namespace stylet
