// SPDX-License-Identifier: MIT
// Eigenvalues of symmetric matrices, checked, and roots of covariances.
#pragma once

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

struct SymmetricEigen {
  VectorXd values{};   ///< ascending
  MatrixXd vectors{};  ///< in columns, each of length 1
};

/// All NaN if the matrix has entries that are not finite, or if the iteration does not converge, so
/// that results that depend on them are NaN, too.
/// \param matrix  of which the lower triangle is read
SymmetricEigen symmetric_eigen(const MatrixXd& matrix);

/// R with R R' = covariance, from the eigenvectors of the correlation matrix, so that effects may
/// have very different sizes. Eigenvalues that are rounding errors are set to zero.
MatrixXd covariance_factor(const MatrixXd& covariance);

/// The symmetric R with R R = covariance; negative eigenvalues, which are rounding errors, are set
/// to zero. Unlike the factor above it does not depend on the order and signs of eigenvectors.
MatrixXd symmetric_root(const MatrixXd& covariance);

}  // namespace silvafit::fit
