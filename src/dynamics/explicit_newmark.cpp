#include "stylet/dynamics/explicit_newmark.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/dynamics/central_difference_ts.hpp"
#include "stylet/dynamics/explicit_step.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace stylet {

ExplicitNewmark::ExplicitNewmark(TissueOperator& tissue,
                                 const Mesh& mesh,
                                 const TimeParameters& parameters)
    : tissue_(tissue),
      safety_(parameters.safety),
      damping_(tissue.damping().value_or(RayleighDamping{})),
      bound_(tissue),
      cells_(mesh, tissue),
      track_(tissue.comm(), tissue.n_dofs()) {
  for (OwnedVec* vec :
       {&u_, &v_, &a_, &needed_, &working_, &settled_, &work_, &increment_, &half_velocity_}) {
    *vec = tissue.make_vector();
    check(VecSet(vec->get(), 0));
  }
  const Values masses(tissue.lumped_mass());
  for (int dof = tissue.first_dof(); dof < tissue.end_dof(); dof += tissue.dim()) {
    node_mass_.push_back(masses[dof]);
  }
  make_room();
  register_central_difference();
  check(TSCreate(tissue.comm(), ts_.put()));
  check(TSSetType(ts_.get(), central_difference_type));
  check(TSSetMaxSteps(ts_.get(), PETSC_MAX_INT - 1));  // PETSC_MAX_INT counts as not set
  check(TSSetMaxTime(ts_.get(), PETSC_MAX_REAL));
  check(TSSetExactFinalTime(ts_.get(), TS_EXACTFINALTIME_STEPOVER));
  set_step(ts_.get(), [this](double h, Vec u, Vec v) { advance(h, u, v); });
  check_options(TSSetFromOptions(ts_.get()));
  check_options(TSViewFromOptions(ts_.get(), nullptr, "-ts_view"));
}

void ExplicitNewmark::require_bearable_damping() const {
  const double undamped = safety_ * stylet::stable_step(bound_.value(), 0);
  constexpr double hopeless = 0.02;
  if (stable_step() >= hopeless * undamped) return;
  throw InputError("key 'tissue.damping.stiffness_factor': " + exact(damping_.stiffness_factor) +
                   " s would cut the stable explicit step to " + exact(stable_step()) +
                   " s, from " + exact(undamped) +
                   " s without it; damp explicit scenes by tissue.damping.mass_factor, or take "
                   "time.method implicit");
}

// With the kernel's ghosts.
void ExplicitNewmark::make_room() {
  stretched_ = cells_.make_ghosted();
  if (size_of(tissue_.comm()) > 1) force_.resize(2 * cells_.kernel().nodes().n_all());
}

double ExplicitNewmark::stable_step() const {
  return safety_ * stylet::stable_step(bound_.value(), damping_.stiffness_factor);
}

void ExplicitNewmark::touched(const Mesh& mesh, std::span<const int> cells) {
  const auto changed = tissue_.rows_of(mesh, cells);
  const auto rows = tissue_.coupled(mesh, changed);
  if (cells_.update(mesh, cells)) make_room();
  bound_.update(changed, rows);
  const Values masses(tissue_.lumped_mass());
  for (const int node : changed) {
    if (!tissue_.owns(node)) continue;
    node_mass_[static_cast<std::size_t>(node - tissue_.first_dof() / 2)] = masses[2 * node];
  }
  if (state_ != nullptr) accelerate_again(changed, rows);
}

void ExplicitNewmark::renewed(const Mesh& mesh) {
  damping_ = tissue_.damping().value_or(RayleighDamping{});
  std::vector<int> cells(static_cast<std::size_t>(mesh.n_cells()));
  std::iota(cells.begin(), cells.end(), 0);
  touched(mesh, cells);
}

// The next half step is under the accelerations of the state: where rows changed, they follow from the
// new rows and the contact forces that the last step left, else that half step would do work that no
// energy pays for. columns: nodes that the rows couple to, ascending.
void ExplicitNewmark::accelerate_again(std::span<const int> rows, std::span<const int> columns) {
  const auto dofs = dofs_of(columns);
  const Vec vectors[2] = {state_->u.get(), state_->v.get()};
  const auto fields = gather(vectors, dofs);
  const Values load(load_);
  const Values mass(tissue_.lumped_mass());
  Entries a(state_->a.get());
  for (const int node : rows) {
    for (int row = 2 * node; a.owns(row) && row < 2 * node + 2; ++row) {
      if (is_given(row, kept_)) {
        a[row] = 0;
        continue;
      }
      double force = load[row];
      auto at = dofs.begin();
      tissue_.along_row(row, [&](int column, double value) {
        at = std::lower_bound(at, dofs.end(), column);
        const auto k = static_cast<std::size_t>(at - dofs.begin());
        force -= value * (fields[0][k] + damping_.stiffness_factor * fields[1][k]);
      });
      const auto own = std::ranges::lower_bound(dofs, row) - dofs.begin();
      force -= damping_.mass_factor * mass[row] * fields[1][static_cast<std::size_t>(own)];
      for (const auto& contact : contact_) {
        if (contact.dof == row) force += contact.value;
      }
      a[row] = force / mass[row];
    }
  }
}

void ExplicitNewmark::begin(State& state, Vec load, double h, std::span<const PrescribedDof> held) {
  state_ = &state;
  load_ = load;
  h_ = h;
  held_ = held;
  fresh_ = true;
}

void ExplicitNewmark::advance(double h, Vec u, Vec v) {
  const double stiffness_factor = damping_.stiffness_factor;
  PetscReal load_size = 0;
  check(VecNorm(load_, NORM_INFINITY, &load_size));  // remembered by PETSc while nothing changes
  placed_.clear();
  given_.clear();
  for (const auto& c : dofs_) {
    if (c.velocity) continue;
    placed_.push_back(c.dof);
    if (!tissue_.owns(c.dof / tissue_.dim())) continue;
    given_.push_back({static_cast<std::size_t>(c.dof - tissue_.first_dof()), c.value});
  }
  // Those that are held come first and ascend.
  const auto needle = std::ranges::is_sorted_until(given_, {}, &GivenPlace::dof) - given_.begin();
  std::ranges::sort(given_.begin() + needle, given_.end(), {}, &GivenPlace::dof);
  std::ranges::inplace_merge(given_, given_.begin() + needle, {}, &GivenPlace::dof);
  const ExplicitFactors factors{h, damping_.mass_factor, stiffness_factor};
  StepSums sums;
  const bool in_space = tissue_.dim() == 3;
  const bool fused = !in_space && size_of(tissue_.comm()) == 1;
  const auto lend = [&](auto&& then) {
    const Values u0(state_->u.get());
    const Values v0(state_->v.get());
    const Values a0(state_->a.get());
    const Values load(load_);
    Entries u1(u);
    Entries v1(v);
    Entries a1(a_.get());
    Entries s(stretched_.get());
    const auto first = static_cast<std::size_t>(tissue_.first_dof() / tissue_.dim());
    then(ExplicitArrays{node_mass_.size(), u0.data(), v0.data(), a0.data(), u1.data(), v1.data(),
                        a1.data(), fused && stiffness_factor == 0 ? u1.data() : s.data(),
                        fused || in_space ? a1.data() : force_.data(),
                        load_size > 0 ? load.data() : nullptr, node_mass_.data(),
                        bound_.inverse_roots().data() + first});
  };
  if (in_space) {
    lend([&](const ExplicitArrays& x) { predict_in_space(x, factors, given_, sums); });
    cells_.stiffness(stretched_.get(), a_.get());
    lend([&](const ExplicitArrays& x) { accelerate_in_space(x, factors, sums); });
  } else if (fused) {
    lend([&](const ExplicitArrays& x) {
      step(x, factors, cells_.kernel(), given_, pressure_, sums);
    });
  } else {
    lend([&](const ExplicitArrays& x) { predict(x, factors, given_, sums); });
    check(VecGhostUpdateBegin(stretched_.get(), INSERT_VALUES, SCATTER_FORWARD));
    check(VecGhostUpdateEnd(stretched_.get(), INSERT_VALUES, SCATTER_FORWARD));
    lend(
        [&](const ExplicitArrays& x) { accelerate(x, factors, cells_.kernel(), pressure_, sums); });
  }
  // v of the half step times M v of the end, since M a is the force of the end.
  const double half = 0.5 * h;
  const double end = sums.half + half * (sums.rest - damping_.mass_factor * sums.half) /
                                     (1 + half * damping_.mass_factor);
  placing_work_ = sums.blow;
  load_work_ = h * sums.load;
  free_damping_work_ = damping_.mass_factor * half * (sums.start + end);
}

void ExplicitNewmark::restore() {
  PetscScalar* v = nullptr;
  PetscScalar* a = nullptr;
  check(VecGetArray(v_.get(), &v));
  check(VecGetArray(a_.get(), &a));
  for (const auto& value : overridden_) {
    v[value.index] = value.v;
    a[value.index] = value.a;
  }
  check(VecRestoreArray(a_.get(), &a));
  check(VecRestoreArray(v_.get(), &v));
  overridden_.clear();
}

Trial ExplicitNewmark::attempt(const ConstraintSet& constraints, bool edited) {
  const bool in_space = track_.is_followed();
  const ConstraintSet on_dofs = in_space ? ConstraintSet{} : constraints;
  dofs_.assign(held_.begin(), held_.end());
  dofs_.insert(dofs_.end(), on_dofs.dofs.begin(), on_dofs.dofs.end());
  if (fresh_ || edited || !places_same_dofs(on_dofs)) {
    check(TS2SetSolution(ts_.get(), u_.get(), v_.get()));
    check(TSSetTime(ts_.get(), state_->t));
    check(TSSetTimeStep(ts_.get(), h_));
    check(TSStep(ts_.get()));
    overridden_.clear();
    fresh_ = false;
    if (in_space) track_.place(u_.get(), true);
  } else {
    restore();
  }
  Multipliers multipliers = apply(on_dofs);
  if (in_space) {
    track_.place(u_.get(), false);
    multipliers.before = multipliers.after = track_.solve(constraints, h_);
  }
  double works[3] = {placing_work_ + blow_work_, damping_work_, load_work_};
  if (size_of(tissue_.comm()) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, works, 3, MPI_DOUBLE, MPI_SUM, tissue_.comm());
  }
  trial_ = {};
  trial_.u = u_.get();
  trial_.v = v_.get();
  trial_.needed = {needed_.get(), multipliers.before};
  trial_.working = {working_.get(), 0.5 * (multipliers.before + multipliers.after)};
  trial_.settled = {settled_.get(), multipliers.after};
  trial_.blow_work = works[0];
  trial_.damping_work = works[1];
  trial_.load_work = works[2];
  trial_.swing_time = 0.5 * h_;
  return trial_;
}

// Stiffness is damped at the velocity of the half step before the forces.
Trial ExplicitNewmark::finish(bool) {
  if (track_.is_followed()) push_by_track();
  if (damping_.stiffness_factor == 0) return trial_;
  check(VecWAXPY(increment_.get(), -1, state_->u.get(), u_.get()));
  cells_.stiffness(increment_.get(), work_.get());
  PetscScalar now = 0;
  PetscScalar before = 0;
  check(VecDot(increment_.get(), work_.get(), &now));
  check(VecDot(half_velocity_.get(), work_.get(), &before));
  trial_.damping_work += damping_.stiffness_factor * 0.5 * (now / h_ + before);
  check(VecCopy(increment_.get(), half_velocity_.get()));
  check(VecScale(half_velocity_.get(), 1 / h_));
  return trial_;
}

void ExplicitNewmark::accept() {
  kept_.assign(dofs_.begin() + static_cast<std::ptrdiff_t>(held_.size()), dofs_.end());
  std::swap(contact_, trial_contact_);
  if (track_.is_followed()) track_.accept();
  std::swap(state_->u, u_);
  std::swap(state_->v, v_);
  std::swap(state_->a, a_);
  state_->t += h_;
  constexpr long long most = std::numeric_limits<PetscInt>::max();  // then PETSc counts anew
  const auto step = static_cast<PetscInt>(++n_steps_ & most);
  check(TSMonitor(ts_.get(), step, state_->t, state_->u.get()));
}

}  // namespace stylet
