// SPDX-License-Identifier: MIT
// The residual standard deviation of rows that may lack columns of the variance function.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// (N) as FittedModel::residual_sd(), but NaN everywhere if a column of the variance function is
/// missing, because predictions themselves do not need it.
/// \param fitted  (N) predictions of the table's rows
VectorXd residual_sd_if_known(const FittedModel& fit,
                              const Eigen::Ref<const VectorXd>& fitted,
                              const data::Table& table);

/// Whether the residual standard deviation changes with the fitted value.
bool residual_follows_mean(const FittedModel& fit);

/// (N) the reason for a missing residual standard deviation: "missing noise" without a value,
/// "unknown species" in a stratum that is not in the fit; else empty.
std::vector<std::string> residual_sd_gaps(const FittedModel& fit, const data::Table& table);

}  // namespace silvafit::fit
