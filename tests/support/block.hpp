// A block on a spring, dragged by the needle: one node of the shaft is free along the axis and all
// else is held, so that the needle glides through rigid tissue and its friction drives one mass.
#pragma once

#include "stylet/needle/needle.hpp"
#include "stylet/simulation/body.hpp"

#include "support/body.hpp"

#include <string>

namespace stylet {
namespace dragging {

constexpr double speed = 0.1;     // V, m/s
constexpr double height = 0.031;  // m
constexpr std::size_t block = 2;  // of the shaft nodes, from the skin

inline NeedleParameters needle_parameters(CuttingLaw law, const FrictionParameters& friction) {
  NeedleParameters p;
  p.name = "needle";
  p.height = height;
  p.cutting.law = law;
  p.cutting.cutting_force = 0.1;
  p.friction = friction;
  Action insert;
  insert.kind = ActionKind::insert;
  insert.speed = speed;
  insert.depth = 0.07;
  p.motion = {insert};
  return p;
}

// Nothing is held by supports: the block's neighbours are, by constraints.
inline Scene rigid_tissue(const TimeParameters& time) {
  Scene scene;
  RectangleMesh mesh;
  mesh.width = 0.08;
  mesh.height = 0.06;
  mesh.columns = 8;
  mesh.rows = 6;
  mesh.diagonals = Diagonals::alternating;
  scene.mesh.source = mesh;
  const bool is_explicit = time.method == TimeMethod::explicit_newmark;
  scene.tissue = material({60e3, 0.3, 1000}, Plane::stress,
                          is_explicit ? MassKind::lumped : MassKind::consistent, 0.01);
  scene.time = time;
  return scene;
}

}  // namespace dragging

class Block {
 public:
  Block(const TimeParameters& time, const FrictionParameters& friction)
      : friction_(friction),
        scene_(dragging::rigid_tissue(time)),
        body_(MPI_COMM_WORLD, scene_),
        motion_(dragging::needle_parameters(CuttingLaw::consistent, friction).motion),
        needle_(body_.mesh(),
                dragging::needle_parameters(
                    body_.decides_by_velocity() ? CuttingLaw::lagged : CuttingLaw::consistent,
                    friction),
                {},
                body_.decides_by_velocity()) {
    const Entry entry = find_entry(body_.mesh(), {needle_.parameters().height}, "needle");
    std::vector<int> ends{entry.node, entry.neighbour};
    std::ranges::sort(ends);
    body_.apply(needle_.enter(entry, body_.view(ends)));
    motion_.enter(needle_.skin(), Axis::along_sign);
    while (needle_.tip() - needle_.skin() < 0.045) glide(5e-3);
    dof_ = Axis::along_dof(needle_.track().nodes()[dragging::block].node);
    const std::vector<int> free{dof_};
    held_ = held(others(body_.tissue(), free));
    static_cast<void>(body_.state());  // its energy is not the whole tissue's
    const bool is_explicit = body_.decides_by_velocity();
    PetscScalar value = 0;
    body_.tissue().along_row(dof_, [&](int column, double stiffness) {
      if (column == dof_) k_ = stiffness;
    });
    if (is_explicit) {
      m_ = gather_all(body_.tissue().lumped_mass())[static_cast<std::size_t>(dof_)];
    } else {
      check(MatGetValue(body_.tissue().mass(), dof_, dof_, &value));
      m_ = value;
    }
    const auto shares = needle_.track().lengths(body_.mesh(), 0, 1);
    length_ = shares[dragging::block];
  }

  [[nodiscard]] double k() const { return k_; }
  [[nodiscard]] double omega() const { return std::sqrt(k_ / m_); }
  [[nodiscard]] double m() const { return m_; }
  [[nodiscard]] double length() const { return length_; }  ///< of shaft (m)
  [[nodiscard]] double u() const { return u_; }            ///< along (m)
  [[nodiscard]] double static_force() const { return friction_.static_force * length_; }
  [[nodiscard]] double kinetic_force() const { return friction_.kinetic_force * length_; }
  [[nodiscard]] double spring_force() const { return k_ * u_; }
  [[nodiscard]] bool sticks() const {
    return needle_.track().nodes()[dragging::block].contact == Contact::stick;
  }

  /// A step of the block.
  void step(double h) {
    const NeedleStep step = motion_.next(h);
    needle_.start_step(step);
    body_.begin(step.h);
    std::vector<int> loaded;
    for (;;) {
      const bool edited = cut();
      loaded = needle_.loaded_points();
      body_.watch(track(), loaded);
      const Trial trial = body_.attempt(constraints(), edited);
      if (needle_.review(of_block(body_.view(track(), loaded, trial)), 0)) break;
    }
    const Trial trial = body_.finish(true);
    needle_.commit(body_.view(track(), loaded), of_block(body_.view(track(), loaded, trial)), 0);
    body_.accept(trial, 0, 0);
    motion_.taken(step);
    const int nodes[1] = {dof_ / 2};
    u_ = Axis::along(body_.view(nodes).at(dof_ / 2).u);
  }

 private:
  // A step through rigid tissue: the tip cuts until it is where the needle's is, the shaft stays
  // stuck without force.
  void glide(double h) {
    const NeedleStep step = motion_.next(h);
    needle_.start_step(step);
    const auto zero = [&] {
      const auto points = needle_.loaded_points();
      return TrackTrial(points, std::vector<PointTrial>(points.size()));
    };
    const auto force = [&] {
      constexpr double more_than_it_takes = 1;  // N
      const bool ahead = Axis::along(body_.mesh().point(needle_.track().tip())) > step.to;
      return ahead ? 0 : more_than_it_takes;
    };
    do {
      cut();
    } while (!needle_.review(zero(), force()));
    needle_.commit(body_.view(track(), needle_.loaded_points()), zero(), force());
    motion_.taken(step);
  }

  bool cut() {
    const bool wanted = needle_.wants_edit();
    while (needle_.wants_edit()) {
      body_.apply(needle_.plan(body_.view(needle_.watched())));
    }
    return wanted;
  }

  [[nodiscard]] ConstraintSet constraints() const {
    ConstraintSet set = held_;
    const ConstraintSet wanted = body_.beside_held(needle_.conditions(), track());
    for (const auto& c : wanted.dofs) {
      if (c.dof == dof_) set.dofs.push_back(c);
    }
    for (const auto& f : wanted.forces) {
      if (f.dof == dof_) set.forces.push_back(f);
    }
    for (const auto& dashpot : wanted.dashpots) {
      if (dashpot.dof == dof_) set.dashpots.push_back(dashpot);
    }
    return set;
  }

  // All else is rigid: it neither moves nor slips.
  [[nodiscard]] TrackTrial of_block(const TrackTrial& whole) const {
    constexpr int point = static_cast<int>(dragging::block);
    std::vector<PointTrial> values(whole.keys().size());
    const auto at = std::ranges::find(whole.keys(), point) - whole.keys().begin();
    PointTrial& of = values[static_cast<std::size_t>(at)];
    of = whole.at(point);
    for (TrackVector* value : {&of.u, &of.v, &of.reaction, &of.working, &of.settled}) {
      value->across = 0;
    }
    return {whole.keys(), std::move(values)};
  }

  [[nodiscard]] const TrackOperator& track() const { return needle_.track_operator(); }

  FrictionParameters friction_;
  Scene scene_;
  Body body_;
  Motion motion_;
  Needle needle_;
  int dof_ = -1;
  double k_ = 0;
  double m_ = 0;
  double length_ = 0;
  double u_ = 0;
  ConstraintSet held_;
};

}  // namespace stylet
