// SPDX-License-Identifier: MIT
// Covariance of the estimates of variances that are zero.
#pragma once

#include <Eigen/Core>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// Asymptotic covariance, at zero, of the variances of the additional random effects of `larger`
/// compared with `smaller`, from the expected information of the model linear around the estimates
/// of `smaller`, adjusted for the common variances and sigma.
/// \param table  the rows of both fits; one grouping
/// \throws UsageError if the larger model has no more random effects, or there are two groupings
/// \throws NumericalError if the mean does not depend on an effect there, or the variances are not
///   identifiable
Eigen::MatrixXd covariance_of_variances(const FittedModel& larger,
                                        const FittedModel& smaller,
                                        const data::Table& table);

}  // namespace silvafit::fit
