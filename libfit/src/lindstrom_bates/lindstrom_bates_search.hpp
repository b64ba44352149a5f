// SPDX-License-Identifier: MIT
// Which of several runs of the Lindstrom-Bates alternation is the fit.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "lindstrom_bates/lindstrom_bates.hpp"

namespace silvafit::fit {

/// How long a search goes on where a run from the coefficients that it starts from fails.
enum class Persistence {
  kOnce,        ///< it gives up
  kUntilFound,  ///< until a start of the variance components leads to a fit, or all have failed
};

/// The best of runs from several starts. With a variance function, the fits with the simpler ones
/// that it contains are starts, and it must not end below them; otherwise, and if none of these
/// converges, starts that know nothing of the variance components are tried until one converges.
struct LindstromBatesSearch {
  std::unique_ptr<LindstromBates> engine{};
  LindstromBatesOutcome outcome{};
};
LindstromBatesSearch climb_lindstrom_bates(const NonlinearModel& model,
                                           const Eigen::VectorXd& start,
                                           const MixedEffectsOptions& options,
                                           Persistence persistence,
                                           double spread = 1.0);

/// The same, from a typical group as well where the start does not lead to a fit, or is doubtful.
LindstromBatesSearch search_lindstrom_bates(const NonlinearModel& model,
                                            const Eigen::VectorXd& start,
                                            const MixedEffectsOptions& options);

/// One run of the alternation from an earlier fit of the same model, perhaps to other data.
/// \returns a fit that is neither described nor judged; nothing if no finite point was reached
std::optional<MixedEffectsFit> lindstrom_bates_from(const NonlinearModel& model,
                                                    const MixedEffectsFit& start,
                                                    const MixedEffectsOptions& options);

/// The same, described and judged.
/// \returns nothing if it does not converge
std::optional<MixedEffectsFit> refit_lindstrom_bates(const NonlinearModel& model,
                                                     const MixedEffectsFit& start,
                                                     const MixedEffectsOptions& options);

/// Why penalized least squares found no first step.
Convergence why_no_step(const NonlinearModel& model, const Eigen::VectorXd& start);

}  // namespace silvafit::fit
