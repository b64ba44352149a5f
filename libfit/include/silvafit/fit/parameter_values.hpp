// SPDX-License-Identifier: MIT
// All estimated parameters of a fit with their reported names.
#pragma once

#include <string>
#include <vector>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

struct NamedValue {
  std::string name{};
  double value = 0.0;
};

/// Coefficients, `sd(a)` and `cor(a, b)` of the random effects (`sd(a | stand)` for two groupings),
/// parameters of the variance function that are not held (`delta`, `constant`, `ratio`, each `of`
/// its stratum; with several factors after the factor's text), those of the residuals' correlation
/// (`phi`, `range`, ...), `sigma`, and derived quantities.
///
/// A correlation is NaN if a standard deviation is zero.
std::vector<NamedValue> parameter_values(const FittedModel& fit);

}  // namespace silvafit::fit
