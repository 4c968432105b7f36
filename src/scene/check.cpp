#include "stylet/scene/check.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/scene/quantities.hpp"
#include "stylet/scene/requirement.hpp"
#include "stylet/scene/schema.hpp"
#include "stylet/scene/schema_needle.hpp"
#include "stylet/scene/writer.hpp"

#include <algorithm>
#include <numbers>
#include <set>

namespace stylet {

namespace {

template <class T>
std::vector<std::string> names_of(const std::vector<T>& items, std::string T::*name) {
  std::vector<std::string> names;
  std::ranges::transform(items, std::back_inserter(names), name);
  return names;
}

/// True if a retract without an end is the last that the needle does but for waiting.
bool ends_outside(const std::vector<Action>& motion) {
  for (auto action = motion.rbegin(); action != motion.rend(); ++action) {
    if (action->kind == ActionKind::retract) return !action->depth && !action->position;
    if (action->kind == ActionKind::insert) break;
  }
  return false;
}

class Rules {
 public:
  Rules(const Scene& scene, const Node& document) : scene_(scene), document_(document) {}

  void check() const {
    check_dimension(scene_, document_);
    check_mesh();
    check_tissue();
    check_loads();
    for (std::size_t i = 0; i < scene_.needles.size(); ++i) {
      check_laws(scene_.needles[i], item("needles", i));
      check_motion(scene_.needles[i].motion, item("needles", i) + ".motion");
    }
    check_needles_leave();
    check_names();
    check_time();
    check_expect();
    check_procedure();
    check_image();
  }

  void check_laws(const NeedleParameters& needle, const std::string& path) const {
    check_cutting(needle.cutting, path + ".cutting");
    check_increment(needle, path);
    check_friction(needle.friction, path + ".friction");
  }

 private:
  void require(bool kept, const std::string& path, const std::string& allowed) const {
    stylet::require(document_, kept, path, allowed);
  }

  void require_corners(const std::vector<ReferencePoint>& points,
                       std::size_t least,
                       const std::string& path) const {
    require(points.size() >= least, path, "at least " + std::to_string(least) + " points");
  }

  void check_mesh() const {
    if (const auto* box = std::get_if<BoxMesh>(&scene_.mesh.source)) {
      require(scene_.mesh.scale == 1, "mesh.scale", "only with mesh.file");
      require_unique(names_of(box->inner_regions, &SolidRegion::name), "mesh.box.inner_regions",
                     true);
    }
    const auto* rectangle = std::get_if<RectangleMesh>(&scene_.mesh.source);
    if (!rectangle) return;
    require(scene_.mesh.scale == 1, "mesh.scale", "only with mesh.file");
    for (std::size_t i = 0; i < rectangle->inner_regions.size(); ++i) {
      const auto& outline = rectangle->inner_regions[i].outline;
      const auto* polygon = std::get_if<std::vector<ReferencePoint>>(&outline);
      const std::string path = item("mesh.rectangle.inner_regions", i);
      if (polygon) require_corners(*polygon, 3, path + ".polygon");
    }
    for (std::size_t i = 0; i < rectangle->curves.size(); ++i) {
      const std::string path = item("mesh.rectangle.curves", i);
      require_corners(rectangle->curves[i].points, 2, path + ".points");
      const std::set<std::string> sides = {"left", "right", "bottom", "top"};
      require(!sides.contains(rectangle->curves[i].name), path + ".name",
              "a name that is not a side of the rectangle");
    }
  }

  void check_tissue() const {
    require(!scene_.tissue.regions.empty(), "tissue.regions", "at least one region");
    const TimeMethod method = scene_.time.method;
    for (const RegionTissue& region : scene_.tissue.regions) {
      require(region.material.density > 0 || method == TimeMethod::quasi_static,
              below("tissue.regions", region.region) + ".density",
              "> 0 kg/m^3 unless time.method is quasi_static");
    }
    require(method != TimeMethod::explicit_newmark || scene_.tissue.mass == MassKind::lumped,
            "tissue.mass", "lumped, because time.method is explicit");
    if (!scene_.membrane || !scene_.membrane->region.empty()) return;
    if (!scene_.membrane->surface.empty()) return;
    require_corners(scene_.membrane->polygon, 3, "membrane.polygon");
  }

  void check_loads() const {
    require_one_a_curve(scene_.tractions, "loads.traction");
    require_one_a_curve(scene_.prescribed, "prescribed");
    for (std::size_t i = 0; i < scene_.prescribed.size(); ++i) {
      const auto& curve = scene_.prescribed[i].curve;
      const auto support = std::ranges::find(scene_.supports, curve, &Support::curve);
      require(support == scene_.supports.end() || support->kind != SupportKind::fixed,
              item("prescribed", i) + "." + boundary(),
              "a " + boundary() + " that is not held; supports." + curve + " is fixed");
      const auto& displacement = scene_.prescribed[i].displacement;
      const auto given = [](const std::optional<double>& component) {
        return component.has_value();
      };
      require(std::ranges::any_of(displacement, given), item("prescribed", i) + ".displacement",
              "at least one component that is not null");
      require(scene_.needle_angle == std::numbers::pi || std::ranges::all_of(displacement, given),
              item("prescribed", i) + ".displacement",
              "both components, because needle_angle turns them");
    }
  }

  [[nodiscard]] std::string boundary() const { return scene_.dim() == 2 ? "curve" : "surface"; }

  // Whether a second one adds to the first or takes its place, the scene would not say.
  template <class T>
  void require_one_a_curve(const std::vector<T>& items, const std::string& list) const {
    for (std::size_t i = 0; i < items.size(); ++i) {
      const auto first = std::ranges::find(items, items[i].curve, &T::curve) - items.begin();
      require(static_cast<std::size_t>(first) == i, item(list, i) + "." + boundary(),
              "one entry a " + boundary() + ", and " + item(list, static_cast<std::size_t>(first)) +
                  " is of this one");
      require(scene_.time.duration == 0 || items[i].start <= scene_.time.duration,
              item(list, i) + ".start",
              "at most time.duration, which is " + exact(scene_.time.duration) + " s");
    }
  }

  void check_cutting(const CuttingParameters& cutting, const std::string& path) const {
    const bool is_explicit = scene_.time.method == TimeMethod::explicit_newmark;
    // In the plane the tip's place at the end of a step does not feel the forces of its end.
    require(!is_explicit || scene_.dim() == 3 || cutting.law != CuttingLaw::consistent,
            path + ".law", "lagged, increment, because time.method is explicit");
    require(cutting.law != CuttingLaw::increment || cutting.increment > 0, path + ".increment",
            "a length > 0 m, because the law is increment");
    require(cutting.stiffness_share == 0 || cutting.reference_youngs_modulus > 0,
            path + ".reference_youngs_modulus",
            "a stiffness > 0 Pa, because stiffness_share is not 0");
  }

  // The increment law cuts once a step: a shorter increment could not keep up with the needle.
  void check_increment(const NeedleParameters& needle, const std::string& path) const {
    if (needle.cutting.law != CuttingLaw::increment) return;
    if (scene_.time.method == TimeMethod::explicit_newmark) return;  // its steps are far shorter
    for (const Action& action : needle.motion) {
      const double travel = action.speed * scene_.time.step;
      constexpr double round_off = 1e-9;  // of the product, and of the number that is printed
      require(
          action.kind != ActionKind::insert || needle.cutting.increment >= (1 - round_off) * travel,
          path + ".cutting.increment",
          "at least " + ten_digits(travel) +
              " m, which is what the needle travels in a time.step of " +
              ten_digits(scene_.time.step) + " s");
    }
  }

  void check_friction(const std::optional<FrictionParameters>& friction,
                      const std::string& path) const {
    if (!friction) return;
    require(friction->static_force >= friction->kinetic_force, path + ".static_force",
            ">= kinetic_force, which is " + exact(friction->kinetic_force) + " N/m");
    require(friction->slip_speed > friction->stick_speed, path + ".slip_speed",
            "> stick_speed, which is " + exact(friction->stick_speed) + " m/s");
  }

  void check_motion(const std::vector<Action>& motion, const std::string& path) const {
    require(!motion.empty(), path, "at least one action");
    require(motion.front().kind == ActionKind::insert, item(path, 0), "insert comes first");
    const auto targets = names_of(scene_.targets, &Target::name);
    bool is_out = false;
    for (std::size_t i = 0; i < motion.size(); ++i) {
      const Action& action = motion[i];
      if (action.kind == ActionKind::insert) is_out = false;
      if (action.kind == ActionKind::implant) {
        require(!is_out, item(path, i), "no implant once the needle is all the way out");
        require(std::ranges::find(targets, action.target) != targets.end(),
                item(path, i) + ".implant.target",
                targets.empty() ? "a name in targets, which is empty" : join(targets));
      }
      if (action.kind == ActionKind::retract) {
        require(!is_out, item(path, i), "no retract once the needle is all the way out");
        is_out = !action.depth && !action.position;
      }
    }
  }

  // The next needle would take the place of one that is still in, which would vanish.
  void check_needles_leave() const {
    for (std::size_t i = 0; i + 1 < scene_.needles.size(); ++i) {
      const auto& motion = scene_.needles[i].motion;
      require(ends_outside(motion), item("needles", i) + ".motion",
              "a retract all the way out at the end, because " + scene_.needles[i + 1].name +
                  " enters next");
    }
  }

  void require_unique(const std::vector<std::string>& names,
                      const std::string& list,
                      bool is_list) const {
    std::set<std::string> seen;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string path = is_list ? item(list, i) + ".name" : below(list, names[i]);
      require(seen.insert(names[i]).second, path, "a name that is not taken");
    }
  }

  void check_names() const {
    require_unique(names_of(scene_.needles, &NeedleParameters::name), "needles", true);
    require_unique(names_of(scene_.tissue.regions, &RegionTissue::region), "tissue.regions", false);
    require_unique(names_of(scene_.supports, &Support::curve), "supports", false);
    require_unique(names_of(scene_.targets, &Target::name), "targets", false);
    require_unique(names_of(scene_.probes, &Probe::name), "probes", false);
    if (const auto* rectangle = std::get_if<RectangleMesh>(&scene_.mesh.source)) {
      const std::string path = "mesh.rectangle.";
      const auto regions = names_of(rectangle->inner_regions, &InnerRegion::name);
      require_unique(regions, path + "inner_regions", true);
      require_unique(names_of(rectangle->curves, &InnerCurve::name), path + "curves", true);
    }
  }

  void check_time() const {
    const TimeParameters& time = scene_.time;
    if (scene_.needles.empty() && !scene_.procedure) {
      require(time.duration > 0, "time.duration", "> 0 s in a scene without needles");
      require(time.step <= time.duration || time.method == TimeMethod::explicit_newmark,
              "time.step", "at most time.duration, which is " + exact(time.duration) + " s");
    } else {
      require(time.duration == 0, "time.duration",
              "only in a scene without needles; the motion of a needle sets its own end");
    }
    if (!time.until_implanted) return;
    bool any_implant = false;
    for (const NeedleParameters& needle : scene_.needles) {
      bool retracted = false;
      for (const Action& action : needle.motion) {
        if (action.kind == ActionKind::retract) retracted = true;
        if (action.kind != ActionKind::implant) continue;
        any_implant = true;
        require(!retracted, "time.until",
                "settled, because " + needle.name +
                    " implants after a retract and stopping early would not be exact");
      }
    }
    require(any_implant, "time.until", "settled, because no needle implants");
    const std::string why = why_not_at_rest(scene_);
    require(why.empty(), "time.until", "settled, because " + why);
  }

  void check_expect() const {
    if (scene_.expect.empty()) return;
    const auto quantities = names_of(summary_quantities(scene_), &SummaryQuantity::path);
    const Expectation open;
    for (std::size_t i = 0; i < scene_.expect.size(); ++i) {
      const Expectation& expect = scene_.expect[i];
      const std::string path = item("expect", i);
      if (scene_.procedure) {  // its seeds are known in the run
        require(unit_of_quantity(expect.quantity).has_value(), path + ".quantity",
                "a number that a run has, such as seeds.0.world.0");
      } else {
        require(std::ranges::find(quantities, expect.quantity) != quantities.end(),
                path + ".quantity",
                "a number that a run of this scene has, such as '" +
                    nearest(expect.quantity, quantities) + "'; all: " + join(quantities));
      }
      require(expect.min != open.min || expect.max != open.max, path, "a min or a max, or both");
      require(expect.min <= expect.max, path + ".max", ">= min, which is " + exact(expect.min));
    }
  }

  void check_procedure() const {
    if (!scene_.procedure) return;
    require(scene_.needles.empty(), "needles",
            "none, because the needles of a recorded procedure are in procedure.file");
  }

  void check_image() const {
    if (!scene_.image) return;
    const bool is_file = !scene_.image->file.empty();
    const std::string allowed = is_file ? "where the picture of image.file lies"
                                        : "only with image.file; a picture that is made covers the "
                                          "tissue";
    require(scene_.image->origin.has_value() == is_file, "image.origin", allowed);
    require(scene_.image->size.has_value() == is_file, "image.size", allowed);
  }

  const Scene& scene_;
  const Node& document_;
};

}  // namespace

void require(const Node& document, bool kept, const std::string& path, const std::string& allowed) {
  if (kept) return;
  const Node& node = closest(document, path);
  if (node.path == path) refuse(node, allowed);
  refuse_missing(node, path, allowed);
}

std::string item(const std::string& list, std::size_t i) {
  return list + "." + std::to_string(i);
}

void check_rules(const Scene& scene, const Node& document) {
  Rules(scene, document).check();
}

std::string why_not_at_rest(const Scene& scene) {
  const auto acts = [](const auto& load) { return norm(load.force.vector()) != 0; };
  if (std::ranges::any_of(scene.body_forces, acts)) return "loads.body lasts";
  if (std::ranges::any_of(scene.tractions, acts)) return "loads.traction lasts";
  for (const PrescribedCurve& prescribed : scene.prescribed) {
    if (moves(prescribed)) return "the displacement of '" + prescribed.curve + "' lasts";
  }
  if (scene.needles.empty()) return {};
  const NeedleParameters& last = scene.needles.back();
  // A list that ends with its seed says nothing against the rest that follows.
  if (last.motion.back().kind == ActionKind::implant) return {};
  if (!ends_outside(last.motion)) return last.name + " is not all the way out at the end";
  const Action& end = last.motion.back();
  if (end.kind != ActionKind::settle || end.duration) {
    return last.name + " does not end with a settle without duration, so the tissue may still move";
  }
  return {};
}

bool hides_places(const Scene& scene) {
  return scene.dim() == 3 && !scene.needles.empty() && !scene.time.until_implanted &&
         !ends_outside(scene.needles.back().motion);
}

void refuse_key(const Scene& scene, const std::string& path, const std::string& message) {
  const std::string& where = closest(scene.document, path).where;
  throw InputError((where.empty() ? scene.file : where) + ": key '" + path + "': " + message);
}

void require_places(const Scene& scene) {
  if (!hides_places(scene)) return;
  refuse_key(scene, "needles." + std::to_string(scene.needles.size() - 1) + ".motion",
             "the needle is still in at the end, where the mesh does not tell in space where seeds "
             "are; allowed: "
             "a retract all the way out at the end");
}

void check_needle(const Scene& scene, const NeedleParameters& needle) {
  Scene alone;
  alone.file = scene.file;
  alone.mesh = scene.mesh;
  alone.tissue = scene.tissue;
  alone.time = scene.time;
  alone.time.duration = 0;
  alone.time.until_implanted = false;
  alone.needles = {needle};
  // The hand's orders are its motion; of those to come nothing is known.
  Action insert;
  insert.kind = ActionKind::insert;
  insert.speed = std::numeric_limits<double>::min();
  insert.depth = 0;
  alone.needles.front().motion = {insert};
  check(alone);
}

void check(const Scene& scene) {
  const Node document = to_document(scene);
  Scene copy;
  scene_codec().read(document, copy);
  check_rules(scene, document);
}

}  // namespace stylet
