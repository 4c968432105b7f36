// Steps without inertia: K u1 = f1, v1 = (u1 - u0)/h.
//
// Between edits the tissue is linear and remembers nothing, so with the loads of `begin` solved for
// once, a step is dense algebra on the dofs near the needle (near_field.hpp): its cost does not
// depend on the mesh. Where nothing else asks for the whole field it is left out, and solved for
// when a node comes near, when the operator is factored anew, and when somebody looks.
#pragma once

#include "stylet/dynamics/condensed_integrator.hpp"

#include <optional>
#include <vector>

namespace stylet {

class QuasiStatic final : public CondensedIntegrator {
 public:
  /// The tissue is lent.
  QuasiStatic(TissueOperator& tissue, const Mesh& mesh);

  void begin(State& state, Vec load, double h, std::span<const PrescribedDof> held) override;
  void watch(std::span<const int> coordinates) override;
  Trial attempt(const ConstraintSet& constraints, bool edited) override;
  Trial finish(bool whole) override;
  void accept() override;
  void complete() override;
  void complete_at(std::span<const int> nodes) override { watch(stylet::dofs_of(nodes)); }
  void renewed(const Mesh& mesh) override;
  void leave_track() override;
  [[nodiscard]] RowTrial row(int coordinate) const override;
  [[nodiscard]] StoredEnergy energy(const State& state) override;
  [[nodiscard]] EnergyRules energy_rules() const override {
    return {.inertia = false, .advice = "a smaller time.step, or a finer mesh"};
  }
  void archive(Archive& archive) override;

 private:
  [[nodiscard]] std::vector<double> forces() const;
  void factor();
  void load_tissue();
  void take_edits();
  void make_near(std::span<const int> dofs);
  void complete_displacement();
  void keep_near(Vec state, Vec from) const;

  bool loaded_ = false;        ///< load or displacements of held dofs are not zero
  bool fresh_ = true;          ///< the near field has not solved for the present load
  std::vector<double> start_;  ///< displacement of the near dofs at the start of the step, edited
  bool whole_step_ = true;
  bool renewed_ = false;  ///< since the last accepted step

  // Of the last accepted trial, by near dof; those that came later follow with what they had.
  bool whole_u_ = true;  ///< displacements of the state are up to date at all dofs
  bool whole_v_ = true;
  double accepted_h_ = 0;
  std::vector<double> accepted_;       ///< displacement
  std::vector<double> pushed_;         ///< A0 u: zero at later dofs
  std::vector<double> last_pushed_;    ///< of the trial before
  std::vector<int> forced_;            ///< dofs that carried a force
  std::vector<double> loaded_forces_;  ///< of them, from an archive until there is a factor
  OwnedVec held_u_;
  OwnedVec balanced_;  ///< the right-hand side that the near field has solved for
};

}  // namespace stylet
