// What the window shows of a moment: plain numbers, copied out of the simulation by the thread that
// steps it and read by the one that draws. In the scene's frame, SI units.
#pragma once

#include "stylet/geometry/points.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

/// What gives the triangles their colour.
enum class Colouring { none, displacement, von_mises };

struct ShownShaftPoint {
  WorldPoint x;
  bool sticks = false;  ///< else it slides
};

struct ShownNeedle {
  WorldPoint tip;
  WorldPoint skin;         ///< where it enters, or would
  bool in_tissue = false;  ///< else it stands outside, its height may be chosen
  bool touches = false;    ///< the tip pushes or cuts
  bool at_membrane = false;
  std::vector<ShownShaftPoint> shaft;
  std::string phase;
};

struct ShownSeed {
  WorldPoint x;
  std::string needle;
  std::string target;                        ///< empty: none
  std::optional<double> error_now = {};      ///< m, from its target in space
  std::optional<double> error_at_rest = {};  ///< m, once tissue has gone back; none: it never will
  std::optional<double> band = {};  ///< m, half width of the numerical error at rest; none: unknown
};

struct ShownTarget {
  std::string name;
  WorldPoint x;
  bool has_seed = false;
};

/// A number of the scene that may change while it runs.
struct ShownParameter {
  std::string key;
  std::string doc;
  std::string unit;  ///< SI; empty: none
  double value = 0;
  double low = 0;  ///< ends of its slider
  double high = 0;
  bool new_operator = false;  ///< the tissue's matrices are made anew
};

/// Of a step, for the plots.
struct Sample {
  double time = 0;         ///< s
  double tip_force = 0;    ///< N
  double shaft_force = 0;  ///< N
  double kinetic = 0;      ///< J, as all that follow
  double strain = 0;
  double dissipated = 0;
  double external = 0;
};

/// How fast things go.
struct Pace {
  double real_time_factor = 1;  ///< simulated time over that of the clock, lately
  double busy = 0;              ///< share of the clock's time that the steps take, lately
  double sub_steps = 0;         ///< of a step of the scene, lately
  double step = 0;              ///< s, of the scene
  double all_longest = 0;       ///< s of the clock, of any step since the start
  double all_busy = 0;          ///< as busy, since the start
  double lost = 0;              ///< s of the clock that were not made up for, in all
};

struct Frame {
  std::uint64_t number = 0;  ///< 0: none yet
  std::uint64_t mesh_version = 0;
  double time = 0;  ///< s
  std::string method;

  std::vector<float> reference;          ///< two of each node (m)
  std::vector<float> displacement;       ///< two of each node (m)
  std::vector<std::uint32_t> triangles;  ///< three nodes each
  Colouring colouring = Colouring::none;
  std::vector<float> colour;        ///< of each triangle (m or Pa)
  double largest_displacement = 0;  ///< m

  std::vector<WorldPoint> membrane;  ///< closed
  ShownNeedle needle;
  double needle_angle = 0;  ///< as the scene's (rad)
  double height = 0;        ///< m, across, in the needle's coordinates
  double tip = 0;           ///< m, along
  double speed_limit = 0;   ///< m/s
  std::vector<ShownSeed> seeds;
  std::vector<ShownTarget> targets;

  double tip_force = 0;    ///< N
  double shaft_force = 0;  ///< N
  double peak_force = 0;   ///< N
  int n_stick = 0;
  int n_slip = 0;
  int punctures = 0;
  double worst_quality = 1;
  int inverted = 0;  ///< triangles whose deformed area is not positive

  std::vector<ShownParameter> parameters;
  std::vector<Sample> history;
  bool can_undo = false;
  int epoch = 0;          ///< another one: the needle is not where it was
  bool replays = false;   ///< a recorded procedure moves the needle
  std::string notice;     ///< why an order was not obeyed, or what has changed; empty: nothing
  std::string error;      ///< the physics has stopped; empty: it runs
  double made_at = 0;     ///< s of the clock
  double hand_stamp = 0;  ///< s of the clock, when what the last step obeyed was wanted
  Pace pace;
};

}  // namespace stylet
