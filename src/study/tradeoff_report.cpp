#include "stylet/output/summary.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/study/tradeoff.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace stylet {

namespace {

using Json = nlohmann::ordered_json;

std::string label(const TradeoffRun& run) {
  char text[100];
  std::snprintf(text, sizeof text, "%s, mesh.refine %d, step %.4g ms", run.way.c_str(), run.refine,
                1e3 * run.step);
  const std::string kernel = run.kernel == 1 ? "" : ", kernel " + brief(run.kernel) + " of its own";
  return text + kernel;
}

std::vector<const TradeoffRun*> front_of(const Tradeoff& result) {
  std::vector<const TradeoffRun*> front;
  for (const auto& run : result.runs) {
    if (run.on_front) front.push_back(&run);
  }
  std::ranges::sort(front, {}, &TradeoffRun::seconds);
  return front;
}

/// What inertia and damping do: the usual way against the quasi-static one at equal mesh and step.
std::optional<double> dynamic_share(const Tradeoff& result) {
  std::optional<double> largest;
  for (const auto& a : result.runs) {
    if (a.way != usual_way || !a.failure.empty()) continue;
    for (const auto& b : result.runs) {
      if (b.way != slow_limit_way || !b.failure.empty() || b.refine != a.refine ||
          b.step != a.step || b.kernel != a.kernel)
        continue;
      largest = std::max(largest.value_or(0), std::abs(a.value - b.value));
    }
  }
  return largest;
}

std::vector<std::string> advice(const Tradeoff& result) {
  constexpr double wanted[] = {1e-3, 0.5e-3, 0.2e-3, 0.1e-3, 0.05e-3};
  std::vector<std::string> lines;
  const auto front = front_of(result);
  for (const double target : wanted) {
    const auto best =
        std::ranges::find_if(front, [&](const auto* run) { return run->safe_error <= target; });
    char text[200];
    if (best == front.end()) {
      std::snprintf(text, sizeof text, "for %g mm: none of these; refine further", 1e3 * target);
    } else {
      std::snprintf(text, sizeof text, "for %g mm: %s, %.3g s", 1e3 * target, label(**best).c_str(),
                    (*best)->seconds);
    }
    lines.emplace_back(text);
  }
  if (result.kernel_error > 0) {
    char text[160];
    std::snprintf(
        text, sizeof text,
        "errors include %.3f mm of the scene's kernel, as two kernels on the finest mesh tell",
        1e3 * result.kernel_error);
    lines.emplace_back(text);
  }
  if (const auto share = dynamic_share(result)) {
    char text[120];
    std::snprintf(text, sizeof text,
                  "going dynamic changes the placement error by up to %.3f mm at this speed",
                  1e3 * *share);
    lines.emplace_back(text);
  }
  return lines;
}

Json json_of(const Tradeoff& result) {
  Json json{{"reference", result.reference}, {"advice", advice(result)}};
  const bool has_kernel = result.runs.back().kernel != 1;
  if (has_kernel) json["kernel_error"] = result.kernel_error;
  for (const auto& run : result.runs) {
    Json entry{{"way", run.way}, {"refine", run.refine}, {"step", run.step}};
    if (has_kernel) entry["kernel"] = run.kernel;
    if (run.failure.empty()) {
      entry.update({{"placement_error", run.value},
                    {"error", run.error},
                    {"safe_error", run.safe_error},
                    {"seconds", run.seconds},
                    {"on_front", run.on_front}});
    } else {
      entry["failure"] = run.failure;
    }
    json["runs"].push_back(entry);
  }
  return json;
}

void print(const Tradeoff& result) {
  const TradeoffRun& finest = *std::ranges::find_if(result.runs, is_reference);
  std::printf(
      "reference: %.4f mm (%s, %.3g s)\n\nPareto front: nothing faster is as accurate; errors are "
      "the largest of a run and all finer ones "
      "of its way\n",
      1e3 * result.reference, label(finest).c_str(), finest.seconds);
  std::printf("%9s  %10s  %16s  %s\n", "time (s)", "error (mm)", "digits a second", "");
  for (const TradeoffRun* run : front_of(result)) {
    const double digits =
        std::log10(result.reference / std::max(run->safe_error, 1e-12 * result.reference));
    std::printf("%9.3f  %10.4f  %16.3g  %s\n", run->seconds, 1e3 * run->safe_error,
                digits / run->seconds, label(*run).c_str());
  }
  std::printf("\n");
  for (const auto& line : advice(result)) std::printf("%s\n", line.c_str());
  std::string told;
  for (const auto& run : result.runs) {
    if (run.failure.empty() || run.way == told) continue;
    told = run.way;
    std::printf("%s failed: %s\n", run.way.c_str(), run.failure.c_str());
  }
  std::printf("files in %s: results.csv, tradeoff.json, scenes\n", result.folder.c_str());
}

}  // namespace

void report(MPI_Comm comm, const Tradeoff& result, bool quiet) {
  write_summary(comm, result.folder + "/tradeoff.json", json_of(result));
  if (rank_of(comm) == 0 && !quiet) print(result);
}

}  // namespace stylet
