#include "stylet/simulation/overview.hpp"

#include "stylet/base/text.hpp"
#include "stylet/needle/stops.hpp"
#include "stylet/simulation/needle_path.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/simulation/room.hpp"
#include "stylet/simulation/space_way.hpp"
#include "stylet/solvers/whole_solver.hpp"

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

std::string vector_text(const Scene& scene, Vector3 v, const std::string& unit) {
  return stylet::vector_text(scene, v) + " " + unit;
}

std::string centimetres(const Scene& scene, ReferencePlace x) {
  return stylet::vector_text(scene, x, 1e2) + " cm";
}

class Overview {
 public:
  Overview(const Simulation& simulation, int n_ranks, const Timing* measured)
      : simulation_(simulation),
        scene_(simulation.scene()),
        mesh_(simulation.mesh()),
        n_ranks_(n_ranks),
        measured_(measured),
        in_space_(scene_.dim() == 3) {
    for (const auto* names : {&mesh_.data().region_names, &mesh_.data().curve_names}) {
      for (const auto& name : *names) name_width_ = std::max(name_width_, name.size() + 2);
    }
  }

  std::string text() {
    add("mesh", std::to_string(mesh_.n_cells()) + (in_space_ ? " tetrahedra, " : " triangles, ") +
                    std::to_string(mesh_.n_nodes()) + " nodes, worst quality " +
                    with(simulation_.counts().worst_quality, 1, ""));
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
      add("regions", column(region.region, name_width_) +
                         column(in_space_ ? with(area, 1e6, "cm3") : with(area, 1e4, "cm2"), 11) +
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
      std::string text = "moved by ";
      if (!in_space_ && p.displacement[0] && p.displacement[1]) {
        text += vector_text(scene_, 1e3 * Vector3{*p.displacement[0], *p.displacement[1]}, "mm");
      } else {
        for (std::size_t k = 0; k < p.displacement.size(); ++k) {
          text += (k == 0 ? "(" : ", ") + component(p.displacement[k]);
        }
        text += ") mm";
      }
      said.push_back(text + " from " + time_text(p.start) + " to " + time_text(p.start + p.ramp));
    }
    for (const Traction& t : scene_.tractions) {
      if (t.curve != curve) continue;
      said.push_back("loaded with " +
                     vector_text(scene_, t.force.vector(), in_space_ ? "Pa" : "N/m") + " from " +
                     time_text(t.start));
    }
    return said.empty() ? "free" : join(said);
  }

  /// Whether one cell only has this facet.
  [[nodiscard]] bool is_outside(int f) const {
    const auto nodes = mesh_.facet(f);
    const std::vector<int> all = mesh_.cells_with(nodes[0], nodes[1]);
    if (!in_space_) return all.size() == 1;
    std::vector<int> both;
    std::ranges::set_intersection(all, mesh_.cells_around(nodes[2]), std::back_inserter(both));
    return both.size() == 1;
  }

  void add_curves() {
    for (const std::string& curve : mesh_.data().curve_names) {
      double length = 0;
      bool outside = true;
      for (const int f : mesh_.facets_of(curve)) {
        length += mesh_.facet_measure(f);
        outside = outside && is_outside(f);
      }
      const std::string condition = condition_of(curve);
      add(in_space_ ? "surfaces" : "curves",
          column(curve, name_width_) +
              column(in_space_ ? with(length, 1e4, "cm2") : length_text(length), 11) +
              (condition == "free" && !outside ? "inside, without a condition" : condition));
    }
    for (const HeldCorner& corner : simulation_.body().conditions().held_corners()) {
      add(in_space_ ? "surfaces" : "curves",
          "where '" + scene_.prescribed[corner.prescribed].curve + "' meets a support, at " +
              centimetres(scene_, mesh_.place(corner.node)) + ", the support holds");
    }
  }

  void add_body_forces() {
    for (const BodyForce& body : scene_.body_forces) {
      add("loads", "body force " + vector_text(scene_, body.force.vector(), "N/m3") + " from " +
                       time_text(body.start));
    }
  }

  void add_membrane() {
    if (!scene_.membrane) return;
    const std::string made_of =
        in_space_ ? std::to_string(membrane_surface(scene_, mesh_).size()) + " triangles"
                  : std::to_string(simulation_.membrane().size()) + " corners";
    add("membrane", made_of + ", holds up to " + with(scene_.membrane->puncture_force, 1, "N"));
  }

  void add_needle(std::size_t i) {
    const NeedleParameters& needle = scene_.needles[i];
    const NeedlePath path = find_path(scene_, mesh_, i);
    const std::string& name = needle.name;
    add(name, "enters at " + centimetres(scene_, path.skin_point) + ", cuts at " +
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
      const auto met = in_space_ ? surface_crossings(membrane_surface(scene_, mesh_),
                                                     path.skin_point, path.direction, path.deepest)
                                 : crossings(path, needle.height, scene_.membrane->polygon);
      for (const double depth : met) {
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
      return "depth " + length_text(to - skin) +
             (in_space_ ? "" : ", position " + length_text(Axis::along_sign * to)) +
             steps_text(std::abs(to - from) / action.speed);
    };
    switch (action.kind) {
      case ActionKind::insert:
        return "insert   to " + end();
      case ActionKind::retract:
        return "retract  " +
               (travel.all_out ? "all the way out" + steps_text(std::abs(to - from) / action.speed)
                               : "to " + end());
      case ActionKind::implant:
        n_implanted_ = n_steps_;
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
    if (time.until_implanted) n_steps_ = n_implanted_;
    if (!simulation_.pierces()) (void)steps_text(time.duration);
    if (scene_.procedure) (void)steps_text(expected_time(scene_, mesh_));
    line += brief(n_steps_) + (n_steps_ == 1 ? " step of " : " steps of ") + time_text(time.step);
    if (time.method == TimeMethod::explicit_newmark) {
      const double stable = simulation_.counts().stable_step;
      sub_steps_ = std::max(1.0, std::round(time.step / stable));
      line += ", each in " + brief(sub_steps_) + " of at most " + time_text(stable);
    }
    if (open_ended_ && !time.until_implanted) line += ", and as many as it takes to settle";
    if (time.until_implanted) line += ", up to the last implant";
    add("time", line);
  }

  void add_measured() {
    add("size", bytes_text(measured_->memory) + " of memory, measured; about " +
                    bytes_text(disk()) + " on disk");
    const std::string settling =
        open_ended_ && !scene_.time.until_implanted && !measured_->whole ? ", settling apart" : "";
    const auto made = static_cast<double>(measured_->steps);
    const double n_steps = measured_->whole ? made : std::max(made, n_steps_);
    const double total = measured_->so_far + (n_steps - made) * measured_->a_step;
    char text[200];
    std::snprintf(text, sizeof text,
                  "%s%.2g s%s: %lld steps have taken %.2g s, the later %.2g ms each",
                  measured_->whole ? "" : "about ", total, settling.c_str(), measured_->steps,
                  measured_->so_far, 1e3 * measured_->a_step);
    add("takes", text);
  }

  // As measured on one core of an ordinary machine; more ranks help large meshes only.
  void add_sizes() {
    if (measured_ != nullptr) return add_measured();
    const double n = mesh_.n_cells();
    constexpr double program = 50e6;
    constexpr double a_triangle = 2300;
    const double memory = in_space_ ? bytes_needed(scene_, n, n_ranks_, memory_for_solvers())
                                    : program + a_triangle * n;
    add("size", "about " + bytes_text(memory * n_ranks_) + " of memory, " + bytes_text(disk()) +
                    " on disk");
    const auto [set_up, a_step] = in_space_ ? seconds_in_space(n) : seconds_in_the_plane(n);
    char seconds[40];
    std::snprintf(seconds, sizeof seconds, "%.1g s", a_step * n_steps_ + set_up);
    add("takes", "about " + std::string(seconds) +
                     (open_ended_ && !scene_.time.until_implanted ? ", settling apart," : "") +
                     " on one core; a third or thrice as long on another machine");
  }

  // Of the set-up, and of a step.
  [[nodiscard]] std::pair<double, double> seconds_in_the_plane(double n) const {
    double a_step = 2.1e-7 * n;
    if (scene_.time.method == TimeMethod::quasi_static) a_step = 7e-8 * n;
    if (scene_.time.method == TimeMethod::explicit_newmark) {
      a_step = sub_steps_ * (1.4e-5 + 4e-9 * n);
    }
    return {2e-6 * n, a_step};
  }

  [[nodiscard]] std::pair<double, double> seconds_in_space(double n) const {
    const bool averages = scene_.tissue.formulation == Formulation::p1_averaged;
    const double row = averages ? 180 : mesh_.is_quadratic() ? 82 : 42;
    const double n_dofs = 3.0 * mesh_.n_nodes();
    const double set_up = (averages ? 2e-5 : mesh_.is_quadratic() ? 7e-5 : 7e-6) * n;
    if (scene_.time.method == TimeMethod::explicit_newmark) {
      return {set_up, sub_steps_ * 2e-9 * row * n_dofs};
    }
    const double bytes = factor_bytes(3, n_dofs, row);  // made, and read twice a step
    return {set_up + 4e-9 * bytes, 1.7e-10 * bytes};
  }

  [[nodiscard]] double disk() const {
    constexpr double a_number = 13;  // as text
    double bytes = 20e3;
    const double n_vectors = static_cast<double>(scene_.probes.size() + scene_.prescribed.size());
    const double columns = 20 + scene_.dim() * n_vectors;
    if (scene_.output.history) bytes += n_steps_ * columns * a_number;
    if (scene_.output.snapshots) {
      const double snapshots =
          std::min(n_steps_, n_steps_ * scene_.time.step / *scene_.output.snapshots) + 2;
      bytes +=
          snapshots * (60.0 * mesh_.n_nodes() + (in_space_ ? 71.0 : 43.0) * mesh_.n_cells() + 7e3);
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
  const Timing* measured_;
  bool in_space_;
  std::size_t name_width_ = 8;
  double n_steps_ = 0;
  double n_implanted_ = 0;  ///< of them up to the last implant
  double sub_steps_ = 1;
  bool open_ended_ = false;
  std::string last_title_;
  std::string lines_;
};

}  // namespace

std::string overview(const Simulation& simulation, int n_ranks, const Timing* measured) {
  return Overview(simulation, n_ranks, measured).text();
}

}  // namespace stylet
