#include "stylet/simulation/seed.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/simulation/point_text.hpp"

#include <cmath>

namespace stylet {

// A seed is where a needle left it that had cut its way there.
std::string why_no_seed(const Needle& needle, double largest_tip_force) {
  const double path = needle.path_length();
  const double depth = needle.tip() - needle.skin();
  const std::string who = "needle '" + needle.parameters().name + "' ";
  if (needle.released()) {
    return who + "implants a seed, but its tip is not in the tissue: it stands " +
           brief(1e3 * std::abs(depth)) +
           (depth > 0
                ? " mm behind the skin's place at entry, and the tissue has moved away from it"
                : " mm in front of the skin's place at entry");
  }
  const bool beyond = needle.tip_contact() != TipContact::open && depth >= path;
  if (needle.path().is_first_cut() && !beyond) {
    return who + "implants a seed " + brief(1e3 * depth) +
           " mm behind the skin, within its first cut, which goes " + brief(1e3 * path) +
           " mm at once, half-way through an element: only a finer mesh can tell how far it has "
           "cut";
  }
  // Part of the tip is in a shallow wound by right, but not in one that is a mere dent in the skin.
  constexpr double dent = 0.2;
  const double needed = needle.force_to_cut();
  const bool is_in = path >= needle.parameters().cutting.tip_length || path >= dent * depth;
  if (!needle.path().is_uncut() && is_in) return {};
  return who + "implants a seed, but has not cut its way in: its tip force reached " +
         brief(largest_tip_force) + " N of the " + brief(needed) +
         " N that are needed, and its tip is " + brief(1e3 * path) + " mm in the tissue after " +
         brief(1e3 * depth) +
         " mm of insertion; a smaller cutting_force or puncture_force, or a deeper insert";
}

Seed leave_seed(Body& body,
                const Needle& needle,
                const std::string& target,
                double largest_tip_force) {
  const Mesh& mesh = body.mesh();
  if (const auto why = why_no_seed(needle, largest_tip_force); !why.empty()) {
    throw NumericalError(why);
  }
  const ReferencePlace p = needle.tip_point();
  const auto place = locate(mesh, p, needle.path().tip_cell());
  if (!place) throw NumericalError("a seed fell outside the tissue");
  Seed seed;
  seed.needle = needle.parameters().name;
  seed.target = target;
  seed.time = body.time();
  const WorldPlace tip = needle.on_axis(needle.tip());
  seed.displacement = {tip.x - p.x, tip.y - p.y, tip.z - p.z};
  seed.place = body.embed({&*place, 1});
  seed.tip = needle.stand();
  seed.cutting = needle.parameters().cutting;
  return seed;
}

}  // namespace stylet
