// SPDX-License-Identifier: MIT
// The estimates of the terms of random effects of a model.
#pragma once

#include <vector>

#include "silvafit/fit/estimates.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// (q x groups) the effects of each term.
std::vector<Eigen::MatrixXd> effects_of(const Estimates& estimates);
/// (q x q) the covariance Psi of each term.
std::vector<Eigen::MatrixXd> covariances_of(const Estimates& estimates);

/// Sets names and labels of a model's terms. Values are unchanged.
void name_terms(const NonlinearModel& model, Estimates& estimates);

}  // namespace silvafit::fit
