// SPDX-License-Identifier: MIT
// Gauss-Hermite quadrature over several standard normal variables.
#pragma once

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Nodes and weights such that sum w_k f(x_k) is the expectation of f under N(0, I), exactly for
/// polynomials of degree up to 2 K - 1 in each variable.
struct QuadratureRule {
  MatrixXd nodes{};    ///< (q x K^q)
  VectorXd weights{};  ///< (K^q) they add up to 1
};

/// Each weight has a small relative error: rules of 40 points and more have weights below 1e-30,
/// which matter if f grows as fast.
/// \param points      K >= 1 a variable, up to 100
/// \param dimensions  q >= 1
/// Source: Golub and Welsch 1969, Mathematics of Computation 23, 221-230, for the nodes; weights
/// are Christoffel numbers.
QuadratureRule gauss_hermite(int points, Index dimensions);

}  // namespace silvafit::fit
