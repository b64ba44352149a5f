// SPDX-License-Identifier: MIT
// Which of several runs of the Lindstrom-Bates alternation is the fit.
#pragma once

#include "lindstrom_bates.hpp"

namespace silvafit::fit {

/// The best of runs from several starts. Without a variance function, all starts are tried until
/// one converges; with one, the fit with constant variance, which it contains, is a start as well.
LindstromBatesOutcome search_lindstrom_bates(const NonlinearModel& model,
                                             const Eigen::VectorXd& start,
                                             LindstromBates& engine,
                                             int maximum_iterations);

/// Why penalised least squares found no first step.
std::string why_no_step(const NonlinearModel& model, const Eigen::VectorXd& start);

}  // namespace silvafit::fit
