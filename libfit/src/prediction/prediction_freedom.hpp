// SPDX-License-Identifier: MIT
// Degrees of freedom of the variances that predictions are made of.
#pragma once

#include <algorithm>
#include <cmath>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// Degrees of freedom of a sum of variances that were estimated independently (Satterthwaite).
class Satterthwaite {
 public:
  void add(double variance, double degrees_of_freedom) {
    sum_ += variance;
    squares_ += variance * variance / degrees_of_freedom;
  }
  double value(double otherwise) const {
    return squares_ > 0.0 ? sum_ * sum_ / squares_ : otherwise;
  }

 private:
  double sum_ = 0.0;
  double squares_ = 0.0;
};

/// Degrees of freedom of the residual variance: those of the t tests within the finest groups.
/// Coefficients that are held have none.
inline double residual_freedom(const FittedModel& fit) {
  double freedom = 1.0;
  for (const double value : fit.degrees_of_freedom) {
    if (std::isfinite(value)) freedom = std::max(freedom, value);
  }
  return freedom;
}

/// Degrees of freedom of the parts of a fit's variance.
struct Freedom {
  double residual = 1.0;
  double inner = 1.0;
  double outer = 1.0;

  explicit Freedom(const FittedModel& fit) {
    residual = residual_freedom(fit);
    const auto groups = static_cast<double>(fit.group_labels.size());
    const auto clusters = static_cast<double>(fit.outer.labels.size());
    inner = std::max(1.0, groups - (clusters > 0.0 ? clusters : 1.0));
    outer = std::max(1.0, clusters - 1.0);
    if (clusters == 0.0) outer = inner;
    if (!fit.has_random_effects()) inner = outer = residual;
  }
};

}  // namespace silvafit::fit
