// SPDX-License-Identifier: MIT
// Whether a fitted model is a special case of another one.
#pragma once

#include <string>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// The relation of two fits.
struct Nesting {
  bool is_nested = false;
  std::string reason{};  ///< reason why there is no test
  /// Number of additional estimated coefficients, and variances and covariances of common effects,
  /// of the larger model. Parameters of the variance function are not counted.
  int regular = 0;
  /// Random effects that only the larger model has, and whose covariances with others (of old and
  /// of new ones) are free.
  int correlated_effects = 0;
  /// Random effects that only the larger model has, independent of all others.
  int independent_effects = 0;
  /// The smaller model has a parameter of the variance function or the residuals' correlation at a
  /// bound.
  bool has_other_edge = false;
  /// A coefficient that the larger model estimates is at a bound in the smaller.
  bool has_bounded = false;
};

/// Whether `smaller` is a special case of `larger`, by their structure: the same formula,
/// sub-models with fewer covariates, fewer random effects or a simpler covariance, a simpler
/// variance function.
///
/// A coefficient that is held or at a bound (it has no variance) is a special case of one that is
/// estimated or held at the same value; a missing coefficient is treated as held at 0. Random
/// effects by a column are compared only if the labels of the groups show that both fits have the
/// same groups. The smaller model may lack a variance function only if that of the larger one can
/// be constant.
Nesting nesting(const FittedModel& larger, const FittedModel& smaller);

}  // namespace silvafit::fit
