#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/study/plan.hpp"

#include <algorithm>
#include <cstdio>

namespace stylet {

void print(const Plan& plan, const Scene& given) {
  std::printf("%-12s  %-12s  %22s  %14s  %s\n", "needle", "target", "error before (mm)",
              "planned (mm)", "jitter of the mesh (mm)");
  for (const auto& seed : plan.seeds) {
    std::printf("%-12s  %-12s  %22.3f  %14.3f  %.3f\n", seed.needle.c_str(), seed.target.c_str(),
                1e3 * seed.error_before, 1e3 * seed.error, 1e3 * seed.jitter);
  }
  for (const auto& seed : plan.seeds) {
    if (seed.uncertainty) {
      std::printf("placement error of the seed for '%s', with its numerical error: %s\n",
                  seed.target.c_str(),
                  with_uncertainty(seed.error, *seed.uncertainty, 1e3, "mm").c_str());
    } else {
      std::printf("note: numerical error unknown for '%s': stylet converge --store\n",
                  seed.target.c_str());
    }
  }
  for (std::size_t n = 0; n < given.needles.size(); ++n) {
    const auto& before = given.needles[n];
    const auto& after = plan.scene.needles[n];
    if (given.dim() == 2) {
      std::printf("%s: height %.3f -> %.3f mm\n", after.name.c_str(), 1e3 * before.height,
                  1e3 * after.height);
    } else if (after.space.target) {
      const auto e = after.space.entry->place();
      const auto t = after.space.target->place();
      std::printf("%s: from (%.3f, %.3f, %.3f) to (%.3f, %.3f, %.3f) mm\n", after.name.c_str(),
                  1e3 * e.x, 1e3 * e.y, 1e3 * e.z, 1e3 * t.x, 1e3 * t.y, 1e3 * t.z);
    }
    for (std::size_t i = 0; i < after.motion.size(); ++i) {
      const Action& a = before.motion[i];
      const Action& b = after.motion[i];
      if (b.kind != ActionKind::insert && b.kind != ActionKind::retract) continue;
      if (b.position && *a.position != *b.position) {
        std::printf("  motion %zu: position %.3f -> %.3f mm\n", i, 1e3 * *a.position,
                    1e3 * *b.position);
      }
      if (b.depth && *a.depth != *b.depth) {
        std::printf("  motion %zu: depth %.3f -> %.3f mm\n", i, 1e3 * *a.depth, 1e3 * *b.depth);
      }
      if (a.speed != b.speed) {
        std::printf("  motion %zu: speed %.3f -> %.3f cm/s\n", i, 1e2 * a.speed, 1e2 * b.speed);
      }
    }
  }
  std::printf(
      "%d runs; files in %s: planned.yaml (the scene as planned), results.csv, summary.json\n",
      plan.runs, plan.folder.c_str());
}

void throw_shortfalls(const Plan& plan) {
  double most = 0;
  for (const auto& seed : plan.seeds) most = std::max(most, seed.error);
  throw NumericalError("the plan still misses by " + brief(1e3 * most) +
                       " mm: " + join(plan.shortfalls, ", ") +
                       "; wider ranges, or more runs, may bring the seeds to their targets");
}

nlohmann::ordered_json summary_of(const Plan& result) {
  nlohmann::ordered_json summary{{"status", result.shortfalls.empty() ? "completed" : "failed"},
                                 {"runs", result.runs}};
  for (const auto& seed : result.seeds) {
    summary["seeds"].push_back({{"needle", seed.needle},
                                {"target", seed.target},
                                {"error_before", seed.error_before},
                                {"placement_error", seed.error},
                                {"jitter", seed.jitter}});
    if (seed.uncertainty) {
      summary["seeds"].back()["uncertainty"] = json_of(*seed.uncertainty);
    }
  }
  if (!result.shortfalls.empty()) summary["shortfalls"] = result.shortfalls;
  return summary;
}

}  // namespace stylet
