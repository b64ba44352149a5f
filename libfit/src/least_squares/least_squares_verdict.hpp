// SPDX-License-Identifier: MIT
// The convergence status and findings of a least-squares fit from its evidence.
#pragma once

#include <string>
#include <vector>

#include "least_squares/least_squares_polish.hpp"
#include "silvafit/fit/convergence.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Whether a sum of squares can be due to rounding alone.
bool is_exact(const NonlinearModel& model, double sum_of_squares);

/// Whether the coefficients are identifiable at some point, so that a lack of it is local.
bool is_identifiable(const NonlinearModel& model);

/// What is said of coefficients that are not identifiable: the mean does not depend on them, or it
/// changes with them by steps only.
Finding confounding(const NonlinearModel& model, const std::vector<Eigen::Index>& coefficients);

std::vector<std::string> names_of(const NonlinearModel& model,
                                  const std::vector<Index>& coefficients);

/// Coefficients with standard errors of more than ten times their size, although the curve needs
/// them: it changes by more than a residual standard deviation without them. (A coefficient that
/// it does not need, such as that of a covariate without effect, is near zero.)
/// \param residual_sd  (N) of each observation
std::vector<Index> undetermined(const NonlinearModel& model,
                                const VectorXd& coefficients,
                                const VectorXd& standard_errors,
                                const VectorXd& residual_sd);

/// \param exact  the residuals are zero except for rounding
Convergence judge(const NonlinearModel& model, const NewtonPoint& point, bool exact);

/// Of fits that could not start.
Convergence too_few_observations(const NonlinearModel& model);
Convergence no_start();

}  // namespace silvafit::fit
