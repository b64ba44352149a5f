// SPDX-License-Identifier: MIT
// How far apart the nodes of adaptive quadrature are.
#pragma once

#include "model/small_matrix.hpp"

namespace silvafit::fit {

/// The scale of the nodes of a group, mode + C^-T x with C C' = f(H). H is the Hessian of the
/// spherical random effects at their mode, the identity without data. f leaves it alone unless an
/// eigenvalue is below 0.5, where the density is on its way to two modes; it raises those, to 0.25
/// at least, so that the nodes stay where the random effects' own distribution is. It has two
/// continuous derivatives.
/// Source of the nodes: Pinheiro and Bates 1995, J. Comput. Graph. Stat. 4, 12-35.
class NodeScale {
 public:
  NodeScale() = default;
  /// \param hessian  (q x q) H
  explicit NodeScale(const SmallMatrix& hessian);

  const SmallMatrix& lower() const { return lower_; }  ///< C
  double log_determinant() const;                      ///< log|f(H)|
  /// The derivative by H from that by C.
  SmallMatrix by_hessian(const SmallMatrix& by_lower) const;

 private:
  SmallMatrix lower_{};
  SmallMatrix vectors_{};  ///< of H
  SmallMatrix slopes_{};   ///< divided differences of f at the eigenvalues; empty for f(H) = H
};

}  // namespace silvafit::fit
