// SPDX-License-Identifier: MIT
// The evidence of a fit: did it converge, and why we think so.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::fit {

/// How a fit ended. The first four have estimates that can be used.
enum class ConvergenceStatus {
  kConverged,             ///< "converged"
  kBoundary,              ///< "boundary": singular fit, or coefficients at their given bounds
  kPerfectFit,            ///< "perfect_fit": least squares without residuals
  kPublished,             ///< "published": a model from a publication, not fitted here
  kNotIdentifiable,       ///< "not_identifiable": several estimates have the same likelihood
  kNoMaximum,             ///< "no_maximum": the likelihood increases without end
  kContainedModelHigher,  ///< "contained_model_higher": a simpler model is more likely
  kInvalidApproximation,  ///< "invalid_approximation": of the likelihood, by the method
  kDiverged,              ///< "diverged": the search ran away
  kIterationLimit,        ///< "iteration_limit"
  kMaximumNotReached,     ///< "maximum_not_reached": the search ended elsewhere
  kNoStartValues,         ///< "no_start_values": none at which the model is finite
  kTooFewObservations,    ///< "too_few_observations"
  kOutsideBounds,         ///< "outside_bounds": no fit was found within the given bounds
  kUnknown,               ///< "unknown": in files of earlier versions
};
std::string_view status_text(ConvergenceStatus status);
/// kUnknown for other texts, which may be of later versions.
ConvergenceStatus parse_status(std::string_view text);

/// One finding about a fit.
struct Evidence {
  enum class Kind {
    kBoundary,            ///< "boundary": a parameter at the end of its range, and its value
    kLowerBound,          ///< "lower_bound": a coefficient at its given bound
    kUpperBound,          ///< "upper_bound": the same
    kNotIdentifiable,     ///< "not_identifiable": a parameter
    kHardlyIdentifiable,  ///< "hardly_identifiable": a parameter
    kUnbounded,           ///< "unbounded": a parameter that grows without bound
    kMoving,              ///< "moving": the parameter that is furthest from its optimum
    kContainedModel,      ///< "contained_model": its text and log-likelihood
    kMarginal,            ///< "marginal_log_likelihood": method, and value at the estimates
    kMarginalMaximum,     ///< "marginal_maximum": method, and value at its maximum
    kHigherEnd,           ///< "higher_end": log-likelihood of a search that has not converged
    kOtherOptimum,        ///< "other_optimum": origin of the search and log-likelihood
    kFlooredValues,       ///< "floored_values": fitted values too near zero for a power variance
    kPowerOfFew,          ///< "power_of_few": the observations for which a power matters
  };
  Kind kind = Kind::kBoundary;
  std::string term{};  ///< "sd(a)", "cor(a, b)", "laplace"
  double value = std::numeric_limits<double>::quiet_NaN();
};
std::string_view kind_text(Evidence::Kind kind);
/// Nothing for other texts, which may be of later versions.
std::optional<Evidence::Kind> parse_kind(std::string_view text);
/// "sd(b) = 0"; "a = 60, its upper bound"; the term alone where there is no value.
std::string text_of(const Evidence& evidence);

/// What an optimization knows about the point where it stopped.
struct Convergence {
  ConvergenceStatus status = ConvergenceStatus::kUnknown;
  /// One sentence for people: what was reached, or what went wrong and what to try.
  std::string verdict{};
  /// Newton decrement g' H^-1 g: the squared distance to the optimum in standard errors.
  double newton_decrement = 0.0;
  int iterations = 0;
  /// Number of coefficients that the data determine; less than their number means confounding.
  int rank = 0;
  std::vector<Evidence> evidence{};

  /// Whether the estimates are those of a maximum.
  bool converged() const;
  /// What lies on the boundary of its range, e.g. "sd(b) = 0" or "a = 60, its upper bound".
  std::vector<std::string> boundary() const;
  bool has_boundary() const;
  /// The status and its terms in few words, the same for all fits that ended alike.
  std::string summary() const;
  bool has(Evidence::Kind kind, std::string_view term) const;
  void add(Evidence::Kind kind, const std::vector<std::string>& terms);
  /// Adds that one of the parameters is on the boundary of its range; a converged fit is then a
  /// boundary fit.
  void add_boundary(Evidence evidence);
};

}  // namespace silvafit::fit
