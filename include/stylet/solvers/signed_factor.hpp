// L J L^T = P A P^T of a quasi-definite A, J = diag(+-1) given: what CHOLMOD has for definite ones only. The
// pattern of L is that of CHOLMOD's analysis; the numbers come front by front, each from the columns to the
// left that reach it. Source: Y. Chen, T. Davis, W. Hager, S. Rajamanickam, ACM Trans. Math. Softw. 35
// (2008) 22, section 3.
#pragma once

#include <cholmod.h>
#include <span>
#include <vector>

namespace stylet {

/// upper: of A, sorted columns; signs: of J by column of L; values: those of L, laid out as CHOLMOD's. False
/// if a pivot has another sign or is none.
[[nodiscard]] bool factor_signed(const cholmod_factor& pattern,
                                 const cholmod_sparse& upper,
                                 std::span<const double> signs,
                                 std::vector<double>& values);

}  // namespace stylet
