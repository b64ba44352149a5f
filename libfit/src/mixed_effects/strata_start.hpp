// SPDX-License-Identifier: MIT
// Coefficients of a typical group, for groups so different that one curve through all is no start.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Whether a fit to all groups together is a doubtful start of a mixed model: the model is not
/// linear, and a coefficient without a covariate is less than two standard errors from zero, as
/// where curves of very different height make the fit run away.
/// \param pooled  (p) the coefficients of that fit
bool is_doubtful_start(const NonlinearModel& model, const Eigen::VectorXd& pooled);

/// The medians of least-squares fits to strata of groups that lie alike above or below the pooled
/// fit; nothing if there are too few observations for strata, or if most of them have no fit.
/// \param pooled  (p) the coefficients of that fit
std::optional<Eigen::VectorXd> start_of_strata(const NonlinearModel& model,
                                               const Eigen::VectorXd& pooled);

}  // namespace silvafit::fit
