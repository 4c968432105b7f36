// Which method of time stepping a procedure by hand begins with.
#pragma once

#include <string>

namespace stylet {

struct MethodChoice {
  std::string method;  ///< as time.method
  std::string reason;
};

/// asked: a method; empty for that of the scene, or `auto`: that of the scene (own) where it was measured
/// to keep up with the clock on as many triangles (the table in jobs/README.md), else the quickest.
[[nodiscard]] MethodChoice method_choice(const std::string& asked,
                                         const std::string& own,
                                         int n_triangles);

}  // namespace stylet
