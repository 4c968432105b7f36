// The tissue of a scene as it moves: mesh, operator, what holds and loads it, its state, and the points
// that ride on it. It knows nothing of needles but the edits that they ask for.
#pragma once

#include "stylet/dynamics/time_integrator.hpp"
#include "stylet/mesh/embedded_point.hpp"
#include "stylet/needle/track.hpp"
#include "stylet/needle/track_view.hpp"
#include "stylet/needle/view.hpp"
#include "stylet/scene/scene.hpp"
#include "stylet/simulation/conditions.hpp"
#include "stylet/simulation/energy.hpp"
#include "stylet/simulation/model.hpp"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace stylet {

/// What edits have done to the reference mesh.
struct MeshRewrites {
  long long edge_flips = 0;
  long long pattern_rebuilds = 0;
  double worst_quality = 1;  ///< of any element at any time
};

void archive(Archive& archive, MeshRewrites& rewrites);

/// Points that were embedded together.
struct Riders {
  std::size_t first = 0;
  std::size_t size = 0;
};

/// A step goes: begin; then apply, watch and attempt in any order, as often as it takes; then finish and
/// accept.
class Body {
 public:
  /// Collective. scene: in the needle's coordinates, outlives the body. Throws InputError where scene
  /// and mesh do not fit. live: needles come that the scene does not know, and the tissue may be changed.
  Body(MPI_Comm comm, const Scene& scene, bool live = false);

  [[nodiscard]] const NumberedMesh& numbered() const { return numbered_; }
  [[nodiscard]] const Mesh& mesh() const { return numbered_.mesh; }
  [[nodiscard]] const TissueOperator& tissue() const { return *tissue_; }
  [[nodiscard]] const Conditions& conditions() const { return conditions_; }
  [[nodiscard]] const EnergyLedger& ledger() const { return ledger_; }
  [[nodiscard]] const MeshRewrites& rewrites() const { return rewrites_; }
  [[nodiscard]] double time() const { return state_.t; }
  /// Collective.
  [[nodiscard]] const State& state() const;
  /// Collective. To disturb it: the energy is not checked from then on.
  [[nodiscard]] State& state();
  /// The largest step that is right now (s), as TimeIntegrator::stable_step.
  [[nodiscard]] double stable_step() const { return integrator_->stable_step(); }
  [[nodiscard]] std::string solver() const;
  [[nodiscard]] bool decides_by_velocity() const { return integrator_->decides_by_velocity(); }
  /// What holds the tissue apart from the needle, now.
  [[nodiscard]] std::span<const PrescribedDof> held() const { return held_; }
  /// These conditions without those of held dofs: where a support and the needle meet, the support
  /// holds.
  [[nodiscard]] ConstraintSet beside_held(const TrackConditions& conditions,
                                          const TrackOperator& track) const;

  /// Takes points along through all edits.
  Riders embed(std::span<const EmbeddedPoint> points);
  [[nodiscard]] std::span<const EmbeddedPoint> points(const Riders& riders) const {
    return std::span(riders_).subspan(riders.first, riders.size);
  }
  /// Collective. World positions of embedded points.
  [[nodiscard]] std::vector<WorldPlace> world(std::span<const EmbeddedPoint> points) const;

  /// Collective. Rewrites mesh, operator and state. repaired: a path whose edges stay while flips mend
  /// the elements around the edits; null for none. Throws NumericalError where an element gets too thin.
  void apply(const NeedleEdits& edits, const Track* repaired = nullptr);
  /// Collective, between two needles. The mesh becomes the one that it was made as; where that moves nodes
  /// they take the state of the tissue there.
  void put_mesh_back();
  /// Collective. The state at these nodes.
  [[nodiscard]] NeedleView view(std::span<const int> nodes) const;
  /// Collective. The displacements of the state at these points of a track, ascending (m).
  [[nodiscard]] TrackStart view(const TrackOperator& track, std::span<const int> points) const;
  /// Collective. The trial at these watched points.
  [[nodiscard]] TrackTrial view(const TrackOperator& track,
                                std::span<const int> points,
                                const Trial& trial) const;

  /// Collective. A needle that the scene does not know is about to enter at this height (m): checks its
  /// way in, and makes room for its edits.
  void expect(const NeedleParameters& needle);
  /// Collective, between two steps. The scene's moduli or damping are others now. Throws InputError; nothing
  /// has changed then.
  void renew_tissue();

  /// Collective. Once, before all else: the loads begin.
  void start();
  /// Collective. Starts a step of h (s) from the state: loads and prescribed displacements of its end.
  void begin(double h);
  /// In space, before any of its points is watched: the track that is lent from now on; and that it is not any
  /// more, collective and between steps.
  void follow(const TrackOperator& track);
  void leave_track();
  /// Collective. The next trials must hold the values of these points of a track.
  void watch(const TrackOperator& track, std::span<const int> points);
  /// Collective. The end of the step under these constraints; edited: since the last trial.
  Trial attempt(const ConstraintSet& constraints, bool edited);
  /// Collective. The last trial; `whole` if it is asked for at all nodes.
  Trial finish(bool whole);
  /// Collective. The trial becomes the state. work, dissipated: by the needle (J).
  void accept(const Trial& trial, double work, double dissipated);
  /// Collective. Kinetic and strain energy of now, for the record, or at the end of a run also checked.
  void weigh(bool check);

  /// True if loads or prescribed displacements change between these times.
  [[nodiscard]] bool conditions_change(double t0, double t1) const {
    return conditions_.changes(t0, t1);
  }
  /// Collective (m/s).
  [[nodiscard]] double largest_speed() const;
  /// Collective. Total force on the tissue (N) that a prescribed curve needed in the last step.
  [[nodiscard]] Vector3 curve_reaction(std::size_t curve) const;

  /// Collective, between steps. Loaded into a body of the same scene, whose operator, factor and kernels
  /// are then made anew from what was loaded, with the moduli and the damping that the scene has by then.
  void archive(Archive& archive);

 private:
  [[nodiscard]] std::vector<std::vector<TrackVector>> on_track(const TrackOperator& track,
                                                               std::span<const int> points,
                                                               std::span<const Vec> vectors) const;
  template <class Value>
  [[nodiscard]] std::vector<TrackVector> rows_of(std::span<const int> points, Value&& value) const;
  void update_load(double t);
  [[nodiscard]] double prescribed_work(const Trial& trial) const;
  std::vector<int> rewrite(const NeedleEdits& edits, const Track* repaired);
  void rewritten(std::span<const int> touched, std::span<const NodeEdit> moves);

  const Scene& scene_;
  NumberedMesh numbered_;
  Conditions conditions_;
  std::unique_ptr<TissueOperator> tissue_;
  std::unique_ptr<TimeIntegrator> integrator_;
  EnergyLedger ledger_;
  State state_;
  std::vector<PrescribedDof> held_;
  std::vector<EmbeddedPoint> riders_;
  MeshRewrites rewrites_;
  MeshData source_;              ///< of the mesh before all edits
  std::vector<double> heights_;  ///< of needles that the mesh has room for (m)
  bool renewed_ = false;         ///< the tissue, since the last accepted step
  double h_ = 0;                 ///< of the present step
  OwnedVec load_;
  OwnedVec last_load_;
  double load_time_ = 0;       ///< time that load_ is of (s)
  bool load_changes_ = false;  ///< in the present step
  bool load_changed_ = false;  ///< since the last accepted step
  OwnedVec reaction_;          ///< of the last step, where curves are prescribed
  std::string solver_;         ///< of before the integrator was made anew
};

}  // namespace stylet
