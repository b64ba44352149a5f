// SPDX-License-Identifier: MIT
// Coefficients that are places on the axis of a column, such as b in a/(1 + exp((b - x)/c)).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// A coefficient whose size has nothing to do with its effect: b and x, or b and log(x), may be
/// shifted together. Its values are to be looked for where the observations are.
struct LocationCoefficient {
  Eigen::Index coefficient = 0;
  double lowest = 0.0;   ///< of the column, of its logarithm, or of minus that
  double highest = 0.0;  ///< above the lowest one
};

/// The coefficients by which the mean is a function of differences: those b_k for which the slope
/// of the mean by a column x, or by its logarithm, is a sum of -db_k or db_k everywhere. Of the sum
/// of two logistic curves there are two, and of a logarithm of a rate there is one. \param model
/// without covariates of its parameters
std::vector<LocationCoefficient> location_coefficients(const NonlinearModel& model);

}  // namespace silvafit::fit
