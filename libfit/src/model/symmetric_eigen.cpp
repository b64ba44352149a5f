// SPDX-License-Identifier: MIT
#include "model/symmetric_eigen.hpp"

#include <Eigen/Eigenvalues>

#include "silvafit/base/constants.hpp"

namespace silvafit::fit {

SymmetricEigen symmetric_eigen(const MatrixXd& matrix) {
  const Eigen::Index size = matrix.rows();
  if (size == 0) return {};
  if (matrix.allFinite()) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(matrix);
    if (solver.info() == Eigen::Success) return {solver.eigenvalues(), solver.eigenvectors()};
  }
  return {VectorXd::Constant(size, kNaN), MatrixXd::Constant(size, size, kNaN)};
}

}  // namespace silvafit::fit
