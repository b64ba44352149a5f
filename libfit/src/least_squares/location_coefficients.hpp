// SPDX-License-Identifier: MIT
// Coefficients that are locations on the axis of a column, such as b in a/(1 + exp((b - x)/c)).
#pragma once

#include <string>
#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// A coefficient whose effect does not depend on its size: b and x, or b and log(x), may be shifted
/// together. Its start values are in the range of the observations.
struct LocationCoefficient {
  Index coefficient = 0;
  double lowest = 0.0;   ///< of the column, of its logarithm, or of minus that
  double highest = 0.0;  ///< above the lowest one
};

/// The coefficients by which the mean is a function of differences: those b_k for which the slope
/// of the mean by a column x, or by its logarithm, is a sum of -db_k or db_k everywhere. A sum of
/// two logistic curves has two, the logarithm of a rate is another.
/// \param model  without covariates of its parameters
std::vector<LocationCoefficient> location_coefficients(const NonlinearModel& model);

/// The middle of a column that is far from 0, in units of its range.
inline constexpr double kFarFromZero = 10.0;

/// A column whose values are far from 0 compared with their range, such as calendar years, although
/// the formula with the column shifted is the same curve with other coefficients.
struct FarColumn {
  std::string name{};
  double middle = 0.0;
};

/// \param model  without covariates of its parameters
std::vector<FarColumn> far_columns(const NonlinearModel& model);

}  // namespace silvafit::fit
