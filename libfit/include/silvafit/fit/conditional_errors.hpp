// SPDX-License-Identifier: MIT
// Standard errors of random effects given the data.
#pragma once

#include "silvafit/fit/effect_uncertainty.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// (q x G) conditional standard errors of the random effects of each group, given its data and the
/// estimates: the roots of the diagonals of V, without the error of the coefficients; see
/// EffectUncertainty.
/// \param uncertainty  known
/// \param q            effects of a group
inline Eigen::MatrixXd conditional_errors(const EffectUncertainty& uncertainty, Eigen::Index q) {
  Eigen::MatrixXd result(q, uncertainty.covariances.cols());
  for (Eigen::Index k = 0; k < q; ++k) {
    result.row(k) = uncertainty.covariances.row(k * q + k).cwiseMax(0.0).cwiseSqrt();
  }
  return result;
}

}  // namespace silvafit::fit
