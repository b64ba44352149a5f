// SPDX-License-Identifier: MIT
// Frequencies, periods and phases: coefficients within a sine or cosine.
#pragma once

#include <cstddef>
#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// A coefficient w of sin(w*x + ...), or P of sin(x/P + ...), and its identifiable values.
///
/// With m distinct values of x over a range R, the sum of squares as a function of w has peaks of
/// width 2*pi/R. Frequencies above pi*(m - 1)/R, the Nyquist frequency of equally spaced
/// observations, give the values of lower ones.
struct PeriodicCoefficient {
  Index coefficient = 0;
  bool is_period = false;  ///< P and not w
  double step = 0.0;       ///< of frequencies: a quarter of a peak's width
  std::size_t count = 0;   ///< of steps up to the highest frequency that is searched

  /// The value at a number of steps, not 0.
  double value(double number) const;
  /// Whether a value is no more than the highest frequency.
  bool contains(double value) const;
  /// Whether two values belong to the same peak.
  bool are_near(double a, double b) const;

 private:
  double frequency(double value) const;
};

/// The periodic coefficients among the parameters without covariates. At most 4,000 steps are
/// searched for each: many observations, or some that are very close, allow more frequencies than
/// are useful.
std::vector<PeriodicCoefficient> periodic_coefficients(const NonlinearModel& model);

/// A coefficient that shifts the argument of a sine or cosine by the same angle at all
/// observations, such as t of cos(2*pi*(x - t)/P). Its shifts by a period leave the mean unchanged.
struct PhaseCoefficient {
  Index coefficient = 0;
  double period = 0.0;         ///< positive
  double lowest_shift = 0.0;   ///< with it the largest argument becomes 0, or the smallest one
  double highest_shift = 0.0;  ///< not below the lowest one
};

/// The phases among the parameters without covariates.
/// \param coefficients  (p) at which the period is evaluated
std::vector<PhaseCoefficient> phase_coefficients(const NonlinearModel& model,
                                                 const VectorXd& coefficients);

}  // namespace silvafit::fit
