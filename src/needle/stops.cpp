#include "stylet/needle/stops.hpp"

#include "stylet/base/text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace stylet {

namespace {

std::string brief(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// As the scene writes it: a depth, or a position and what it is from the skin.
std::string shown(const Stop& stop, double along_sign, double skin, bool skin_known) {
  const double depth = cleared(along_of(stop, skin) - skin, std::abs(skin));
  const std::string from_skin =
      depth < 0 ? brief(-depth) + " m in front of the entry point" : "depth " + brief(depth) + " m";
  if (stop.from_skin) return from_skin;
  return "position " + brief(along_sign * stop.along) + " m" +
         (skin_known ? ", " + from_skin : std::string());
}

}  // namespace

bool is_no_motion(double from, double to) {
  constexpr double round_off = 1e-12;
  constexpr double least = 1e-15;  // m
  return std::abs(to - from) <= least + round_off * std::max(std::abs(from), std::abs(to));
}

std::vector<Travel> travels_of(std::span<const Action> actions, double along_sign) {
  std::vector<Travel> travels;
  Stop tip;
  for (const Action& action : actions) {
    Travel travel{tip, tip};
    if (action.kind == ActionKind::insert || action.kind == ActionKind::retract) {
      travel.to = {0, true};
      travel.all_out = !action.depth && !action.position;
      if (action.depth) travel.to = {*action.depth, true};
      if (action.position) travel.to = {along_sign * *action.position, false};
    }
    travels.push_back(travel);
    tip = travel.to;
  }
  return travels;
}

std::optional<MotionFault> find_fault(std::span<const Action> actions,
                                      double along_sign,
                                      double skin,
                                      bool skin_known) {
  const auto travels = travels_of(actions, along_sign);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const auto& [from, to, all_out] = travels[i];
    const auto text = [&](const Stop& stop) { return shown(stop, along_sign, skin, skin_known); };
    const double start = along_of(from, skin);
    const double end = along_of(to, skin);
    const bool comparable = skin_known || from.from_skin == to.from_skin;
    const bool moves = comparable && !is_no_motion(start, end);
    switch (actions[i].kind) {
      case ActionKind::insert:
        if (moves && end < start) {
          if (skin_known && end < skin) {
            return MotionFault{
                i, "ends at " + text(to) +
                       "; allowed: an end in the tissue (positions grow against the advance)"};
          }
          return MotionFault{i, "ends at " + text(to) + ", and the tip is deeper already, at " +
                                    text(from) + "; allowed: a deeper end, or retract"};
        }
        break;
      case ActionKind::retract:
        if (moves && end > start && !all_out) {
          return MotionFault{i, "ends at " + text(to) + ", deeper than the tip is then, at " +
                                    text(from) + "; allowed: a shallower end, or insert"};
        }
        break;
      case ActionKind::implant:
        if (from.from_skin ? from.along <= 0
                           : skin_known && (is_no_motion(skin, start) || start < skin)) {
          return MotionFault{i, "the tip is not in the tissue then, but at " + text(from) +
                                    "; allowed: after an insert that ends in the tissue"};
        }
        break;
      case ActionKind::hold:
      case ActionKind::settle:
        break;
    }
  }
  return std::nullopt;
}

}  // namespace stylet
