#include "stylet/view/method_choice.hpp"

namespace stylet {

namespace {

// The largest mesh on which 24 pictures a second in real time were measured (jobs/window_speed.py).
int most_triangles(const std::string& method) {
  return method == "explicit" ? 1226 : 19616;
}

}  // namespace

MethodChoice method_choice(const std::string& asked, const std::string& own, int n_triangles) {
  if (asked.empty() || asked == own) return {own, "the scene's"};
  if (asked != "auto") return {asked, "asked for; the scene's is " + own};
  const std::string measured =
      std::to_string(most_triangles(own)) + " triangles, here are " + std::to_string(n_triangles);
  if (n_triangles <= most_triangles(own)) {
    return {own, "the scene's; was measured to keep up with the clock on up to " + measured};
  }
  const std::string quickest = "quasi_static";
  if (own == quickest) return {own, "the scene's, and the quickest; may be slower than the clock"};
  return {quickest, "the quickest, without inertia; the scene's " + own +
                        " was measured to keep up with the clock on up to " + measured};
}

}  // namespace stylet
