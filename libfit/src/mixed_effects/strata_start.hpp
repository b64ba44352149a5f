// SPDX-License-Identifier: MIT
// Coefficients of a typical group, for groups so different that the pooled fit is not a start.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Whether the pooled fit is a doubtful start of a mixed model: the model is not linear, and a
/// coefficient without a covariate is less than two standard errors from zero. This happens if
/// curves of very different heights make the pooled fit diverge.
/// \param pooled  (p) the coefficients of that fit
bool is_doubtful_start(const NonlinearModel& model, const Eigen::VectorXd& pooled);

/// The medians of least-squares fits to strata of groups with similar residuals from the pooled
/// fit; no value if there are too few observations for strata, or if most of them have no fit.
/// \param pooled  (p) the coefficients of that fit
std::optional<Eigen::VectorXd> start_of_strata(const NonlinearModel& model,
                                               const Eigen::VectorXd& pooled);

}  // namespace silvafit::fit
