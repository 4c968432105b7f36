#include "stylet/output/history.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/study/stability.hpp"
#include "stylet/study/study_folder.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

namespace stylet {

namespace {

using Json = nlohmann::ordered_json;

void write_limits(MPI_Comm comm, const Stability& result) {
  HistoryWriter file(comm, result.folder + "/stability.csv",
                     {{"time", "s"},
                      {"tip_depth", "m"},
                      {"mass_factor", "1/s"},
                      {"stiffness_factor", "s"},
                      {"predicted_step", "s"},
                      {"spectral_step", "s"},
                      {"measured_step", "s"},
                      {"predicted_over_measured", ""},
                      {"spectral_over_measured", ""},
                      {"worst_quality", ""},
                      {"smallest_height", "m"}});
  for (const auto& l : result.limits) {
    const double row[] = {l.time,
                          l.tip_depth,
                          l.damping.mass_factor,
                          l.damping.stiffness_factor,
                          l.predicted,
                          l.spectral,
                          l.measured,
                          l.predicted / l.measured,
                          l.spectral / l.measured,
                          l.worst_quality,
                          l.smallest_height};
    file.write(row);
  }
  file.close();
}

// A row a step, the schemes side by side.
void write_growths(MPI_Comm comm, const Stability& result) {
  std::vector<Column> columns{{"step_over_limit", ""}, {"step", "s"}};
  std::vector<std::vector<double>> rows;
  const ImplicitGrowth* before = nullptr;
  for (const auto& growth : result.growths) {
    if (before == nullptr || growth.scheme != before->scheme) {
      columns.push_back({std::string(name_of(growth.scheme)) + "_largest", ""});
      columns.push_back({std::string(name_of(growth.scheme)) + "_last", ""});
    }
    before = &growth;
    auto row = std::ranges::find(rows, growth.factor, [](const auto& r) { return r.front(); });
    if (row == rows.end()) row = rows.insert(row, {growth.factor, growth.step});
    row->push_back(growth.energy.largest);
    row->push_back(growth.energy.last);
  }
  HistoryWriter file(comm, result.folder + "/stability_implicit.csv", std::move(columns));
  for (const auto& row : rows) file.write(row);
  file.close();
}

Json summary_of(const Scene& scene, const Stability& result) {
  Json summary;
  summary["status"] = "completed";
  summary["scene"] = scene.file;
  summary["safety"] = scene.time.safety;
  // Over all moments; stability.csv has them one by one.
  for (const auto& damping : result.dampings) {
    Json entry{{"mass_factor", damping.mass_factor},
               {"stiffness_factor", damping.stiffness_factor}};
    const auto range = [&](const char* name, auto value) {
      double low = std::numeric_limits<double>::infinity();
      double high = 0;
      for (const auto& l : result.limits) {
        if (l.damping.mass_factor != damping.mass_factor ||
            l.damping.stiffness_factor != damping.stiffness_factor) {
          continue;
        }
        low = std::min(low, value(l));
        high = std::max(high, value(l));
      }
      entry[name] = {{"min", low}, {"max", high}};
    };
    range("measured_step", [](const ExplicitLimit& l) { return l.measured; });
    range("predicted_over_measured", [](const auto& l) { return l.predicted / l.measured; });
    range("spectral_over_measured", [](const auto& l) { return l.spectral / l.measured; });
    summary["explicit"].push_back(entry);
  }
  summary["implicit_limit"] = result.middle_limit;
  summary["implicit_tip_depth"] = result.middle_depth;
  summary["implicit_steps"] = result.growth_steps;
  for (const auto& g : result.growths) {
    summary["implicit"].push_back({{"scheme", name_of(g.scheme)},
                                   {"step_over_limit", g.factor},
                                   {"step", g.step},
                                   {"largest_energy", g.energy.largest},
                                   {"last_energy", g.energy.last},
                                   {"grows", g.energy.grows}});
  }
  for (const auto& b : result.balances) {
    Json entry{{"scheme", name_of(b.scheme)},
               {"step_over_limit", b.factor},
               {"step", b.step},
               {"steps", b.steps},
               {"external_work", b.external},
               {"balance_error", b.balance_error},
               {"lowest_balance_error", b.lowest_balance_error}};
    if (!b.failure.empty()) entry["failure"] = b.failure;
    summary["insertions"].push_back(entry);
  }
  return summary;
}

std::string text_of(const RayleighDamping& damping) {
  char text[60] = "none";
  if (damping.mass_factor > 0)
    std::snprintf(text, sizeof text, "mass %.3g 1/s", damping.mass_factor);
  if (damping.stiffness_factor > 0) {
    std::snprintf(text, sizeof text, "stiffness %.3g s", damping.stiffness_factor);
  }
  return text;
}

void print(const Scene& scene, const Stability& result) {
  std::printf(
      "explicit: largest stable step on the mesh and constraints of the moment, lumped mass\n"
      "%8s  %-20s  %13s  %14s  | over measured: %9s  %6s  | %7s  %s\n",
      "tip (mm)", "damping", "measured (ms)", "predicted (ms)", "predicted", "SLEPc", "quality",
      "smallest height (mm)");
  for (const auto& l : result.limits) {
    std::printf("%8.2f  %-20s  %13.4f  %14.4f  | %24.3f  %6.4f  | %7.3f  %.3f\n", 1e3 * l.tip_depth,
                text_of(l.damping).c_str(), 1e3 * l.measured, 1e3 * l.predicted,
                l.predicted / l.measured, l.spectral / l.measured, l.worst_quality,
                1e3 * l.smallest_height);
  }
  std::printf(
      "measured to %g %%; runs with time.method explicit take the predicted step times time.safety "
      "(%g)\n",
      100 * limit_accuracy, scene.time.safety);
  if (!result.mass_of_scene)
    std::printf("mass damping is chosen here: 0.02 of the largest omega\n");
  if (!result.stiffness_of_scene) {
    std::printf(
        "stiffness damping is chosen here, 0.2 over the largest omega: the scene has none, or more "
        "than explicit steps can bear\n");
  }
  std::printf(
      "\nimplicit: energy over that of the start, free undamped motion from random velocities, tip "
      "%.2f mm deep,\n%d steps; h in explicit limits (%.4f ms)\n"
      "%10s  %-20s  %-14s  %-14s  grows\n",
      1e3 * result.middle_depth, result.growth_steps, 1e3 * result.middle_limit, "h / limit",
      "scheme", "largest - 1", "last");
  for (const auto& g : result.growths) {
    std::printf("%10g  %-20s  %-14.2e  %-14.8g  %s\n", g.factor, name_of(g.scheme),
                g.energy.largest - 1, g.energy.last, g.energy.grows ? "YES" : "no");
  }
  if (!result.balances.empty()) {
    std::printf(
        "\nwhole insertion with the scene's damping: balance error as in history.csv over the work "
        "of the hand\n(positive: lost by the scheme)\n"
        "%10s  %-20s  %6s  %12s  %12s\n",
        "h (ms)", "scheme", "steps", "at the end", "lowest");
  }
  for (const auto& b : result.balances) {
    std::printf("%10.3f  %-20s  %6d  ", 1e3 * b.step, name_of(b.scheme), b.steps);
    if (b.failure.empty()) {
      std::printf("%12.2e  %12.2e\n", b.balance_error, b.lowest_balance_error);
    } else {
      std::printf("failed: %s\n", b.failure.c_str());
    }
  }
  std::printf("\nfiles in %s: stability.csv, stability_implicit.csv, summary.json\n",
              result.folder.c_str());
  std::printf("picture: %s %s\n", script_path("stability.py").c_str(), result.folder.c_str());
}

}  // namespace

Json report(MPI_Comm comm, const Scene& scene, const Stability& result, bool quiet) {
  write_limits(comm, result);
  write_growths(comm, result);
  if (rank_of(comm) == 0 && !quiet) print(scene, result);
  return summary_of(scene, result);
}

}  // namespace stylet
