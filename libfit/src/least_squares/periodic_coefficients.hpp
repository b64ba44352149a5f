// SPDX-License-Identifier: MIT
// Frequencies and periods: coefficients within a sine or cosine.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// A coefficient w of sin(w*x + ...), or P of sin(x/P + ...), and the values that can be told
/// apart.
///
/// With m distinct values of x over a range R, the sum of squares as a function of w has peaks of
/// width 2*pi/R, and frequencies above pi*(m - 1)/R, Nyquist's of observations at equal distances,
/// have the values of lower ones.
struct PeriodicCoefficient {
  Eigen::Index coefficient = 0;
  bool is_period = false;  ///< P and not w
  double step = 0.0;       ///< of frequencies: a quarter of a peak's width
  std::size_t count = 0;   ///< of steps up to the highest frequency that is searched

  /// The value at a step from 1 to count.
  double value(std::size_t number) const;
  /// Whether a value is no more than the highest frequency.
  bool contains(double value) const;
  /// Whether two values belong to the same peak.
  bool are_near(double a, double b) const;

 private:
  double frequency(double value) const;
};

/// The periodic coefficients of a model without covariates. At most 4,000 steps are searched of
/// one: many observations, or a few very near each other, allow more frequencies than anyone asks
/// for.
std::vector<PeriodicCoefficient> periodic_coefficients(const NonlinearModel& model);

}  // namespace silvafit::fit
