// A campaign file: which scene, what varies, what comes out.
#pragma once

#include "stylet/scene/codec.hpp"

#include <string>
#include <vector>

namespace stylet {

enum class Design { one_at_a_time, grid, random, latin_hypercube, morris, sobol };
enum class Scale { linear, logarithmic };

/// A key that is multiplied by the variable to this power.
struct Factor {
  std::string key;
  double power = 1;
};

/// One input of a campaign. Exactly one of key, factor_of and offset_of says what it changes.
struct Variable {
  std::string name;
  std::string key;                     ///< takes the value itself
  std::vector<Factor> factor_of;       ///< are multiplied by powers of the value
  std::vector<std::string> offset_of;  ///< keys to which the value is added
  std::vector<std::string> values;
  std::string from;  ///< of a range; with a unit as in a scene
  std::string to;
  int count = 0;  ///< of evenly spaced values, ends included
  Scale scale = Scale::linear;
  bool on_the_way = false;  ///< all values in one run: seeds left along one insertion
};

/// Every point is run at `count` shifts, evenly spaced over `width` around it; the outputs are
/// averaged. Takes the jitter of the mesh out of a curve and shows how large it is.
struct Window {
  std::string name;
  std::vector<std::string> offset_of;
  std::string width;
  int count = 0;
};

struct Campaign {
  std::string file;
  std::string title;
  std::string scene;             ///< path, relative to the folder of the campaign
  std::vector<std::string> set;  ///< key=value, for all runs
  std::vector<Variable> vary;
  Design design = Design::one_at_a_time;
  int samples =
      0;  ///< random, latin_hypercube: points; morris: trajectories; sobol: N of N (d + 2)
  int seed = 1;
  std::vector<std::string> outputs;  ///< paths in summary.json
  std::vector<Window> average;
};

[[nodiscard]] const Codec<Campaign>& campaign_codec();

/// Throws InputError: keys as in load_scene, and rules between them. `set` comes after the file's.
[[nodiscard]] Campaign load_campaign(const std::string& file_name,
                                     const std::string& text,
                                     const std::vector<std::string>& set);

[[nodiscard]] const char* name_of(Design design);

/// Whether values are drawn from ranges, not listed.
[[nodiscard]] bool is_sampled(Design design);

}  // namespace stylet
