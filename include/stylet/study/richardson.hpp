// Order, limit and uncertainty of a value on several levels of refinement.
//
// P. J. Roache, Verification and Validation in Computational Science and Engineering, 1998 (Grid
// Convergence Index); L. Eca and M. Hoekstra, J. Comput. Phys. 262, 2014 (least squares).
#pragma once

#include <span>
#include <string>
#include <vector>

namespace stylet {

struct Extrapolation {
  double order = 0;    ///< observed; not a number where the values do not tell one
  double limit = 0;    ///< by Richardson with that order; the finest value where there is none
  double safety = 0;   ///< 1.25 where the order is sensible, else 3
  double scatter = 0;  ///< standard deviation around the fit; four levels and more
  std::string remark;  ///< empty where the order is sensible
  /// Of every level, coarsest first: half width of the band around its value that should hold the
  /// limit, in the unit of the values.
  std::vector<double> uncertainty;
};

/// Of a value with an error that is known to go with this power of a size: at this size, and at one `ratio`
/// times smaller.
[[nodiscard]] Extrapolation extrapolate_known(double at_size,
                                              double at_smaller,
                                              double ratio,
                                              double order);

/// values: coarsest first, each level `ratio` times finer than the one before, at least two. Three
/// levels are solved for the order, four and more fitted by least squares. formal_order: the highest
/// that is believed. An order from 0.5 to formal_order + 0.1 is sensible.
[[nodiscard]] Extrapolation extrapolate(std::span<const double> values,
                                        double ratio,
                                        double formal_order);

}  // namespace stylet
