// SPDX-License-Identifier: MIT
// Minima at which terms of the formula are exchanged.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Other coefficients with the same mean, found by exchanging coefficients.
///
/// The two terms of a biexponential, the rates of absorption and elimination, and the two
/// asymptotes of a logistic curve (with the sign of its slope changed) can be exchanged without
/// changing a fit without random effects. With random effects on one of them the fits differ. Up to
/// four pairs are exchanged at once, two of more than eight coefficients, none of more than ten;
/// and one pair with a change of sign. \param minimum  (p) coefficients of a fit
std::vector<Eigen::VectorXd> exchanged_minima(const NonlinearModel& model,
                                              const Eigen::VectorXd& minimum);

/// The same for locations on the axis of a column: two of them are exchanged, and a descent adapts
/// the other coefficients, as the share f of f*A + (1 - f)*B becomes 1 - f.
std::vector<Eigen::VectorXd> exchanged_locations(const NonlinearModel& model,
                                                 const Eigen::VectorXd& minimum);

}  // namespace silvafit::fit
