// SPDX-License-Identifier: MIT
// Roots of covariance matrices that may be singular.
#pragma once

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// R with R R' = covariance, from the eigenvectors of the correlation matrix, so that effects may
/// have very different sizes. Eigenvalues that are rounding errors are set to zero.
Eigen::MatrixXd covariance_factor(const Eigen::MatrixXd& covariance);

/// The symmetric R with R R = covariance; negative eigenvalues, which are rounding errors, are set
/// to zero. Unlike the factor above it does not depend on the order and signs of eigenvectors.
Eigen::MatrixXd symmetric_root(const Eigen::MatrixXd& covariance);

/// The coefficients of the regression of some effects on others: cross * inverse(covariance), where
/// directions without variance have none.
/// \param cross       (q x s) covariance with the others
/// \param covariance  (s x s) of the others
Eigen::MatrixXd regression_on(const Eigen::MatrixXd& cross, const Eigen::MatrixXd& covariance);

}  // namespace silvafit::fit
