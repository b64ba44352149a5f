// SPDX-License-Identifier: MIT
// How the estimates of variances that are zero vary together.
#pragma once

#include <Eigen/Core>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// Asymptotic covariance, where they are zero, of the variances of random effects that `larger` has
/// more than `smaller`, from the expected information of the model linear around the estimates of
/// `smaller`; that on the variances that both have and on sigma is taken account of.
/// \param table  the rows that both were fitted to; one grouping
/// \throws UsageError if the larger model has no more random effects, or there are two groupings
/// \throws NumericalError if the mean does not depend on an effect there, or the observations do
/// not
///   tell the variances apart
Eigen::MatrixXd covariance_of_variances(const FittedModel& larger,
                                        const FittedModel& smaller,
                                        const data::Table& table);

}  // namespace silvafit::fit
