#include "stylet/output/folder.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/simulation/accuracy.hpp"
#include "stylet/study/converge.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>

namespace stylet {

namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json json_of(const Scene& scene, const Convergence& result, std::size_t s, std::size_t q) {
  const Extrapolation& e = result.extrapolations[s][q];
  Json entry{{"order", number(e.order)}, {"limit", e.limit},   {"safety", e.safety},
             {"scatter", e.scatter},     {"remark", e.remark}, {"levels", Json::array()}};
  const Series& series = result.series[s];
  for (std::size_t i = 0; i < series.runs.size(); ++i) {
    const LevelRun& run = result.runs[series.runs[i]];
    entry["levels"].push_back({{"refine", run.level.refine},
                               {"step", run.level.step},
                               {"n_" + scene.cells(), run.n_cells},
                               {"value", run.values[q]},
                               {"uncertainty", e.uncertainty[i]}});
    if (series.name == "kernel") entry["levels"].back()["kernel"] = run.level.kernel;
  }
  return entry;
}

/// One level says nothing about what was not refined.
Json not_studied(const Scene& scene, const LevelRun& run, std::size_t q) {
  return {{"order", Json()},
          {"limit", run.values[q]},
          {"safety", 0},
          {"scatter", 0},
          {"remark", "not studied"},
          {"levels",
           {{{"refine", run.level.refine},
             {"step", run.level.step},
             {"n_" + scene.cells(), run.n_cells},
             {"value", run.values[q]},
             {"uncertainty", 0}}}}};
}

Json study_json(const Scene& scene,
                const Convergence& result,
                const std::string& mesh_fingerprint) {
  Json study{{"program", STYLET_VERSION}};
  for (const auto& run : result.runs) {
    study["runs"].push_back({{"refine", run.level.refine},
                             {"step", run.level.step},
                             {"n_" + scene.cells(), run.n_cells},
                             {"seconds", run.seconds}});
    if (run.level.kernel != 1) study["runs"].back()["kernel"] = run.level.kernel;
  }
  for (std::size_t q = 0; q < result.quantities.size(); ++q) {
    Json& entry = study["quantities"][result.quantities[q]];
    for (const char* name : {"mesh", "step"})
      entry[name] = not_studied(scene, result.runs.front(), q);
    for (std::size_t s = 0; s < result.series.size(); ++s) {
      entry[result.series[s].name] = json_of(scene, result, s, q);
    }
  }
  for (std::size_t s = 0; s < result.series.size(); ++s) {
    study["fields"][result.series[s].name] = result.field_distances[s];
  }
  study["moments"] = result.moments;
  study["scene"] = studied_text(scene);
  seal_accuracy(study, mesh_fingerprint);
  return study;
}

/// A factor and a unit in which people read a quantity.
std::pair<double, const char*> shown_in(const std::string& quantity) {
  if (quantity.ends_with("force")) return {1, "N"};
  return {1e3, "mm"};
}

void print(const Scene& scene, const Convergence& result, const std::string& mesh_fingerprint) {
  for (std::size_t s = 0; s < result.series.size(); ++s) {
    const Series& series = result.series[s];
    const bool is_kernel = series.name == "kernel";
    std::printf("%s %s\n%10s  %9s  %9s", series.name.c_str(), is_kernel ? "narrowed" : "refined",
                is_kernel ? "of its own" : scene.cells().c_str(), "step (ms)", "time (s)");
    for (const auto& quantity : result.quantities) {
      std::printf("  %26s", (quantity + " (" + shown_in(quantity).second + ")").c_str());
    }
    std::printf("%s\n", result.moments.empty() ? "" : "  u against the finest");
    for (std::size_t i = 0; i < series.runs.size(); ++i) {
      const LevelRun& run = result.runs[series.runs[i]];
      if (is_kernel) {
        std::printf("%10.3f", run.level.kernel);
      } else {
        std::printf("%10d", run.n_cells);
      }
      std::printf("  %9.4g  %9.3g", 1e3 * run.level.step, run.seconds);
      for (std::size_t q = 0; q < run.values.size(); ++q) {
        const double factor = shown_in(result.quantities[q]).first;
        char text[64];
        std::snprintf(text, sizeof text, "%.5g ± %.2g", factor * run.values[q],
                      factor * result.extrapolations[s][q].uncertainty[i]);
        std::printf("  %27s", text);  // the sign is two bytes
      }
      if (i + 1 < series.runs.size()) {
        for (const double d : result.field_distances[s][i]) std::printf("  %.2e", d);
      }
      std::printf("\n");
    }
    for (std::size_t q = 0; q < result.quantities.size(); ++q) {
      const Extrapolation& e = result.extrapolations[s][q];
      const auto [factor, unit] = shown_in(result.quantities[q]);
      std::printf("  %s: ", result.quantities[q].c_str());
      if (e.remark.empty()) {
        std::printf("order %.2f, limit %.5g %s\n", e.order, factor * e.limit, unit);
      } else {
        std::printf("%s; safety factor %g\n", e.remark.c_str(), e.safety);
      }
    }
    std::printf("\n");
  }
  const Accuracy accuracy("", study_json(scene, result, mesh_fingerprint).dump());
  for (std::size_t q = 0; q < result.quantities.size(); ++q) {
    const LevelRun& run = result.runs.front();
    const auto uncertainty = accuracy.of(result.quantities[q], run.level.refine, run.level.step);
    const auto [factor, unit] = shown_in(result.quantities[q]);
    if (uncertainty) {
      std::printf("%s of the scene as it is: %s\n", result.quantities[q].c_str(),
                  with_uncertainty(run.values[q], *uncertainty, factor, unit).c_str());
    }
  }
  std::printf("files in %s: results.csv, convergence.json, fields, scenes\n",
              result.folder.c_str());
  if (!result.stored.empty()) {
    std::printf("stored as %s: stylet run prints it with every placement error\n",
                result.stored.c_str());
  }
}

}  // namespace

void report(MPI_Comm comm,
            const Scene& scene,
            const Convergence& result,
            const std::string& mesh_fingerprint,
            bool quiet) {
  const std::string text =
      rank_of(comm) == 0 ? study_json(scene, result, mesh_fingerprint).dump(1) + "\n" : "";
  write_text_atomically(comm, result.folder + "/convergence.json", text);
  if (!result.stored.empty()) write_text_atomically(comm, result.stored, text);
  if (rank_of(comm) == 0 && !quiet) print(scene, result, mesh_fingerprint);
}

}  // namespace stylet
