#include "stylet/simulation/accuracy.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/fingerprint.hpp"
#include "stylet/base/utf8.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/scene/writer.hpp"
#include "stylet/simulation/model.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <sstream>

namespace stylet {

namespace {

using Json = nlohmann::ordered_json;

constexpr double same_step = 1e-9;  // relative

/// Of the level of that refinement; finer meshes than the finest follow its order.
std::optional<double> mesh_part(const Json& mesh, int refine) {
  const auto& levels = mesh["levels"];
  for (const Json& level : levels) {
    if (level["refine"] == refine) return level["uncertainty"].get<double>();
  }
  const Json& finest = levels.back();
  const int finer = refine - finest["refine"].get<int>();
  if (finer < 0) return std::nullopt;
  const bool has_order = mesh["remark"].get<std::string>().empty();
  const double order = has_order ? mesh["order"].get<double>() : 0;
  return finest["uncertainty"].get<double>() * std::pow(2.0, -order * finer);
}

/// Of the longest studied step that is not shorter.
std::optional<double> step_part(const Json& steps, double step) {
  std::optional<double> found;
  for (const Json& level : steps["levels"]) {  // longest first
    if (level["step"].get<double>() * (1 + same_step) >= step) {
      found = level["uncertainty"].get<double>();
    }
  }
  return found;
}

/// Throws Json::exception or InputError unless everything is there that is looked up later.
void require_structure(const Json& study) {
  constexpr std::int64_t most_refine = 30;
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw InputError(what);
  };
  const auto check_level = [&](const Json& level, const char* value) {
    const Json& refine = level.at("refine");
    require(refine.is_number_integer() && refine >= 0 && refine <= most_refine,
            "'refine' is no whole number from 0 to 30");
    (void)level.at("step").get<double>();
    (void)level.at(value).get<double>();
  };
  for (const char* key : {"program", "scene"}) (void)study.at(key);
  for (const Json& run : study.at("runs")) check_level(run, "seconds");
  for (const auto& [name, quantity] : study.at("quantities").items()) {
    for (const char* kind : {"mesh", "step"}) {
      const Json& levels = quantity.at(kind).at("levels");
      require(levels.is_array() && !levels.empty(), "'levels' is no list");
      for (const Json& level : levels) check_level(level, "uncertainty");
    }
    if (quantity.contains("kernel")) {
      check_level(quantity["kernel"].at("levels").at(0), "uncertainty");
    }
    const Json& mesh = quantity.at("mesh");
    if (mesh.at("remark").get<std::string>().empty()) (void)mesh.at("order").get<double>();
  }
}

Json parsed(const std::string& path, const std::string& text) {
  try {
    Json study = Json::parse(text);
    require_structure(study);
    return study;
  } catch (const std::exception& error) {  // of the parser or of the checks above
    throw InputError(path + ": is not a stored convergence study: " + cut_short(error.what(), 200) +
                     "; make it anew with stylet converge --store");
  }
}

std::string fingerprint_of(Json study) {
  study.erase("fingerprint");
  return fingerprint(study.dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::string first_difference(const std::string& a, const std::string& b) {
  std::istringstream before(a);
  std::istringstream now(b);
  std::string x;
  std::string y;
  do {
    x.clear();
    y.clear();
    std::getline(before, x);
    std::getline(now, y);
  } while (x == y && (before || now));
  return "'" + x.substr(std::min(x.find_first_not_of(' '), x.size())) + "' there, '" +
         y.substr(std::min(y.find_first_not_of(' '), y.size())) + "' here";
}

}  // namespace

double Uncertainty::total() const {
  return std::hypot(std::hypot(mesh, step), kernel);
}

nlohmann::ordered_json json_of(const Uncertainty& uncertainty) {
  Json json{{"mesh", uncertainty.mesh}, {"step", uncertainty.step}};
  if (uncertainty.kernel > 0) json["kernel"] = uncertainty.kernel;
  json["total"] = uncertainty.total();
  return json;
}

Accuracy::Accuracy(const std::string& path, const std::string& text) : path_(path) {
  study_ = parsed(path, text);
  if (!study_.contains("fingerprint")) {
    throw InputError(path + " was stored without fingerprints, by an earlier version");
  }
  if (study_["fingerprint"] != fingerprint_of(study_)) {
    throw InputError(path + " was changed since it was stored");
  }
}

std::string Accuracy::mismatch(const Scene& scene, const std::string& mesh_fingerprint) const {
  const auto differs = [&](const char* key, const Json& now) { return study_[key] != now; };
  if (differs("program", STYLET_VERSION)) {
    return path_ + " is of version " + study_["program"].dump() + " of the program, this is " +
           STYLET_VERSION;
  }
  if (differs("scene", studied_text(scene))) {
    return path_ + " is of another scene: " +
           first_difference(study_["scene"].get<std::string>(), studied_text(scene));
  }
  if (differs("mesh_file", mesh_fingerprint)) {
    return path_ + " is of another mesh file: the bytes of " + mesh_path(scene) + " differ";
  }
  if (differs("solver_options", deciding_options())) {
    return path_ + " was computed with other solver options: " + study_["solver_options"].dump();
  }
  return {};
}

std::optional<Uncertainty> Accuracy::of(const std::string& quantity,
                                        int refine,
                                        double step) const {
  const auto& quantities = study_["quantities"];
  if (!quantities.contains(quantity)) return std::nullopt;
  const auto mesh = mesh_part(quantities[quantity]["mesh"], refine);
  const auto time = step_part(quantities[quantity]["step"], step);
  if (!mesh || !time) return std::nullopt;
  // The scene's own kernel is the first level.
  const auto& kernel = quantities[quantity];
  return Uncertainty{
      *mesh, *time,
      kernel.contains("kernel") ? kernel["kernel"]["levels"][0]["uncertainty"].get<double>() : 0};
}

StudiedLevel Accuracy::cheapest(double wanted) const {
  std::optional<StudiedLevel> best;
  StudiedLevel most_accurate;
  double least = std::numeric_limits<double>::infinity();
  for (const Json& run : study_["runs"]) {
    if (run.contains("kernel")) continue;  // not the scene's
    StudiedLevel level{
        run["refine"].get<int>(), run["step"].get<double>(), run["seconds"].get<double>(), {}};
    bool known = false;
    for (const auto& [quantity, unused] : study_["quantities"].items()) {
      if (!quantity.ends_with(".placement_error")) continue;
      const auto uncertainty = of(quantity, level.refine, level.step);
      known = uncertainty.has_value();
      if (!known) break;
      if (uncertainty->total() >= level.uncertainty.total()) level.uncertainty = *uncertainty;
    }
    if (!known) continue;
    const double total = level.uncertainty.total();
    if (total < least) {
      least = total;
      most_accurate = level;
    }
    if (total <= wanted && (!best || level.seconds < best->seconds)) best = level;
  }
  if (best) return *best;
  char text[200];
  std::snprintf(text, sizeof text,
                ": no studied level brings the placement error within %.3g mm; the best is %.3g mm "
                "(mesh.refine %d, time.step %.3g ms, %.3g s)",
                1e3 * wanted, 1e3 * least, most_accurate.refine, 1e3 * most_accurate.step,
                most_accurate.seconds);
  throw InputError(path_ + text + "; study finer ones: stylet converge --mesh-levels");
}

void seal_accuracy(Json& study, const std::string& mesh_fingerprint) {
  study["mesh_file"] = mesh_fingerprint;
  study["solver_options"] = deciding_options();
  study["fingerprint"] = fingerprint_of(study);
}

void require_own_accuracy(const std::string& path, const std::string& text) {
  const std::string end = "; it is not replaced: move it away";
  try {
    const Json study = parsed(path, text);
    if (!study.contains("fingerprint") || study["fingerprint"] == fingerprint_of(study)) return;
  } catch (const InputError& error) {
    throw InputError(error.what() + end);
  }
  throw InputError(path + " was changed since it was stored" + end);
}

std::vector<std::string> deciding_options() {
  auto options = solver_options();
  std::erase_if(options, [](const std::string& option) {
    return option.starts_with("-log_") || option.starts_with("-options_left") ||
           option.find("monitor") != std::string::npos ||
           option.find("_view") != std::string::npos ||
           option.find("_converged_reason") != std::string::npos;
  });
  return options;
}

std::string studied_text(Scene scene) {
  scene.mesh.refine = 0;
  scene.time.step = TimeParameters{}.step;
  scene.time.until_implanted = false;
  scene.output = {};
  scene.image.reset();
  scene.expect.clear();
  return to_yaml(scene);
}

std::string accuracy_path(const std::string& scene_file) {
  const std::filesystem::path path(scene_file);
  return (path.parent_path() / (path.stem().string() + ".accuracy.json")).string();
}

std::string with_uncertainty(double value,
                             const Uncertainty& uncertainty,
                             double factor,
                             const std::string& unit) {
  char text[120];
  const double total = factor * uncertainty.total();
  // Two digits of the uncertainty, and the value to the same place.
  const int digits =
      total > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(total))), 0, 6) : 6;
  std::snprintf(text, sizeof text, "%.*f ± %.*f %s (mesh %.*f, step %.*f", digits, factor * value,
                digits, total, unit.c_str(), digits, factor * uncertainty.mesh, digits,
                factor * uncertainty.step);
  std::string all = text;
  if (uncertainty.kernel > 0) {
    std::snprintf(text, sizeof text, ", kernel %.*f", digits, factor * uncertainty.kernel);
    all += text;
  }
  return all + ")";
}

}  // namespace stylet
