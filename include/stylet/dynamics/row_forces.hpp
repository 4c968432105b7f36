// Forces on the rows of a needle's track at the end of the last step: what they move beyond the tissue behind
// the rows, and what is stored there.
#pragma once

#include "stylet/base/archive.hpp"
#include "stylet/solvers/near_field.hpp"

#include <span>
#include <vector>

namespace stylet {

class RowForces {
 public:
  /// n_dofs: of the mesh.
  explicit RowForces(int n_dofs) : n_dofs_(n_dofs) {}

  /// The track is lent.
  void follow(const TrackOperator& track) { track_ = &track; }
  void leave();
  [[nodiscard]] bool has_track() const { return track_ != nullptr; }
  /// The one that is followed.
  [[nodiscard]] const TrackOperator& track() const { return *track_; }

  /// Displacement of a row (m).
  [[nodiscard]] double rest_of(int coordinate) const;
  /// J
  [[nodiscard]] double energy() const;
  /// Those of a trial that is accepted. extra: as it was solved with.
  void keep(const NearField& near,
            std::span<const double> extra,
            const NearField::Demand& demand,
            const NearField::Solution& solution);
  void archive(Archive& archive);

 private:
  int n_dofs_;
  const TrackOperator* track_ = nullptr;
  std::vector<DofValue> forces_;
};

}  // namespace stylet
