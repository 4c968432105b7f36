// What a convergence study of a scene says about the numbers of a run of the same scene. The study
// stands beside the scene: prostate.yaml, prostate.accuracy.json.
#pragma once

#include "stylet/scene/scene.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace stylet {

/// Half widths of the band that should hold the value without numerical error, in the unit of the value.
struct Uncertainty {
  double mesh = 0;
  double step = 0;
  double kernel = 0;  ///< of needles in space

  /// Root of the sum of squares: they have nothing to do with each other.
  [[nodiscard]] double total() const;
};

/// mesh, step, kernel if there is one, and total.
[[nodiscard]] nlohmann::ordered_json json_of(const Uncertainty& uncertainty);

/// A level that was studied, and what it costs.
struct StudiedLevel {
  int refine = 0;
  double step = 0;     ///< s
  double seconds = 0;  ///< wall time on the machine of the study
  Uncertainty uncertainty;
};

class Accuracy {
 public:
  /// Throws InputError if the text is not that of a study, was stored without fingerprints, or was
  /// changed since.
  Accuracy(const std::string& path, const std::string& text);

  /// Why the study does not hold for a scene whose mesh file has this fingerprint; empty if it does.
  /// mesh.refine, time.step, time.until, output and expect may differ.
  [[nodiscard]] std::string mismatch(const Scene& scene, const std::string& mesh_fingerprint) const;
  /// Of a number of summary.json at a level of refinement; none where the study does not say: a
  /// coarser mesh or a longer step than it has, another quantity.
  [[nodiscard]] std::optional<Uncertainty> of(const std::string& quantity,
                                              int refine,
                                              double step) const;
  /// The cheapest studied level that brings the placement error of every seed within `wanted` (m).
  /// Throws InputError that names the best one if none does.
  [[nodiscard]] StudiedLevel cheapest(double wanted) const;

 private:
  std::string path_;
  nlohmann::ordered_json study_;
};

/// Adds the study's identity to its text: program, solver options, mesh file, and a fingerprint of all
/// of it.
void seal_accuracy(nlohmann::ordered_json& study, const std::string& mesh_fingerprint);

/// Throws InputError unless this program wrote the text, now or before there were fingerprints.
void require_own_accuracy(const std::string& path, const std::string& text);

/// The options after -- but for those that only show something.
[[nodiscard]] std::vector<std::string> deciding_options();

/// What two scenes have to share for the study of one to hold for the other.
[[nodiscard]] std::string studied_text(Scene scene);

/// Where the study of a scene file is stored.
[[nodiscard]] std::string accuracy_path(const std::string& scene_file);

/// '6.196 ± 0.31 mm (mesh 0.31, step 0.01)', with the kernel if there is one, of values in metres; for newtons factor 1 and 'N'.
[[nodiscard]] std::string with_uncertainty(double value,
                                           const Uncertainty& uncertainty,
                                           double factor,
                                           const std::string& unit);

}  // namespace stylet
