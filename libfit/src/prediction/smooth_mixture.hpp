// SPDX-License-Identifier: MIT
// The distribution of f(u) + s(u) e, with u and e standard normal, as a mixture of few normal
// distributions without gaps between them.
#pragma once

#include "conditional_modes/quadrature_rule.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Points a quarter of a standard deviation apart in the first direction, those of a rule in the
/// others. Smooth where s is not below a fifth of what f changes per unit of the first variable.
/// \param others  (q - 1 variables) one point without a variable if q = 1
QuadratureRule dense_rule(const QuadratureRule& others);

/// The same points with other weights, for close_gaps; points that differ in the first direction
/// alone are others.weights.size() apart.
///
/// A standard normal variable is the sum of two independent ones: the points integrate over the
/// one, and close_gaps gives the other, a fifth of a standard deviation, to the components. The
/// weights of the points are those of the first; the outermost points have none.
QuadratureRule gapless_rule(const QuadratureRule& others);

/// Widens the components of a mixture at the points of gapless_rule by the change of f around each
/// point. The result is a mixture without steps for any s: if f is linear and s constant it is the
/// normal distribution to 1e-6. Components without finite neighbors are unchanged.
/// \param means       (K) f at the points; become means over the neighborhood of the points
/// \param deviations  (K) s at the points; become standard deviations of f + s e there
/// \param stride      others.weights.size()
void close_gaps(Eigen::Ref<VectorXd> means, Eigen::Ref<VectorXd> deviations, Index stride);

/// The product of two rules, of some variables and of others.
QuadratureRule product_rule(const QuadratureRule& first, const QuadratureRule& others);

}  // namespace silvafit::fit
