// One explicit step in two passes over the nodes, where PETSc's vector operations would take nine, and
// with K in blocks, which are three quarters of its bytes in AIJ. Plain arrays; dof = 2 node +
// component.
#pragma once

#include <petscmat.h>

#include <cstddef>
#include <span>
#include <vector>

namespace stylet {

/// K of one rank in 2 x 2 blocks, row by row of nodes.
class BlockRows {
 public:
  BlockRows() = default;
  /// k: SeqAIJ; both rows of a node have the same columns, which come in pairs.
  explicit BlockRows(Mat k);
  /// Takes the rows of these nodes anew; all rows if one has got another length.
  void update(Mat k, std::span<const int> nodes);

  struct Row {
    std::size_t n;
    const int* columns;    ///< nodes
    const double* values;  ///< four a block: xx, xy, yx, yy
  };
  struct View {
    const std::size_t* first;
    const int* columns;
    const double* values;
    Row operator[](std::size_t node) const {
      return {first[node + 1] - first[node], columns + first[node], values + 4 * first[node]};
    }
  };
  [[nodiscard]] View view() const { return {first_.data(), columns_.data(), values_.data()}; }

 private:
  std::vector<std::size_t> first_;
  std::vector<int> columns_;
  std::vector<double> values_;
};

struct ExplicitArrays {
  std::size_t n_nodes;
  const double* u0;  ///< start of the step
  const double* v0;
  const double* a0;
  double* u;  ///< end of the step
  double* v;  ///< after `predict` the velocity of the half step
  double* a;
  double* stretched;           ///< u + stiffness_factor v of the half step; u where that is 0
  const double* load;          ///< null if there is none
  const double* mass;          ///< one a node
  const double* inverse_root;  ///< 1 / sqrt(mass)
};

/// Sums that the work of mass damping is made of; v is that of the half step.
struct MassWork {
  double start = 0;  ///< v0 M v
  double half = 0;   ///< v M v
};

/// v = v0 + h/2 a0, u = u0 + h v, stretched = u + stiffness_factor v.
MassWork predict(const ExplicitArrays& x, double h, double stiffness_factor);

/// Products with the velocity of the half step.
struct Power {
  double load = 0;
  double rest = 0;  ///< of load - force
};

/// force = K stretched:
/// a = ((load - force)/mass - mass_factor v) / (1 + h/2 mass_factor), v = v + h/2 a.
Power accelerate(const ExplicitArrays& x, const BlockRows& k, double h, double mass_factor);
/// The same where the force is known.
Power accelerate(const ExplicitArrays& x, const double* force, double h, double mass_factor);

}  // namespace stylet
