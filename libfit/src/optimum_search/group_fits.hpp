// SPDX-License-Identifier: MIT
// Least-squares fits to single groups, as by nlsList of R's nlme.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// (K) the median of each parameter over fits to single groups.
///
/// Each group with enough observations is fitted from the pooled coefficients, at most forty of
/// them, evenly chosen.
/// \param constants  the model without covariates
/// \param pooled     (p) coefficients of the fit to all groups together
/// \returns no value if fewer than three groups have a fit
std::optional<Eigen::VectorXd> medians_of_group_fits(const NonlinearModel& model,
                                                     const NonlinearModel& constants,
                                                     const Eigen::VectorXd& pooled);

}  // namespace silvafit::fit
