// SPDX-License-Identifier: MIT
// All estimated parameters of a fit under the names that people read.
#pragma once

#include <string>
#include <vector>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

struct NamedValue {
  std::string name{};
  double value = 0.0;
};

/// Coefficients, `sd(a)` and `cor(a, b)` of the random effects (`sd(a | stand)` where there are two
/// groupings), parameters of the variance function that are not held (`delta`, `constant`, `ratio`,
/// each `of` its stratum; with several factors the factor's text comes first), and `sigma`.
///
/// A correlation is NaN where a standard deviation is zero.
std::vector<NamedValue> parameter_values(const FittedModel& fit);

}  // namespace silvafit::fit
