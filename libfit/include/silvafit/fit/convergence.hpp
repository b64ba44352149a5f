// SPDX-License-Identifier: MIT
// Convergence of a fit: status, message and evidence.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/enum_words.hpp"
#include "silvafit/fit/finding.hpp"

namespace silvafit::fit {

/// The status of a fit. The first four have usable estimates.
enum class ConvergenceStatus {
  kConverged,             ///< "converged"
  kBoundary,              ///< "boundary": singular fit, or coefficients at their given bounds
  kPerfectFit,            ///< "perfect_fit": least squares without residuals
  kPublished,             ///< "published": a model from a publication, not fitted here
  kNotIdentifiable,       ///< "not_identifiable": several estimates have the same likelihood
  kNoMaximum,             ///< "no_maximum": the likelihood increases without bound
  kContainedModelHigher,  ///< "contained_model_higher": a nested model has a higher likelihood
  kInvalidApproximation,  ///< "invalid_approximation": of the likelihood, by the method
  kDiverged,              ///< "diverged": the search diverged
  kIterationLimit,        ///< "iteration_limit"
  kMaximumNotReached,     ///< "maximum_not_reached": the search ended elsewhere
  kNoStartValues,         ///< "no_start_values": none at which the model is finite
  kTooFewObservations,    ///< "too_few_observations"
  kOutsideBounds,         ///< "outside_bounds": no fit was found within the given bounds
  kUnknown,               ///< "unknown": in files of earlier versions
};
constexpr std::array<std::string_view, 15> words_of(ConvergenceStatus /*status*/) {
  return {"converged",
          "boundary",
          "perfect_fit",
          "published",
          "not_identifiable",
          "no_maximum",
          "contained_model_higher",
          "invalid_approximation",
          "diverged",
          "iteration_limit",
          "maximum_not_reached",
          "no_start_values",
          "too_few_observations",
          "outside_bounds",
          "unknown"};
}

/// One finding about a fit.
struct Evidence {
  enum class Kind {
    kBoundary,            ///< "boundary": a parameter at a bound, and its value
    kLowerBound,          ///< "lower_bound": a coefficient at its given bound
    kUpperBound,          ///< "upper_bound": the same
    kNotIdentifiable,     ///< "not_identifiable": a parameter
    kHardlyIdentifiable,  ///< "hardly_identifiable": a parameter
    kUnbounded,           ///< "unbounded": a parameter that grows without bound
    kMoving,              ///< "moving": the parameter that is farthest from its optimum
    kContainedModel,      ///< "contained_model": its text and log-likelihood
    kMarginal,            ///< "marginal_log_likelihood": method, and value at the estimates
    kMarginalMaximum,     ///< "marginal_maximum": method, and value at its maximum
    kHigherEnd,           ///< "higher_end": log-likelihood of a search that has not converged
    kOtherOptimum,        ///< "other_optimum": origin of the search and log-likelihood
    kFlooredValues,       ///< "floored_values": fitted values too near zero for a power variance
    kPowerOfFew,          ///< "power_of_few": the observations for which a power is relevant
    kTakenAsParameter,    ///< "taken_as_parameter": a name that may be a misspelt column
    kResponseValues,      ///< "response_values": a response with the values of another distribution
    kMissingCode,         ///< "missing_code": column that may have a code of missing values
    kKink,                ///< "kink": a coefficient at a kink of the likelihood
  };
  Kind kind = Kind::kBoundary;
  std::string term{};  ///< "sd(a)", "cor(a, b)", "laplace"
  double value = kNaN;
};
constexpr std::array<std::string_view, 18> words_of(Evidence::Kind /*kind*/) {
  return {"boundary",
          "lower_bound",
          "upper_bound",
          "not_identifiable",
          "hardly_identifiable",
          "unbounded",
          "moving",
          "contained_model",
          "marginal_log_likelihood",
          "marginal_maximum",
          "higher_end",
          "other_optimum",
          "floored_values",
          "power_of_few",
          "taken_as_parameter",
          "response_values",
          "missing_code",
          "kink"};
}
/// "sd(b) = 0"; "a = 60, its upper bound"; only the term if there is no value.
std::string text_of(const Evidence& evidence);

/// The findings of an optimization at its end.
struct Convergence {
  ConvergenceStatus status = ConvergenceStatus::kUnknown;
  /// What the convergence message says.
  std::vector<Finding> findings{};
  /// Newton decrement g' H^-1 g: the squared distance to the optimum in standard errors.
  double newton_decrement = 0.0;
  int iterations = 0;
  /// Number of identifiable coefficients; the others are confounded.
  int rank = 0;
  std::vector<Evidence> evidence{};

  /// The convergence message: the result, or the problem with the remedy.
  std::string verdict() const { return verdict_of(findings); }
  void find(Finding finding) { findings.push_back(std::move(finding)); }
  /// Sets the status and its reason, in place of all earlier findings.
  /// \param named  kind of the evidence that the reason's names are, if they are
  void conclude(ConvergenceStatus found,
                Finding reason,
                std::optional<Evidence::Kind> named = std::nullopt);
  /// Whether the estimates are those of a maximum.
  bool converged() const;
  /// The parameters at bounds, e.g. "sd(b) = 0" or "a = 60, its upper bound".
  std::vector<std::string> boundary() const;
  bool has_boundary() const;
  /// The status and its terms in a few words, the same for all fits with equal results.
  std::string summary() const;
  bool has(Evidence::Kind kind, std::string_view term) const;
  void add(Evidence::Kind kind, const std::vector<std::string>& terms);
  /// Whether the message begins with a doubt about names or values.
  bool has_doubts() const;
  /// Finds that the optimum is at a kink if the evidence has coefficients at one.
  void find_kinks();
  /// Records a parameter at a bound; a converged fit is then a boundary fit.
  void add_boundary(Evidence evidence);
};

}  // namespace silvafit::fit
