// The path of a needle in triangles: its points are nodes of the mesh, which go where the needle cuts.
//
// The tip's node goes on to the far edge of the element ahead at most, where another node takes its place.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/advance.hpp"
#include "stylet/needle/axis.hpp"
#include "stylet/needle/reference_path.hpp"
#include "stylet/needle/skin.hpp"

#include <optional>
#include <vector>

namespace stylet {

class CutPath final : public ReferencePath {
 public:
  /// The mesh is lent. The rest as ReferencePath has it.
  CutPath(const Mesh& mesh,
          Axis axis,
          double tip_length,
          double radius,
          bool stops_at_ends,
          NeedleTissue tissue);

  NeedleEdits enter(const Entry& entry, const NeedleView& start) override;
  [[nodiscard]] double length() const override { return track_.distances(mesh_).front(); }
  [[nodiscard]] double tip_along() const override { return Axis::along(tip()); }
  [[nodiscard]] bool is_uncut() const override { return track_.size() == 1; }
  [[nodiscard]] bool jumps_ahead() const override { return is_uncut(); }
  [[nodiscard]] bool is_first_cut() const override { return track_.size() == 2; }
  [[nodiscard]] WorldPlace on_axis(double along) const override {
    return axis_.at<WorldFrame>(along);
  }
  [[nodiscard]] ReferencePlace tip_point() const override;
  [[nodiscard]] int tip_cell() const override { return mesh_.cells_around(track_.tip()).front(); }
  [[nodiscard]] std::vector<ReferencePlace> line() const override;

  [[nodiscard]] bool at_membrane() const override { return membrane_.has_value(); }
  [[nodiscard]] double modulus_ahead() const override;
  [[nodiscard]] double element_size() const override;
  [[nodiscard]] std::vector<PointShare> tip_shares() const override;
  [[nodiscard]] std::vector<double> shaft_lengths() const override;
  [[nodiscard]] std::vector<int> loaded_points() const override;
  void guide(int point, std::vector<TrackHold>& held) const override;
  [[nodiscard]] SparseRow row(TrackPlace place) const override { return {*dof(place)}; }
  /// Of a node.
  [[nodiscard]] std::optional<DofValue> dof(TrackPlace place) const override;
  [[nodiscard]] std::vector<int> watched() const override;

  void uncover(double to,
               const TrackTrial& trial,
               const std::optional<FrictionParameters>& friction,
               double speed) override;

  void start_step(double advance) override;
  void begin_cut() override { hand_over_wanted_ = true; }
  bool pass_end() override;
  void puncture() override;
  void new_base() override;
  [[nodiscard]] bool wants_edit() const override { return hand_over_wanted_ || remaining_ != 0; }
  Plan plan(const NeedleView& start) override;
  void archive(Archive& archive) override;

 private:
  [[nodiscard]] ReferencePoint tip() const { return mesh_.point(track_.tip()); }
  [[nodiscard]] ReferencePoint point(std::size_t i) const {
    return mesh_.point(track_.nodes()[i].node);
  }
  [[nodiscard]] End find_end() const;
  [[nodiscard]] std::optional<double> crossing(double length) const;
  [[nodiscard]] int skin_point(int node) const;
  bool find_base(const NeedleView& start);
  Plan hand_over(const NeedleView& start);

  const Mesh& mesh_;
  Axis axis_;
  Skin skin_;                               ///< around the entry, as far as the tip can press on it
  std::optional<ReferencePoint> membrane_;  ///< where the tip stands at it, not yet punctured

  // The advance within the present step.
  std::optional<AdvanceBase> base_;
  bool hand_over_wanted_ = false;
  bool postponed_ = false;  ///< no node may become the tip yet: goes on to the end of its reach
  int passages_ = 0;        ///< flips in this step that made way for the tip
  double base_free_ = 0;    ///< advance from base_ that is cut already (m)
};

}  // namespace stylet
