// SPDX-License-Identifier: MIT
// Square roots of covariance matrices that may be singular.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace silvafit::study {

/// A lower triangular L with L L' = covariance, or none if the matrix is not positive semidefinite
/// (to 1e-10 of its diagonal). Plain loops, so that the result has the same bytes on all
/// processors.
std::optional<Eigen::MatrixXd> covariance_root(const Eigen::MatrixXd& covariance);

}  // namespace silvafit::study
