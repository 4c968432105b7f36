// What time integrators carry from step to step beside the state: fields, factors and products are found
// anew from it.
#include "stylet/petsc/archive.hpp"

#include "stylet/dynamics/explicit_newmark.hpp"
#include "stylet/dynamics/implicit_newmark.hpp"
#include "stylet/dynamics/quasi_static.hpp"

namespace stylet {

static void archive(Archive& archive, DofValue& entry) {
  auto& [dof, value] = entry;
  archive.dof("dof", dof);
  archive("value", value);
}

static void archive(Archive& archive, PrescribedDof& prescribed) {
  auto& [dof, value, velocity] = prescribed;
  archive.dof("dof", dof);
  archive("value", value);
  archive("velocity", velocity);
}

void ImplicitNewmark::archive(Archive& archive) {
  archive("damped_steps", damped_steps_);
  archive("half", half_);
  archive("fastest", fastest_);
  archive("rows", rows_);
  archive("had_mean", had_mean_);
  if (archive.loads()) has_mean_ = had_mean_;
  archive("released", released_);
}

void QuasiStatic::archive(Archive& archive) {
  std::vector<double> kept = archive.loads() ? std::vector<double>{} : forces();
  std::size_t size = forced_.size();
  archive("forced/size", size);
  forced_.resize(size);
  const int n_dofs = tissue_.n_dofs();
  for (int& dof : forced_) {
    int row = dof - n_dofs;
    archive("forced/row", row);  // negative: of the mesh
    if (row < 0) archive.dof("forced/dof", dof);
    if (row >= 0) dof = n_dofs + row;
  }
  archive("rows", rows_);
  archive("forces", kept);
  archive("renewed", renewed_);
  if (archive.loads()) loaded_forces_ = std::move(kept);
}

void ExplicitNewmark::archive(Archive& archive) {
  archive("bound", bound_);
  archive("n_steps", n_steps_);
  archive("contact", contact_);
  archive("kept", kept_);
  archive("track", track_);
  if (damping_.stiffness_factor != 0) archive_field(archive, "half_velocity", half_velocity_.get());
}

void ExplicitNewmark::go_on(State& state, Vec load, std::span<const PrescribedDof> held) {
  state_ = &state;
  load_ = load;
  held_ = held;
}

}  // namespace stylet
