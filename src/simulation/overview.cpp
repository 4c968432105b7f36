#include "stylet/simulation/overview.hpp"

#include "stylet/base/text.hpp"
#include "stylet/needle/stops.hpp"
#include "stylet/simulation/needle_path.hpp"
#include "stylet/simulation/point_text.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stylet {

namespace {

std::string with(double value, double factor, const std::string& unit) {
  char text[40];
  std::snprintf(text, sizeof text, "%.4g %s", factor * value, unit.c_str());
  return text;
}

std::string length_text(double metres) {
  if (metres == 0) return "0";
  return std::abs(metres) < 0.01 ? with(metres, 1e3, "mm") : with(metres, 1e2, "cm");
}

std::string time_text(double seconds) {
  if (seconds == 0) return "0";
  return std::abs(seconds) < 1 ? with(seconds, 1e3, "ms") : with(seconds, 1, "s");
}

std::string pair_text(const Scene& scene, Vector2 v, const std::string& unit) {
  return stylet::pair_text(scene, v) + " " + unit;
}

std::string centimetres(const Scene& scene, ReferencePoint x) {
  return stylet::pair_text(scene, x, 1e2) + " cm";
}

class Overview {
 public:
  Overview(const Simulation& simulation, int n_ranks)
      : simulation_(simulation),
        scene_(simulation.scene()),
        mesh_(simulation.mesh()),
        n_ranks_(n_ranks) {
    for (const auto* names : {&mesh_.data().region_names, &mesh_.data().curve_names}) {
      for (const auto& name : *names) name_width_ = std::max(name_width_, name.size() + 2);
    }
  }

  std::string text() {
    add("mesh", std::to_string(mesh_.n_cells()) + " triangles, " + std::to_string(mesh_.n_nodes()) +
                    " nodes, worst quality " + with(simulation_.counts().worst_quality, 1, ""));
    add_regions();
    add_curves();
    add_body_forces();
    add_membrane();
    for (std::size_t i = 0; i < scene_.needles.size(); ++i) add_needle(i);
    if (scene_.start) {
      add("start", "t = " + time_text(simulation_.time()) + ", from " + scene_.start->from);
    }
    add_steps();
    add_sizes();
    return lines_;
  }

 private:
  void add(const std::string& title, std::string line) {
    constexpr std::size_t width = 12;
    line.erase(line.find_last_not_of(' ') + 1);
    const bool again = title == last_title_;
    last_title_ = title;
    std::string head = again ? "" : title;
    head.resize(std::max(width, head.size() + 2), ' ');
    lines_ += head + line + "\n";
  }

  static std::string column(std::string text, std::size_t width) {
    text.resize(std::max(width, text.size() + 2), ' ');
    return text;
  }

  void add_regions() {
    std::vector<double> areas(mesh_.data().region_names.size(), 0.0);
    for (int c = 0; c < mesh_.n_cells(); ++c) {
      areas[static_cast<std::size_t>(mesh_.region(c))] += mesh_.cell_measure(c);
    }
    for (const RegionTissue& region : scene_.tissue.regions) {
      const double area = areas[static_cast<std::size_t>(mesh_.region_index(region.region))];
      const LinearElastic& m = region.material;
      add("regions", column(region.region, name_width_) + column(with(area, 1e4, "cm2"), 11) +
                         "E " + with(m.youngs_modulus, 1e-3, "kPa") + ", nu " +
                         brief(m.poisson_ratio) + ", " + with(m.density, 1, "kg/m3"));
    }
  }

  /// What the scene says of a curve.
  [[nodiscard]] std::string condition_of(const std::string& curve) const {
    std::vector<std::string> said;
    for (const Support& support : scene_.supports) {
      if (support.curve != curve || support.kind == SupportKind::free) continue;
      said.emplace_back(support.kind == SupportKind::fixed ? "fixed" : "roller");
    }
    for (const PrescribedCurve& p : scene_.prescribed) {
      if (p.curve != curve) continue;
      const auto component = [](const std::optional<double>& value) {
        return value ? brief(1e3 * *value) : std::string("free");
      };
      std::string text = "moved by (";
      if (p.displacement[0] && p.displacement[1]) {
        text = "moved by " +
               pair_text(scene_, 1e3 * Vector2{*p.displacement[0], *p.displacement[1]}, "mm");
      } else {
        text += component(p.displacement[0]) + ", " + component(p.displacement[1]) + ") mm";
      }
      said.push_back(text + " from " + time_text(p.start) + " to " + time_text(p.start + p.ramp));
    }
    for (const Traction& t : scene_.tractions) {
      if (t.curve != curve) continue;
      said.push_back("loaded with " + pair_text(scene_, t.force, "N/m") + " from " +
                     time_text(t.start));
    }
    return said.empty() ? "free" : join(said);
  }

  void add_curves() {
    for (const std::string& curve : mesh_.data().curve_names) {
      double length = 0;
      bool outside = true;
      for (const int f : mesh_.facets_of(curve)) {
        const auto at = 2 * static_cast<std::size_t>(f);
        const int a = mesh_.data().facets[at];
        const int b = mesh_.data().facets[at + 1];
        length += distance(mesh_.point(a), mesh_.point(b));
        outside = outside && mesh_.cells_with(a, b).size() == 1;
      }
      const std::string condition = condition_of(curve);
      add("curves",
          column(curve, name_width_) + column(length_text(length), 11) +
              (condition == "free" && !outside ? "inside, without a condition" : condition));
    }
    for (const HeldCorner& corner : simulation_.body().conditions().held_corners()) {
      add("curves", "where '" + scene_.prescribed[corner.prescribed].curve +
                        "' meets a support, at " + centimetres(scene_, mesh_.point(corner.node)) +
                        ", the support holds");
    }
  }

  void add_body_forces() {
    for (const BodyForce& body : scene_.body_forces) {
      add("loads",
          "body force " + pair_text(scene_, body.force, "N/m3") + " from " + time_text(body.start));
    }
  }

  void add_membrane() {
    if (!scene_.membrane) return;
    add("membrane", std::to_string(simulation_.membrane().size()) + " corners, holds up to " +
                        with(scene_.membrane->puncture_force, 1, "N"));
  }

  void add_needle(std::size_t i) {
    const NeedleParameters& needle = scene_.needles[i];
    const NeedlePath path = find_path(scene_, mesh_, i);
    const std::string& name = needle.name;
    add(name, "enters at " + centimetres(scene_, path.entry.x) + ", cuts at " +
                  with(needle.cutting.cutting_force / needle.cutting.sharpness, 1, "N") +
                  (needle.friction ? "" : ", without friction"));
    std::vector<std::string> pieces;
    for (const PathPiece& piece : path.pieces) {
      pieces.push_back(piece.region + " from " + length_text(piece.from) + " to " +
                       length_text(piece.to));
    }
    add(name, "way: " + join(pieces) + " deep; the tissue ends at " + length_text(path.end));
    if (scene_.membrane) {
      std::vector<std::string> depths;
      for (const double depth : crossings(path, needle.height, scene_.membrane->polygon)) {
        depths.push_back(length_text(depth));
      }
      add(name, depths.empty() ? "crosses no membrane" : "meets the membrane at " + join(depths));
    }
    const auto travels = travels_of(needle.motion, Axis::along_sign);
    for (std::size_t k = 0; k < travels.size(); ++k) {
      add(name, action_text(needle.motion[k], travels[k], path.skin));
    }
  }

  [[nodiscard]] std::string action_text(const Action& action, const Travel& travel, double skin) {
    const double from = along_of(travel.from, skin);
    const double to = along_of(travel.to, skin);
    const auto end = [&] {
      return "depth " + length_text(to - skin) + ", position " +
             length_text(Axis::along_sign * to) + steps_text(std::abs(to - from) / action.speed);
    };
    switch (action.kind) {
      case ActionKind::insert:
        return "insert   to " + end();
      case ActionKind::retract:
        return "retract  " +
               (travel.all_out ? "all the way out" + steps_text(std::abs(to - from) / action.speed)
                               : "to " + end());
      case ActionKind::implant:
        return "implant  at depth " + length_text(from - skin) +
               (action.target.empty() ? "" : ", for '" + action.target + "'");
      case ActionKind::hold:
        return "hold     " + steps_text(*action.duration).substr(2);
      case ActionKind::settle:
        break;
    }
    open_ended_ = open_ended_ || !action.duration;
    return action.duration ? "settle   " + steps_text(*action.duration).substr(2)
                           : "settle   until all tissue is slower than " +
                                 brief(action.speed_tolerance) + " m/s";
  }

  std::string steps_text(double duration) {
    constexpr double round_off = 1e-9;
    const double steps = std::ceil(duration / scene_.time.step - round_off);
    n_steps_ += steps;
    return ": " + time_text(duration) + ", " + brief(steps) + (steps == 1 ? " step" : " steps");
  }

  void add_steps() {
    const TimeParameters& time = scene_.time;
    std::string line;
    switch (time.method) {
      case TimeMethod::implicit_newmark:
        line = "implicit";
        break;
      case TimeMethod::quasi_static:
        line = "quasi-static";
        break;
      case TimeMethod::explicit_newmark:
        line = "explicit";
        break;
    }
    line += ", ";
    if (!simulation_.pierces()) (void)steps_text(time.duration);
    if (scene_.procedure) (void)steps_text(expected_time(scene_, mesh_));
    line += brief(n_steps_) + (n_steps_ == 1 ? " step of " : " steps of ") + time_text(time.step);
    if (time.method == TimeMethod::explicit_newmark) {
      const double stable = simulation_.counts().stable_step;
      sub_steps_ = std::max(1.0, std::round(time.step / stable));
      line += ", each in " + brief(sub_steps_) + " of at most " + time_text(stable);
    }
    if (open_ended_ && !time.until_implanted) line += ", and as many as it takes to settle";
    if (time.until_implanted) line += " at most, up to the last implant";
    add("time", line);
  }

  // As measured on one core of an ordinary machine; more ranks help large meshes only.
  void add_sizes() {
    const double n = mesh_.n_cells();
    constexpr double program = 50e6;
    constexpr double a_triangle = 2300;
    add("size", "about " + bytes_text((program + a_triangle * n) * n_ranks_) + " of memory, " +
                    bytes_text(disk()) + " on disk");
    double a_step = 2.1e-7 * n;
    if (scene_.time.method == TimeMethod::quasi_static) a_step = 7e-8 * n;
    if (scene_.time.method == TimeMethod::explicit_newmark) {
      a_step = sub_steps_ * (1.4e-5 + 4e-9 * n);
    }
    char seconds[40];
    std::snprintf(seconds, sizeof seconds, "%.1g s", a_step * n_steps_ + 2e-6 * n);
    add("takes", "about " + std::string(seconds) +
                     (open_ended_ && !scene_.time.until_implanted ? ", settling apart," : "") +
                     " on one core; a third or thrice as long on another machine");
  }

  [[nodiscard]] double disk() const {
    constexpr double a_number = 20;  // as text
    double bytes = 20e3;
    const double columns = 20 + 2.0 * static_cast<double>(scene_.probes.size()) +
                           2.0 * static_cast<double>(scene_.prescribed.size());
    if (scene_.output.history) bytes += n_steps_ * columns * a_number;
    if (scene_.output.snapshots) {
      const double snapshots =
          std::min(n_steps_, n_steps_ * scene_.time.step / *scene_.output.snapshots) + 2;
      bytes += snapshots * (68.0 * mesh_.n_nodes() + 56.0 * mesh_.n_cells() + 60e3);
    }
    return bytes;
  }

  static std::string bytes_text(double bytes) {
    return bytes < 1e9 ? with(std::max(0.1, 1e-6 * bytes), 1, "MB") : with(bytes, 1e-9, "GB");
  }

  const Simulation& simulation_;
  const Scene& scene_;
  const Mesh& mesh_;
  int n_ranks_;
  std::size_t name_width_ = 8;
  double n_steps_ = 0;
  double sub_steps_ = 1;
  bool open_ended_ = false;
  std::string last_title_;
  std::string lines_;
};

}  // namespace

std::string overview(const Simulation& simulation, int n_ranks) {
  return Overview(simulation, n_ranks).text();
}

}  // namespace stylet
