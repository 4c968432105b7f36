// Scenes at the extremes of what a user can write down.
#pragma once

#include <string>
#include <vector>

namespace stylet {

enum class Wanted { answer, refusal, either };

struct Extreme {
  std::string name;
  std::vector<std::string> overrides;  ///< of the base scene
  Wanted wanted = Wanted::answer;      ///< a matter of principle; either: what the program can do
  bool is_long = false;                ///< only in the long version
};

/// 8 x 6 cm, a needle at 3.1 cm that goes 3 cm deep and leaves a seed.
const char* needle_scene();
[[nodiscard]] std::vector<Extreme> needle_extremes();

/// A bar pulled by 1 kN/m; uniaxial.
const char* bar_scene();
[[nodiscard]] std::vector<Extreme> bar_extremes();

}  // namespace stylet
