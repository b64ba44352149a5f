// SPDX-License-Identifier: MIT
// From a start downhill: Levenberg-Marquardt over the nonlinear coefficients.
#pragma once

#include <Eigen/Core>

#include "least_squares/variable_projection.hpp"

namespace silvafit::fit {

struct DescentOptions {
  int maximum_iterations = 500;
  /// Stops where an iteration lowers the sum of squares by less than this share.
  double tolerance = 1e-14;
  /// Number of a nonlinear coefficient that does not move, -1 for none.
  int held = -1;
};

/// The lowest point that a descent saw.
struct Descent {
  Eigen::VectorXd coefficients{};  ///< (p) all of them
  double sum_of_squares = 0.0;     ///< infinite if the start has no finite mean
  int iterations = 0;
};

/// \param nonlinear  (q) where to start
Descent descend(ProjectedModel& model,
                const Eigen::VectorXd& nonlinear,
                const DescentOptions& options);

}  // namespace silvafit::fit
