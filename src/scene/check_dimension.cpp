// Scenes in the plane and scenes in space: what belongs to which.
#include "stylet/base/index.hpp"
#include "stylet/base/text.hpp"
#include "stylet/scene/requirement.hpp"

#include <numbers>

namespace stylet {

namespace {

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
    require(plane_ || is_box || scene_.needles.empty(), "tissue.plane",
            "stress, strain, because the scene has needles, which are not yet in space");
    if (!plane_) check_space();
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
        "not yet in space: without tissue.plane the scene is in three dimensions, and needles, "
        "with "
        "all that belongs to them, are in the plane so far";
    require(scene_.needles.empty(), "needles", not_yet);
    require(!scene_.procedure, "procedure", not_yet);
    require(!scene_.membrane, "membrane", not_yet);
    require(scene_.targets.empty(), "targets", not_yet);
    require(!scene_.image, "image", not_yet);
    require(scene_.needle_angle == std::numbers::pi, "needle_angle", not_yet);
    require(!is_given("tissue.thickness"), "tissue.thickness", "only with tissue.plane");
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
