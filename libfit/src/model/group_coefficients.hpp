// SPDX-License-Identifier: MIT
// What a fit's random effects add to the coefficients of each group of a model's data.
#pragma once

#include <Eigen/Core>

#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// (p x G) estimated effects of both groupings by the groups' labels; zero for groups that the fit
/// has not seen.
Eigen::MatrixXd coefficient_effects(const FittedModel& fit, const NonlinearModel& model);

}  // namespace silvafit::fit
