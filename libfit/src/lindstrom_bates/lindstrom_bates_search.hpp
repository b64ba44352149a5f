// SPDX-License-Identifier: MIT
// Which of several runs of the Lindstrom-Bates alternation is the fit.
#pragma once

#include <memory>
#include <string>

#include "lindstrom_bates/lindstrom_bates.hpp"

namespace silvafit::fit {

/// The best of runs from several starts. With a variance function, the fits with the simpler ones
/// that it contains are starts, and it must not end below them; otherwise, and if none of these
/// converges, starts that know nothing of the variance components are tried until one converges.
struct LindstromBatesSearch {
  std::unique_ptr<LindstromBates> engine{};
  LindstromBatesOutcome outcome{};
};
LindstromBatesSearch search_lindstrom_bates(const NonlinearModel& model,
                                            const Eigen::VectorXd& start,
                                            const MixedEffectsOptions& options);

/// Why penalized least squares found no first step.
std::string why_no_step(const NonlinearModel& model, const Eigen::VectorXd& start);

}  // namespace silvafit::fit
