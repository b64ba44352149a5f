// SPDX-License-Identifier: MIT
// The logistic map: azimuths that look random and are the same again for the same start.
#pragma once

namespace silvafit::tree {

/// X' = mu X (1 - X).
///
/// At mu = 4 the values have the arcsine density 1 / (pi sqrt(x (1 - x))): they crowd near 0 and 1.
/// Source: Liu et al. 2022, equation 8; May 1976, Nature 261: 459-467.
class LogisticMap {
 public:
  static constexpr double kLeastMu = 3.56994;
  static constexpr double kMostMu = 4.0;

  /// \throws UsageError if mu is outside [3.56994, 4] or x0 outside (0, 1); also if the values soon
  /// repeat, as they do from x0 = 0.5 (1, then 0 for ever) and 0.75 (a fixed point) at mu = 4, and
  /// from anywhere at a mu in one of the map's periodic windows, such as 3.83
  LogisticMap(double mu, double x0);

  /// Whether mu and x0 are in range and the values do not soon repeat.
  static bool is_chaotic(double mu, double x0);

  /// X_1, X_2, ...; each in (0, 1).
  ///
  /// Doubles are finitely many, so that a very long sequence may round into 0, 1 or a fixed point;
  /// it then goes on from another start that follows from x0.
  double next();

 private:
  double mu_;
  double x0_;
  double x_;
  int restarts_ = 0;
};

}  // namespace silvafit::tree
