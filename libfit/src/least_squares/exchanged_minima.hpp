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
/// changing a fit without random effects. With random effects on one of them the fits differ.
/// Tried are exchanges of up to four pairs, of two pairs of nine or ten coefficients, and of one
/// pair with a change of sign, or of the share f of f*A + (1 - f)*B to 1 - f.
/// \param minimum  (p) coefficients of a fit; none are found for more than ten
std::vector<Eigen::VectorXd> exchanged_minima(const NonlinearModel& model,
                                              const Eigen::VectorXd& minimum);

/// The same for locations on the axis of a column: two of them are exchanged, and a descent adapts
/// the other coefficients.
std::vector<Eigen::VectorXd> exchanged_locations(const NonlinearModel& model,
                                                 const Eigen::VectorXd& minimum);

}  // namespace silvafit::fit
