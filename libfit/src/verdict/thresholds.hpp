// SPDX-License-Identifier: MIT
// The thresholds that decide what is said of a fit, each with its reason. Those of the search are
// in optimization/tolerances.hpp.
#pragma once

#include <limits>

namespace silvafit::fit {

struct Thresholds {
  // Coefficients.

  /// A coefficient is poorly determined if its standard error is so many times its size, and the
  /// curve without it is away by more than kFelt residual standard deviations: one that the curve
  /// does not need is near zero anyway.
  static constexpr double kLoose = 10.0;
  static constexpr double kFelt = 1.0;
  /// A coefficient has reached infinity if its relative change moves the mean by rounding errors
  /// only, although the mean changes without it.
  static constexpr double kUnfelt = 1e-12;
  static constexpr double kFeltWithout = 1e-6;
  /// Smallest eigenvalue of the correlation of the estimates, relative to the largest: rounding
  /// errors of the information are 1e-15 of it.
  static constexpr double kConfounded = 1e-12;
  /// The standard error of a mean of G groups is at least their deviation over the root of G; a
  /// tenth of it is that of a singular information matrix.
  static constexpr double kImpossible = 0.1;
  /// A standard error is understated if that by the expected information is so many times larger,
  /// and at kErrors of it the log-likelihood has not fallen by kFlat: a parabola would fall by 8,
  /// or by kFlat at an error that many times as large.
  static constexpr double kFar = 2.0;
  static constexpr double kErrors = 4.0;
  static constexpr double kFlat = 2.0;

  // Perfect fits.

  /// A root of the sum of squares within a few units of the last digit of the response is zero.
  static constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();
  /// Residuals that are smaller relative to the response's spread are rounding errors: measurements
  /// do not have so many digits.
  static constexpr double kRoundedResidual = 1e-6;
  /// The same where random effects can fit each group exactly and compete with the residual.
  static constexpr double kNothingLeft = 1e-2;

  // Random effects.

  /// Curves at larger distances, in spreads of the response, are degenerate.
  static constexpr double kBeyondMeasure = 1e6;
  /// Curves with smaller differences, in spreads of the response, are equal.
  static constexpr double kSame = 1e-6;
  /// The two sides of a saturated effect differ by more than this, else there is no effect.
  static constexpr double kTwoSides = 1e-3;
  /// Effects with this share of the largest diverge together.
  static constexpr double kShare = 0.5;
  /// A standard deviation is zero if it changes the mean by less than this share of the residual
  /// one: its log-likelihood is that of zero within rounding.
  static constexpr double kShareOfSigma = 1e-4;
  /// Smallest eigenvalue of a correlation matrix below which effects are linearly dependent.
  static constexpr double kDependence = 1e-6;
  /// Smallest eigenvalue of the Gram matrix of normalized matrices, for angles of at least a
  /// millionth; rounding errors are about 1e-15.
  static constexpr double kDependent = 1e-12;
  /// Changes that are smaller relative to the largest are rounding errors.
  static constexpr double kUnmoved = 1e-6;

  // The variance function.

  /// A power counts at an observation from a tenth of the constant on, and matters for few if these
  /// are less than a tenth of all.
  static constexpr double kCounts = 0.1;
  static constexpr double kFew = 0.1;
  /// A power whose values differ a thousandfold where those of the variable differ twofold is a
  /// step.
  static constexpr double kSteep = 10.0;

  // Likelihoods.

  /// A linearization is useless if it is off by this per observation: 100 observations would be
  /// taken for a model with 20 parameters more or less.
  static constexpr double kUseless = 0.1;
  /// A maximum so far below a point that was reached elsewhere says nothing about the data.
  static constexpr double kFarBelow = 20.0;
};

}  // namespace silvafit::fit
