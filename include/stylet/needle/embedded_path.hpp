// The path of a needle in tetrahedra: as much of a straight track as its tip has cut. Its points are the
// track's segments, and the mesh stays as it is.
//
// A base ends where the next segment begins: the tip's shares and what holds the needle on its axis are other
// ones there.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/embedded_track.hpp"
#include "stylet/needle/reference_path.hpp"

#include <optional>
#include <span>
#include <vector>

namespace stylet {

class EmbeddedPath final : public ReferencePath {
 public:
  /// The mesh is lent. tissue.membrane_surface: its triangles. The tip stands at the skin, at the place 0 along
  /// the axis.
  EmbeddedPath(const Mesh& mesh,
               EmbeddedTrack track,
               double tip_length,
               double radius,
               bool stops_at_ends,
               NeedleTissue tissue);

  [[nodiscard]] double length() const override { return base_ + b_; }
  [[nodiscard]] double tip_along() const override { return length(); }
  [[nodiscard]] bool is_uncut() const override { return length() == 0; }
  [[nodiscard]] WorldPlace on_axis(double along) const override;
  [[nodiscard]] ReferencePlace tip_point() const override { return way_.at(length() - exposed_); }
  [[nodiscard]] int tip_cell() const override { return cell_; }
  [[nodiscard]] std::vector<ReferencePlace> line() const override;
  [[nodiscard]] const EmbeddedTrack& way() const { return way_; }

  [[nodiscard]] bool at_membrane() const override { return membrane_.has_value(); }
  [[nodiscard]] double modulus_ahead() const override;
  [[nodiscard]] double element_size() const override;
  [[nodiscard]] std::vector<PointShare> tip_shares() const override;
  [[nodiscard]] double tip_rest() const override { return rest_; }
  [[nodiscard]] std::vector<double> shaft_lengths() const override;
  [[nodiscard]] std::vector<int> loaded_points() const override;
  void guide(int point, std::vector<TrackHold>& held) const override;
  [[nodiscard]] SparseRow row(TrackPlace place) const override { return way_.row(place); }
  [[nodiscard]] double rest(TrackPlace a, TrackPlace b) const override { return way_.rest(a, b); }
  [[nodiscard]] int n_components() const override { return 3; }
  [[nodiscard]] int n_points() const override { return way_.size(); }

  void uncover(double to,
               const TrackTrial& trial,
               const std::optional<FrictionParameters>& friction,
               double speed) override;

  bool pass_end() override;
  void puncture() override;
  void new_base() override;
  [[nodiscard]] bool wants_edit() const override { return leaves_ || remaining_ != 0; }
  Plan plan(const NeedleView& start) override;
  void archive(Archive& archive) override;

 private:
  [[nodiscard]] int last() const { return static_cast<int>(track_.size()) - 1; }
  bool find_base();
  void stand();

  const Mesh& mesh_;
  EmbeddedTrack way_;
  std::vector<double>
      crossings_;  ///< depths at which the membrane crosses the track (m), ascending
  std::optional<double> membrane_;  ///< depth at which the tip stands at it, not yet punctured
  double base_ = 0;                 ///< depth at which the present base begins (m)
  int cell_ = 0;                    ///< at the tip
  double rest_ = 0;                 ///< of the tip's load, see EmbeddedTrack::rest_of_ends
  bool leaves_ = false;             ///< the tip has come to the end of the track
};

}  // namespace stylet
