// SPDX-License-Identifier: MIT
// Selection of the fit from several runs of the Lindstrom-Bates alternation.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lindstrom_bates/lindstrom_bates.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {

/// The extent of a search after a failed run from its starting coefficients.
enum class Persistence {
  kOnce,        ///< no further runs
  kUntilFound,  ///< until a start of the variance components leads to a fit, or all have failed
};

/// The best of runs from several starts. With a variance function, the fit with constant variance
/// is a start, and the result must not be below it. Otherwise, and if it does not converge, starts
/// with default variance components are tried.
struct LindstromBatesSearch {
  std::unique_ptr<LindstromBates> engine{};
  LindstromBatesOutcome outcome{};
  LindstromBatesWork work{};  ///< of all runs
  /// The highest log-likelihood with a correlation whose range grows without bound, if one ended
  /// so.
  double unbounded = -kInfinity;
};
LindstromBatesSearch climb_lindstrom_bates(const NonlinearModel& model,
                                           const VectorXd& start,
                                           const MixedEffectsOptions& options,
                                           Persistence persistence,
                                           double spread = 1.0);

/// The same, also from a typical group if the start does not lead to a fit, or is doubtful.
LindstromBatesSearch search_lindstrom_bates(const NonlinearModel& model,
                                            const VectorXd& start,
                                            const MixedEffectsOptions& options);

/// The end of one run.
struct LindstromBatesEnd {
  /// Without standard errors and message; no value if no finite point was reached.
  std::optional<MixedEffectsFit> fit{};
  LindstromBatesWork work{};
};

/// One run of the alternation from an earlier fit of the same model to the same or other data.
LindstromBatesEnd lindstrom_bates_from(const NonlinearModel& model,
                                       const MixedEffectsFit& start,
                                       const MixedEffectsOptions& options);

/// Ends with a higher likelihood than a fit, of runs from other variance components at its
/// coefficients: also the likelihood of a linear model may have several maxima. Without standard
/// errors and message.
std::vector<MixedEffectsFit> higher_maxima(const NonlinearModel& model,
                                           const MixedEffectsFit& fit,
                                           const MixedEffectsOptions& options);

/// One run from an earlier fit, with standard errors and convergence message.
/// \returns no value if it does not converge
std::optional<MixedEffectsFit> refit_lindstrom_bates(const NonlinearModel& model,
                                                     const MixedEffectsFit& start,
                                                     const MixedEffectsOptions& options);

}  // namespace silvafit::fit
