// Scenes in the plane and scenes in space: what belongs to which.
#include "stylet/base/index.hpp"
#include "stylet/base/text.hpp"
#include "stylet/scene/requirement.hpp"

#include <algorithm>
#include <numbers>

namespace stylet {

namespace {

// A narrower disc would move like a needle thinner than this one.
constexpr double least_kernel = 1.3;

class DimensionRules {
 public:
  DimensionRules(const Scene& scene, const Node& document)
      : scene_(scene), document_(document), plane_(scene.tissue.plane.has_value()) {}

  void check() const {
    const bool is_box = std::holds_alternative<BoxMesh>(scene_.mesh.source);
    const bool is_rectangle = std::holds_alternative<RectangleMesh>(scene_.mesh.source);
    require(!is_box || !plane_, "tissue.plane", "no plane, because mesh.box is in space");
    require(!plane_ || scene_.tissue.formulation != Formulation::p2, "tissue.formulation",
            "p1, p1_averaged, because p2 is an element of space (without tissue.plane): needles "
            "move nodes and flip edges of linear triangles");
    require(plane_ || !is_rectangle, "tissue.plane", "stress, strain");
    const auto in_space = [](const NeedleParameters& needle) {
      return needle.space.entry.has_value();
    };
    require(
        plane_ || is_box || scene_.needles.empty() || std::ranges::any_of(scene_.needles, in_space),
        "tissue.plane",
        "stress, strain, because the scene's needles have height; in space they have entry");
    plane_ ? check_plane() : check_space();
    check_components();
  }

 private:
  void require(bool kept, const std::string& path, const std::string& allowed) const {
    stylet::require(document_, kept, path, allowed);
  }
  [[nodiscard]] bool is_given(const std::string& path) const {
    return closest(document_, path).path == path;
  }

  void check_space() const {
    const std::string not_yet =
        "not yet in space: without tissue.plane the scene is in three dimensions";
    require(!scene_.procedure, "procedure", not_yet);
    require(!scene_.image, "image", not_yet);
    require(scene_.needle_angle == std::numbers::pi, "needle_angle",
            "only with tissue.plane; in space a needle has entry and target or direction");
    require(!is_given("tissue.thickness"), "tissue.thickness", "only with tissue.plane");
    if (scene_.membrane) {
      require(scene_.membrane->polygon.empty(), "membrane.polygon",
              "only with tissue.plane; in space region or surface");
    }
    for (std::size_t i = 0; i < scene_.needles.size(); ++i) {
      check_needle_in_space(scene_.needles[i], item("needles", i));
    }
    if (!scene_.needles.empty()) check_at_rest();
  }

  void check_needle_in_space(const NeedleParameters& needle, const std::string& path) const {
    const SpaceParameters& space = needle.space;
    require(!is_given(path + ".height"), path + ".height",
            "only with tissue.plane; in space entry, and target or direction");
    require(space.entry.has_value(), path + ".entry", "[x, y, z], required in space");
    require(space.target.has_value() != space.direction.has_value(),
            path + (space.target ? ".direction" : ".target"),
            "one of target and direction, in space");
    const Vector3 way =
        space.target ? space.target->place() - space.entry->place() : space.direction->vector();
    require(norm(way) > 0, path + (space.target ? ".target" : ".direction"),
            space.target ? "another point than entry" : "a direction that is not 0");
    const double least = least_kernel * needle.diameter / 2;
    require(space.kernel_radius > 0, path + ".kernel_radius",
            "required in space: about two edges of the coarsest mesh");
    require(space.kernel_radius >= least, path + ".kernel_radius",
            "at least " + ten_digits(least) + " m, 1.3 times the needle's radius");
    require(needle.cutting.tip_length > 0, path + ".cutting.tip_length",
            "> 0 m in space, where a point has no answer that a finer mesh would keep");
    require(space.segment <= needle.cutting.tip_length / 3, path + ".segment",
            "at most a third of cutting.tip_length, which is " + exact(needle.cutting.tip_length) +
                " m");
    for (std::size_t k = 0; k < needle.motion.size(); ++k) {
      const Action& action = needle.motion[k];
      const bool inserts = action.kind == ActionKind::insert;
      require(!action.position,
              item(path + ".motion", k) + (inserts ? ".insert" : ".retract") + ".position",
              "depth, because the scene is in space");
    }
  }

  // The needle's way is a straight line in tissue that nothing has moved.
  void check_at_rest() const {
    const std::string allowed =
        "nothing that moves the tissue beside needles, which cut straight ways in space";
    require(scene_.body_forces.empty(), "loads.body", allowed);
    require(scene_.tractions.empty(), "loads.traction", allowed);
    require(std::ranges::none_of(scene_.prescribed, moves), "prescribed", allowed);
    require(!scene_.start, "start", allowed);
  }

  void check_plane() const {
    for (std::size_t i = 0; i < scene_.needles.size(); ++i) {
      const SpaceParameters& space = scene_.needles[i].space;
      const std::string path = item("needles", i);
      const bool is_read = document_.kind != Node::Kind::null;
      require(!is_read || is_given(path + ".height"), path + ".height", "required in the plane");
      require(!space.entry, path + ".entry", "height, because of tissue.plane");
      require(!space.target, path + ".target", "height, because of tissue.plane");
      require(!space.direction, path + ".direction", "height, because of tissue.plane");
      require(space.kernel_radius == 0, path + ".kernel_radius", "only in space");
      require(!is_given(path + ".segment"), path + ".segment", "only in space");
    }
    require(!scene_.membrane || scene_.membrane->surface.empty(), "membrane.surface",
            "region or polygon, because of tissue.plane");
  }

  void check_components() const {
    for (std::size_t i = 0; i < scene_.body_forces.size(); ++i) {
      require_components(at(scene_.body_forces[i].force.dim()), item("loads.body", i) + ".force");
    }
    for (std::size_t i = 0; i < scene_.tractions.size(); ++i) {
      const std::string path = item("loads.traction", i);
      require_boundary(path);
      require(scene_.tractions[i].force.dim() == scene_.dim(),
              path + (plane_ ? ".stress" : ".force"),
              plane_ ? "force, in N/m, because of tissue.plane"
                     : "stress, in Pa, because the scene is in space");
    }
    for (std::size_t i = 0; i < scene_.prescribed.size(); ++i) {
      require_boundary(item("prescribed", i));
      require_components(scene_.prescribed[i].displacement.size(),
                         item("prescribed", i) + ".displacement");
    }
    for (const Target& target : scene_.targets) {
      require_components(at(target.point.dim()), below("targets", target.name));
    }
    for (const Probe& probe : scene_.probes) {
      require_components(at(probe.point.dim()), below("probes", probe.name));
    }
  }

  void require_components(std::size_t n, const std::string& path) const {
    require(n == static_cast<std::size_t>(scene_.dim()), path,
            plane_ ? "[x, y], because of tissue.plane"
                   : "[x, y, z] in space (for triangles give tissue.plane)");
  }

  void require_boundary(const std::string& path) const {
    const std::string other = path + (plane_ ? ".surface" : ".curve");
    require(
        !is_given(other), other,
        plane_ ? "a curve, because of tissue.plane" : "a surface, because the scene is in space");
  }

  const Scene& scene_;
  const Node& document_;
  bool plane_;
};

}  // namespace

void check_dimension(const Scene& scene, const Node& document) {
  DimensionRules(scene, document).check();
}

}  // namespace stylet
