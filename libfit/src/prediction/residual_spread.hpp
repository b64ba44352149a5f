// SPDX-License-Identifier: MIT
// The residual standard deviation of rows that may lack what the variance function reads.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// (N) as FittedModel::residual_sd(), but NaN everywhere if a column that the variance function
/// reads is not there: predictions themselves do not need it.
/// \param fitted  (N) predictions of the table's rows
Eigen::VectorXd residual_sd_if_known(const FittedModel& fit,
                                     const Eigen::Ref<const Eigen::VectorXd>& fitted,
                                     const data::Table& table);

/// Whether the residual standard deviation changes with the fitted value.
bool residual_follows_mean(const FittedModel& fit);

/// (N) what a row lacks: "missing noise" without a value, "unknown species" in a stratum that the
/// fit has not seen; empty where the residual standard deviation is known.
std::vector<std::string> residual_sd_gaps(const FittedModel& fit, const data::Table& table);

}  // namespace silvafit::fit
