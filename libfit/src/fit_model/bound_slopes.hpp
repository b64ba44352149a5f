// SPDX-License-Identifier: MIT
// The slope of the likelihood at coefficients that a fit holds.
#pragma once

#include <map>
#include <string>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// A fit as one point of the likelihood of the model with the held coefficients free.
struct HeldPoint {
  /// The log-likelihood by which fits with other coefficients held can be compared: that of the
  /// fit; for restricted likelihood the unrestricted one at the same estimates, since restricted
  /// likelihoods are of other contrasts for each set of free coefficients.
  double value = 0.0;
  /// By held coefficient: the change of the log-likelihood per standard error of this coefficient
  /// alone, positive if it increases with the coefficient. With the others at their maximum it is
  /// the slope of the profile likelihood, the Lagrange multiplier of the bound.
  std::map<std::string, double> slopes{};
};

/// Whether a slope differs from zero: a smaller one changes the log-likelihood by about 1e-8, which
/// is less than the tolerance of a fit.
bool is_slope(double slope);

/// Slopes are those of the likelihood of confidence intervals (inference.md): exact for marginal
/// likelihoods, ols and gnls; for lb of the model that is linear around the estimates. All are zero
/// for a perfect fit, which no other fit improves.
/// \param fit    converged, described as that of the whole model
/// \param fixed  coefficients that stay held
/// \param held   coefficients whose slopes are asked for, at their values in the fit
/// Cost: three gradients a held coefficient, no fit.
HeldPoint at_held(const FittedModel& fit,
                  const data::Table& table,
                  const std::map<std::string, double>& fixed,
                  const std::map<std::string, double>& held);

}  // namespace silvafit::fit
