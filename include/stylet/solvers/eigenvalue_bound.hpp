// A bound on the largest eigenvalue of A = M^-1/2 K M^-1/2 with lumped mass, kept up to date with the
// mesh: for any positive x, max_i (|A| x)_i / x_i is one (Collatz and Wielandt). The smaller of two is
// taken: of x = 1 (Gershgorin), and of an x near the best one for the mesh as it was at the start.
#pragma once

#include "stylet/base/archive.hpp"
#include "stylet/fem/tissue_operator.hpp"
#include "stylet/solvers/maximum_tree.hpp"

#include <span>
#include <vector>

namespace stylet {

class EigenvalueBound {
 public:
  /// Collective. The tissue is lent.
  explicit EigenvalueBound(const TissueOperator& tissue);
  /// Collective. changed: nodes with a new row or mass; rows: theirs and those that couple to them. Both
  /// ascending.
  void update(std::span<const int> changed, std::span<const int> rows);
  /// (rad/s)^2, of all ranks.
  [[nodiscard]] double value() const { return bound_; }
  /// Collective. The x that belongs to the mesh as it was at the start.
  void archive(Archive& archive);
  /// 1/sqrt of the nodal masses (kg) of all nodes.
  [[nodiscard]] const std::vector<double>& inverse_roots() const { return inverse_root_; }

 private:
  /// Of a node, for either x.
  struct Bounds {
    double even;
    double weighted;
  };
  void make_weights();
  void renew_all();
  void renew(std::span<const int> rows);
  [[nodiscard]] Bounds row_bounds(int node) const;

  const TissueOperator& tissue_;
  std::vector<double> inverse_root_;
  std::vector<double> weights_;  ///< x of all dofs
  MaximumTree even_;             ///< of owned nodes, (rad/s)^2
  MaximumTree weighted_;
  double bound_ = 0;
};

}  // namespace stylet
