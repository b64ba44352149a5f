// SPDX-License-Identifier: MIT
// Boundary (singular) fits: variance components at their bounds.
#pragma once

#include <string>
#include <vector>

#include "model/coefficient_frame.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The derivatives of the population's mean at the estimates.
struct PopulationSlopes {
  VectorXd sizes{};          ///< (p) root mean squares of the derivatives by the coefficients
  CoefficientFrame frame{};  ///< of the coefficients
};

PopulationSlopes population_slopes(const NonlinearModel& model, const MixedEffectsFit& fit);

/// (N) the variable of a factor of the variance function.
VectorXd variable_of(const NonlinearModel& model,
                     const MixedEffectsFit& fit,
                     const VarianceFactorEstimate& factor);

/// What the data say about one exponent of constant-plus-power.
struct PowerUse {
  std::string stratum{};  ///< empty without strata
  double delta = 0.0;
  /// Whether the power, or the constant, is negligible beside the other at all observations.
  bool is_absent = false;
  bool is_alone = false;
  /// The number of observations for which the power is relevant, if these are few, or if it is so
  /// steep that it is nothing for the others; otherwise 0.
  Index few = 0;
  /// Size of the variable at the only observations for which the power matters: an exponent without
  /// bound fits as well. NaN if it matters for several sizes.
  double only_at = kNaN;
};
/// Of each exponent of a factor; empty for other functions, or with a constant that is held.
/// \param v  (N) the variable of the factor
std::vector<PowerUse> power_uses(const NonlinearModel& model,
                                 const VarianceFactorEstimate& factor,
                                 const VectorXd& v);

/// About the smallest variance of a combination of a group's standardized residuals by ar1,
/// compound symmetry or a symmetric structure; 1 for others.
double least_variance(const CorrelationEstimate& estimate);

/// Strata whose residuals are negligible beside what the random effects leave of them: without
/// these residuals the log-likelihood falls by at most the sum of their squared shares. Known for
/// independent residuals.
std::vector<std::string> strata_without_residuals(const NonlinearModel& model,
                                                  const MixedEffectsFit& fit);

/// Fills in the boundary of a fit's convergence: standard deviations of 0, correlations of 1 or -1,
/// variance functions whose constant or power vanishes, and ends of the residuals' correlation.
/// \return those that no simpler structure has: theta1 = -1, rho = 1, a range without bound ...
std::vector<std::string> name_boundary(const NonlinearModel& model,
                                       const PopulationSlopes& slopes,
                                       MixedEffectsFit& fit);

}  // namespace silvafit::fit
