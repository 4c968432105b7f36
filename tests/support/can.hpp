// A needle of 18G in a cylinder, on its axis: radius 40 mm, height 60 mm, side and bottom fixed, E = 60 kPa.
// Far field by tetrahedra, near field in closed form. Answers per mm.
#pragma once

#include "stylet/mesh/gmsh_reader.hpp"
#include "stylet/mesh/refine.hpp"
#include "stylet/needle/embedded_track.hpp"
#include "stylet/solvers/near_field.hpp"

#include "support/solid.hpp"

#include <fstream>
#include <memory>
#include <sstream>

namespace stylet {

struct CanCase {
  const char* mesh;  ///< path
  int refinements;
  double nu;
  Formulation formulation;
  double depth = 0.035;          ///< of the tip (m)
  double stiffer = 1;            ///< tissue of the region deep, if the mesh has it, by the other's
  double kernel_radius = 10e-3;  ///< m
};

class Can {
 public:
  static constexpr double tip_length = 6e-3;
  /// Makes another operator of the track, for a needle that has a compliance of its own.
  using Behind = std::function<std::unique_ptr<TrackOperator>(const EmbeddedTrack& track)>;

  explicit Can(const CanCase& c, const Behind& behind = {})
      : body_(mesh_of(c), tissue_of(c)),
        track_(body_.mesh,
               {0, 0, 0.07},
               {0, 0, -1},
               c.depth,
               {.radius = 0.635e-3,
                .kernel_radius = c.kernel_radius,
                .segment = 1e-3,
                .below_skin = true},
               moduli_of(c)),
        behind_(behind ? behind(track_) : nullptr),
        near_(MPI_COMM_WORLD, body_.tissue.n_dofs()) {
    body_.tissue.make_tangent({0, 1});
    std::vector<int> fixed = dofs_on(body_.mesh, "side");
    const auto bottom = dofs_on(body_.mesh, "bottom");
    fixed.insert(fixed.end(), bottom.begin(), bottom.end());
    std::ranges::sort(fixed);
    fixed.erase(std::ranges::unique(fixed).begin(), fixed.end());
    near_.follow(behind_ ? behind_.get() : &track_);
    near_.factor(body_.tissue.tangent_matrix(), held(fixed).dofs);
    near_.unload();
  }

  [[nodiscard]] const EmbeddedTrack& track() const { return track_; }

  /// Forces (N) on the tissue, by segment, of a needle that moves its segments by these (m).
  [[nodiscard]] std::vector<double> moved(Component component, const std::vector<double>& by) {
    NearField::Demand demand;
    const auto at = places(component);
    for (std::size_t i = 0; i < at.size(); ++i) demand.given.push_back({at[i], by[i]});
    const auto solution = near_.solve(std::vector<double>(near_.coordinates().size()), demand);
    std::vector<double> forces;
    for (const std::size_t i : at) forces.push_back(solution.reaction[i]);
    return forces;
  }
  /// Force (N) of a needle that sticks and is moved by 1 mm.
  [[nodiscard]] double stuck(Component component) {
    double force = 0;
    for (const double of_segment :
         moved(component, std::vector<double>(static_cast<std::size_t>(track_.size()), 1e-3))) {
      force += of_segment;
    }
    return force;
  }

  /// Mean displacement (mm) of the tip's zone, which ends at `depth`, by 1 N that is spread between two
  /// depths, by shares of the segments.
  [[nodiscard]] double tip(Component component, double depth, double from, double to) {
    const auto at = places(component);
    std::vector<double> force(near_.coordinates().size());
    for (const auto& [point, share] : track_.shares(from, to)) {
      force[at[static_cast<std::size_t>(point)]] = share;
    }
    const auto solution = near_.solve(force, {});
    double mean = 0;
    for (const auto& [point, share] : track_.shares(depth - tip_length, depth)) {
      mean += share * solution.x[at[static_cast<std::size_t>(point)]];
    }
    return 1e3 * mean;
  }
  /// The same by its own load, with what the ends of the zone add.
  [[nodiscard]] double tip_along(double depth) {
    const double from = depth - tip_length;
    return tip(Component::along, depth, from, depth) + 1e3 * track_.rest_of_ends(from, depth);
  }

 private:
  static constexpr double youngs_modulus = 60e3;

  static MeshData mesh_of(const CanCase& c) {
    std::ifstream in(c.mesh);
    std::ostringstream text;
    text << in.rdbuf();
    return refine(read_gmsh(c.mesh, text.str(), 1e-3), c.refinements);
  }
  static bool is_layered(const CanCase& c) { return c.stiffer != 1; }
  static TissueParameters tissue_of(const CanCase& c) {
    TissueParameters p = solid({youngs_modulus, c.nu, 1000}, c.formulation);
    if (is_layered(c)) p.regions.push_back({"deep", {c.stiffer * youngs_modulus, c.nu, 1000}});
    return p;
  }
  std::vector<RegionModuli> moduli_of(const CanCase& c) const {
    std::vector<RegionModuli> moduli;
    for (const std::string& name : body_.mesh.data().region_names) {
      const double e = (name == "deep" ? c.stiffer : 1) * youngs_modulus;
      moduli.push_back({e / (2 * (1 + c.nu)), c.nu});
    }
    return moduli;
  }

  std::vector<std::size_t> places(Component component) {
    std::vector<int> coordinates;
    for (int point = 0; point < track_.size(); ++point) {
      coordinates.push_back(coordinate_of(body_.tissue.n_dofs(), {point, component}));
    }
    near_.include(coordinates);
    std::vector<std::size_t> at;
    for (const int coordinate : coordinates) at.push_back(near_.at(coordinate));
    return at;
  }

  Slab body_;
  EmbeddedTrack track_;
  std::unique_ptr<TrackOperator> behind_;
  NearField near_;
};

}  // namespace stylet
