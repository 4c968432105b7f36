#include "stylet/simulation/body.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/dynamics/implicit_newmark.hpp"
#include "stylet/dynamics/quasi_static.hpp"
#include "stylet/petsc/archive.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/needle_path.hpp"
#include "stylet/simulation/track_binding.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace stylet {

namespace {

NumberedMesh checked_mesh(MPI_Comm comm, const Scene& scene, bool live) {
  if (live && scene.dim() == 3) {
    refuse_key(
        scene, "tissue.plane",
        "missing; allowed: stress, strain, because hands and the window are in the plane so far");
  }
  NumberedMesh numbered = make_mesh(comm, scene);
  check_against_mesh(scene, numbered.mesh);
  return numbered;
}

std::unique_ptr<TimeIntegrator> make_integrator(TissueOperator& tissue,
                                                const Mesh& mesh,
                                                const TimeParameters& time) {
  if (time.method == TimeMethod::explicit_newmark) {
    return std::make_unique<ExplicitNewmark>(tissue, mesh, time);
  }
  if (time.method == TimeMethod::quasi_static) return std::make_unique<QuasiStatic>(tissue, mesh);
  return std::make_unique<ImplicitNewmark>(tissue, mesh, time);
}

OwnedVec zeros(const TissueOperator& tissue) {
  OwnedVec vec = tissue.make_vector();
  check(VecSet(vec.get(), 0));
  return vec;
}

}  // namespace

Body::Body(MPI_Comm comm, const Scene& scene, bool live)
    : scene_(scene),
      numbered_(checked_mesh(comm, scene, live)),
      conditions_(scene, mesh()),
      tissue_(make_tissue(comm,
                          scene,
                          numbered_,
                          live,
                          scene.dim() == 2 && scene.time.method == TimeMethod::explicit_newmark
                              ? Stiffness::rows
                              : Stiffness::matrix)),
      integrator_(make_integrator(*tissue_, mesh(), scene.time)),
      ledger_(*tissue_, mesh(), integrator_->energy_rules(), scene.tissue.depth()),
      held_(conditions_.prescribed(0)) {
  if (scene.time.method == TimeMethod::quasi_static || !scene.needles.empty() || live) {
    check_held(scene, mesh(), held_);
  }
  check_needles(scene, mesh(), conditions_);
  if (const auto* steps = dynamic_cast<const ExplicitNewmark*>(integrator_.get())) {
    steps->require_bearable_damping();
  }
  check_step(scene, mesh(), std::min(scene.time.step, stable_step()));
  for (OwnedVec* vec : {&state_.u, &state_.v, &state_.a, &load_}) *vec = zeros(*tissue_);
  if (conditions_.has_load()) last_load_ = zeros(*tissue_);
  if (!scene.prescribed.empty()) reaction_ = zeros(*tissue_);
  std::vector<int> all(static_cast<std::size_t>(mesh().n_cells()));
  std::iota(all.begin(), all.end(), 0);
  rewrites_.worst_quality = mesh().worst_quality(all);
  if (scene.dim() == 3) return;  // no needle moves its nodes
  if (live || scene.needles.size() > 1) source_ = mesh().data();
  if (live) return;
  for (const NeedleParameters& needle : scene.needles) heights_.push_back(needle.height);
}

void Body::expect(const NeedleParameters& needle) {
  Scene scene = scene_;
  scene.needles = {needle};
  scene.needles.front().motion.clear();
  check_needles(scene, mesh(), conditions_);
  if (std::ranges::find(heights_, needle.height) != heights_.end()) return;
  heights_.push_back(needle.height);
  tissue_->expect_flips(mesh(), near_needles(scene_, mesh(), heights_));
}

void Body::renew_tissue() {
  integrator_->complete();
  const double before = ledger_.conserved(integrator_->energy(state_), *tissue_, state_);
  tissue_->change(mesh(), scene_.tissue);
  integrator_->renewed(mesh());
  ledger_.changed(ledger_.conserved(integrator_->energy(state_), *tissue_, state_) - before);
  renewed_ = state_.t > 0;  // else the run begins with it
}

std::string Body::solver() const {
  const std::string now = integrator_->solver();
  return now == "none" && !solver_.empty() ? solver_ : now;
}

void Body::archive(Archive& archive) {
  if (!archive.loads()) integrator_->complete();
  std::string solver = archive.loads() ? "" : this->solver();
  std::vector<int> rewritten(tissue_->rewritten().begin(), tissue_->rewritten().end());
  archive("mesh", numbered_.mesh);
  archive.cells("rewritten", rewritten);
  archive("heights", heights_);
  archive("time", state_.t);
  archive_field(archive, "u", state_.u.get());
  archive_field(archive, "v", state_.v.get());
  archive_field(archive, "a", state_.a.get());
  if (conditions_.has_load()) {
    archive_field(archive, "load", load_.get());
    archive_field(archive, "last_load", last_load_.get());
    archive("load_time", load_time_);
    archive("load_changed", load_changed_);
  }
  if (reaction_) archive_field(archive, "reaction", reaction_.get());
  archive("riders", riders_);
  archive("rewrites", rewrites_);
  archive("renewed", renewed_);
  archive("ledger", ledger_);
  archive("solver", solver);
  if (archive.loads()) {
    solver_ = solver;
    held_ = conditions_.prescribed(state_.t);
    tissue_->renew(mesh(), scene_.tissue, rewritten, near_needles(scene_, mesh(), heights_));
    integrator_ = make_integrator(*tissue_, mesh(), scene_.time);
  }
  archive("integrator", *integrator_);
  if (archive.loads()) integrator_->go_on(state_, load_.get(), held_);
}

const State& Body::state() const {
  integrator_->complete();
  return state_;
}

State& Body::state() {
  integrator_->complete();
  ledger_.stop_checks();
  return state_;
}

ConstraintSet Body::beside_held(const TrackConditions& conditions,
                                const TrackOperator& track) const {
  ConstraintSet constraints = bind(conditions, track, tissue_->n_dofs());
  const auto is_held = [&](const auto& c) {
    return std::ranges::binary_search(held_, c.dof, {}, &PrescribedDof::dof);
  };
  std::erase_if(constraints.dofs, is_held);
  std::erase_if(constraints.dashpots, is_held);
  return constraints;
}

Riders Body::embed(std::span<const EmbeddedPoint> points) {
  const Riders riders{riders_.size(), points.size()};
  riders_.insert(riders_.end(), points.begin(), points.end());
  return riders;
}

std::vector<WorldPlace> Body::world(std::span<const EmbeddedPoint> points) const {
  if (points.empty()) return {};
  integrator_->complete();
  std::vector<int> nodes;
  for (const auto& point : points) {
    for (const int node : mesh().nodes(point.cell)) nodes.push_back(node);
  }
  const Vec vectors[1] = {state_.u.get()};
  const auto u = gather(vectors, dofs_of(nodes, mesh().dim()))[0];
  const auto dim = static_cast<std::size_t>(mesh().dim());
  std::vector<WorldPlace> world;
  const double* of_node = u.data();
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vector3 moved;
    for (const auto& [node, weight] : node_weights(mesh(), points[i])) {
      moved = moved + weight * Vector3{of_node[0], of_node[1], dim == 3 ? of_node[2] : 0};
      of_node += dim;
    }
    world.push_back(displaced(points[i].x, moved));
  }
  return world;
}

NeedleView Body::view(std::span<const int> nodes) const {
  integrator_->complete_at(nodes);
  const Vec vectors[3] = {state_.u.get(), state_.v.get(), state_.a.get()};
  const auto g = gather(vectors, dofs_of(nodes));
  std::vector<NodeState> states;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto of = [&](std::size_t k) { return Vector2{g[k][2 * i], g[k][2 * i + 1]}; };
    states.push_back({of(0), of(1), of(2)});
  }
  return {std::vector<int>(nodes.begin(), nodes.end()), std::move(states)};
}

void Body::start() {
  update_load(0);
  // Quasi-static loads grow from zero in the first step; dynamic ones act at once.
  if (scene_.time.method == TimeMethod::quasi_static) return;
  if (last_load_) check(VecCopy(load_.get(), last_load_.get()));
  ConstraintSet held;
  held.dofs = held_;
  initial_acceleration(*tissue_, state_, load_.get(), held);
}

void Body::begin(double h) {
  h_ = h;
  const double t1 = state_.t + h;
  load_changes_ = conditions_.load_changes(state_.t, t1);
  // Also back, where a shorter step ends before the change.
  if (load_changes_ || load_changed_) update_load(t1);
  if (!scene_.prescribed.empty()) held_ = conditions_.prescribed(t1);
  integrator_->begin(state_, load_.get(), h, held_);
}

void Body::update_load(double t) {
  if (!conditions_.has_load()) return;
  load_changed_ = true;
  load_time_ = t;
  const auto force = conditions_.load(mesh(), t);
  PetscScalar* values = nullptr;
  check(VecGetArray(load_.get(), &values));
  std::copy(force.begin() + tissue_->first_dof(), force.begin() + tissue_->end_dof(), values);
  check(VecRestoreArray(load_.get(), &values));
}

Trial Body::attempt(const ConstraintSet& constraints, bool edited) {
  ConstraintSet set = constraints;
  set.load_jumps = load_changes_ || renewed_;
  return integrator_->attempt(set, edited);
}

Trial Body::finish(bool whole) {
  return integrator_->finish(whole || conditions_.has_load() || !scene_.prescribed.empty());
}

// Work of the forces on prescribed curves in a step that is about to be accepted (J).
double Body::prescribed_work(const Trial& trial) const {
  double work = 0;
  const double end = trial.end_weight;
  for (std::size_t i = 0; i < scene_.prescribed.size(); ++i) {
    for (std::size_t k = 0; k < scene_.prescribed[i].displacement.size(); ++k) {
      const Vec vectors[4] = {reaction_.get(), trial.working.reaction, state_.u.get(), trial.u};
      const auto values = gather(vectors, conditions_.curve_dofs(i, k));
      for (std::size_t n = 0; n < values[0].size(); ++n) {
        work += ((1 - end) * values[0][n] + end * values[1][n]) * (values[3][n] - values[2][n]);
      }
    }
  }
  return work;
}

void Body::accept(const Trial& trial, double work, double dissipated) {
  const double external = work + trial.blow_work + (reaction_ ? prescribed_work(trial) : 0);
  const Vec load0 = load_changed_ ? last_load_.get() : nullptr;
  ledger_.add(*tissue_, state_, trial, h_, load0, last_load_ ? load_.get() : nullptr, external,
              dissipated);
  if (reaction_) check(VecCopy(trial.settled.reaction, reaction_.get()));
  integrator_->accept();
  if (load_changed_) check(VecCopy(load_.get(), last_load_.get()));
  load_changed_ = false;
  renewed_ = false;
  if (ledger_.due()) ledger_.weigh(integrator_->energy(state_), *tissue_, state_);
}

void Body::weigh(bool check) {
  if (!ledger_.unchecked()) return;
  const StoredEnergy stored = integrator_->energy(state_);
  if (check) {
    ledger_.weigh(stored, *tissue_, state_);
  } else {
    ledger_.measure(stored, *tissue_, state_);
  }
}

double Body::largest_speed() const {
  PetscReal speed = 0;
  check(VecNorm(state_.v.get(), NORM_INFINITY, &speed));
  return speed;
}

Vector3 Body::curve_reaction(std::size_t curve) const {
  std::array<double, 3> total{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec vectors[1] = {reaction_.get()};
    const auto values = gather(vectors, conditions_.curve_dofs(curve, k));
    for (const double value : values[0]) total[k] += value;
  }
  return {total[0], total[1], total[2]};
}

}  // namespace stylet
