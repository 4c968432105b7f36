// Explicit steps under the needle's conditions.
#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>

namespace stylet {

// By the needle (dofs) or apart from it.
bool ExplicitNewmark::is_given(int dof, std::span<const PrescribedDof> dofs) const {
  return std::ranges::find(dofs, dof, &PrescribedDof::dof) != dofs.end() ||
         std::ranges::binary_search(held_, dof, {}, &PrescribedDof::dof);
}

bool ExplicitNewmark::places_same_dofs(const ConstraintSet& constraints) const {
  std::size_t n = 0;
  const auto placed = [&](const PrescribedDof& c) {
    if (c.velocity) return true;
    return n < placed_.size() && placed_[n++] == c.dof;
  };
  return std::ranges::all_of(held_, placed) && std::ranges::all_of(constraints.dofs, placed) &&
         n == placed_.size();
}

// Contact on the dofs that feel it; everything is local since the mass is diagonal.
//
// Around the end of a step, half a step is under the needed forces, then half a step under the settled
// ones, with which a is left. They differ where a contact begins: by the blow that brings the dof to
// its given velocity v. Settled forces of the start and the means of both at the end, weighed alike,
// miss of its work h/4 v (needed - settled), since they take the displacement of a step that was
// slower.
ExplicitNewmark::Multipliers ExplicitNewmark::apply(const ConstraintSet& constraints) {
  Entries v(v_.get());
  Entries a(a_.get());
  Entries u(u_.get());
  Entries needed(needed_.get());
  Entries working(working_.get());
  Entries settled(settled_.get());
  const Values mass(tissue_.lumped_mass());
  for (const int dof : written_) needed[dof] = working[dof] = settled[dof] = 0;
  written_.clear();
  const int first = tissue_.first_dof();
  const double damped = 1 + 0.5 * h_ * damping_.mass_factor;
  const double per_step = 2 * damped / h_;
  const double half = 0.5 * h_;
  damping_work_ = free_damping_work_;
  blow_work_ = 0;
  // The first record of a dof holds its free value; restored in reverse, it is written last.
  overridden_.reserve(overridden_.size() + dofs_.size() + constraints.forces.size());
  written_.reserve(dofs_.size());
  const auto change = [&](int dof, double new_v, double new_a) {
    double& old_v = v[dof];
    double& old_a = a[dof];
    overridden_.push_back({dof - first, old_v, old_a});
    const double half_velocity = old_v - half * old_a;
    damping_work_ += damping_.mass_factor * half * mass[dof] * (new_v - old_v) * half_velocity;
    old_v = new_v;
    old_a = new_a;
  };
  for (const auto& [dof, force] : constraints.forces) {
    if (!v.owns(dof)) continue;
    const double extra = force / (mass[dof] * damped);
    change(dof, v[dof] + half * extra, a[dof] + extra);
  }
  for (const auto& c : dofs_) {
    if (!v.owns(c.dof)) continue;
    written_.push_back(c.dof);
    // A given velocity needs the force that changes the free velocity into it over the half step:
    // with it, sticking and sliding exclude each other. A given place was taken by `advance`, with
    // its velocity: C v + K u - f is left.
    const double m = mass[c.dof];
    const double given = c.velocity ? c.value : v[c.dof] - half * a[c.dof];
    const double excess = v[c.dof] - given;
    const double before = -m * per_step * excess;
    const double after = -m * (a[c.dof] + damping_.mass_factor * excess);
    needed[c.dof] = before;
    working[c.dof] = 0.5 * (before + after);
    settled[c.dof] = after;
    blow_work_ += 0.25 * h_ * given * (before - after);
    change(c.dof, given, 0);
  }
  // The force at the end of the step of the velocity that it leaves.
  const auto damping = [&](int dof) {
    const auto found = std::ranges::find(constraints.dashpots, dof, &Dashpot::dof);
    return found == constraints.dashpots.end() ? 0.0 : found->coefficient;
  };
  for (const auto& [dof, coefficient, speed] : constraints.dashpots) {
    if (!v.owns(dof)) continue;
    const double inertia = mass[dof] * damped;
    const double force = coefficient * (speed - v[dof]) * inertia / (inertia + half * coefficient);
    change(dof, v[dof] + half * force / inertia, a[dof] + force / inertia);
  }
  trial_contact_ = constraints.forces;
  Multipliers multipliers;
  if (constraints.mean) {
    const auto& mean = *constraints.mean;
    const auto mobility = [&](int dof) {
      if (is_given(dof, constraints.dofs)) return 0.0;
      return 1 / (mass[dof] * damped + half * damping(dof));
    };
    const auto ratio = [&](int dof) { return half * damping(dof) / (mass[dof] * damped); };
    double sums[5] = {0, 0, 0, 0, 0};  // w.u, w.v, w.a, w.M^-1 w, and of it what dashpots add
    for (const auto& [dof, weight] : mean.weights) {
      if (!v.owns(dof)) continue;
      sums[0] += weight * u[dof];
      sums[1] += weight * v[dof];
      sums[2] += weight * a[dof];
      sums[3] += weight * weight * mobility(dof);
      sums[4] += weight * weight * mobility(dof) * ratio(dof);
    }
    if (size_of(tissue_.comm()) > 1) {
      MPI_Allreduce(MPI_IN_PLACE, sums, 5, MPI_DOUBLE, MPI_SUM, tissue_.comm());
    }
    if (!(sums[3] > 0)) throw_all_held();
    const double wanted = mean.rate + (mean.by_rate ? 0 : (mean.value - sums[0]) / h_);
    const double impulse = (wanted - sums[1]) / sums[3];
    // Of w.a = 0 just after it, when dashpots pull with their new force.
    const double steady = (impulse * sums[4] / half - sums[2]) / (sums[3] + sums[4]);
    multipliers.before = 2 * impulse / h_;
    multipliers.after = (steady + damping_.mass_factor * impulse) / damped;
    const auto [before, after] = multipliers;
    for (const auto& [dof, weight] : mean.weights) trial_contact_.push_back({dof, after * weight});
    for (const auto& [dof, weight] : mean.weights) {
      if (!v.owns(dof)) continue;
      if (mobility(dof) == 0) {
        // The tip's share is not the constraint's.
        needed[dof] -= before * weight;
        working[dof] -= 0.5 * (before + after) * weight;
        settled[dof] -= after * weight;
        continue;
      }
      const double more = ratio(dof) * (steady - impulse / half);
      change(dof, v[dof] + impulse * weight * mobility(dof),
             a[dof] + (steady + more) * weight * mobility(dof));
      blow_work_ += 0.25 * h_ * v[dof] * weight * (before - after);
    }
  }
  for (const auto& [dof, coefficient, speed] : constraints.dashpots) {
    if (v.owns(dof)) trial_contact_.push_back({dof, coefficient * (speed - v[dof])});
  }
  std::ranges::reverse(overridden_);
  return multipliers;
}

void ExplicitNewmark::watch(std::span<const int> coordinates) {
  if (track_.is_followed() && state_ != nullptr) track_.watch(coordinates, state_->u.get());
}

void ExplicitNewmark::leave_track() {
  track_.leave();
}

// The forces on the track at the end of the step, through its rows.
void ExplicitNewmark::push_by_track() {
  Entries v(v_.get());
  Entries a(a_.get());
  const Values mass(tissue_.lumped_mass());
  const double damped = 1 + 0.5 * h_ * damping_.mass_factor;
  const double half = 0.5 * h_;
  double damping_work = 0;
  track_.each_force([&](int dof, double force) {
    if (!v.owns(dof) || is_given(dof, {})) return;
    const double extra = force / (mass[dof] * damped);
    damping_work +=
        damping_.mass_factor * half * mass[dof] * half * extra * (v[dof] - half * a[dof]);
    v[dof] += half * extra;
    a[dof] += extra;
  });
  if (size_of(tissue_.comm()) > 1) {
    MPI_Allreduce(MPI_IN_PLACE, &damping_work, 1, MPI_DOUBLE, MPI_SUM, tissue_.comm());
  }
  trial_.damping_work += damping_work;
}

}  // namespace stylet
