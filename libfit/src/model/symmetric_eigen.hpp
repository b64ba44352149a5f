// SPDX-License-Identifier: MIT
// Eigenvalues and eigenvectors of symmetric matrices, checked.
#pragma once

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

struct SymmetricEigen {
  Eigen::VectorXd values{};   ///< ascending
  Eigen::MatrixXd vectors{};  ///< in columns, each of length 1
};

/// All NaN if the matrix has entries that are not finite, or if the iteration does not converge, so
/// that results that depend on them are NaN, too.
/// \param matrix  of which the lower triangle is read
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix);

}  // namespace silvafit::fit
