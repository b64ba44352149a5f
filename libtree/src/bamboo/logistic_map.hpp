// SPDX-License-Identifier: MIT
// The logistic map: irregular azimuths that are reproducible from the start value.
#pragma once

namespace silvafit::tree {

/// X' = mu X (1 - X).
///
/// At mu = 4 the values have the arcsine density 1 / (pi sqrt(x (1 - x))): they concentrate at 0
/// and 1. Source: Liu et al. 2022, equation 8; May 1976, Nature 261: 459-467.
class LogisticMap {
 public:
  static constexpr double kLeastMu = 3.56994;
  static constexpr double kMostMu = 4.0;

  /// \throws UsageError if mu is outside [3.56994, 4] or x0 outside (0, 1); also if the values soon
  /// repeat, as from x0 = 0.5 (1, then always 0) and 0.75 (a fixed point) at mu = 4, and
  /// from any start at a mu in one of the map's periodic windows, such as 3.83
  LogisticMap(double mu, double x0);

  /// Whether mu and x0 are in range and the values do not soon repeat.
  static bool is_chaotic(double mu, double x0);

  /// X_1, X_2, ...; each in (0, 1).
  ///
  /// The number of doubles is finite, so that a very long sequence may round to 0, 1 or a fixed
  /// point; it then continues from another start value that depends on x0.
  double next();

 private:
  double mu_;
  double x0_;
  double x_;
  int restarts_ = 0;
};

}  // namespace silvafit::tree
