// SPDX-License-Identifier: MIT
#include "silvafit/fit/likelihood_ratio.hpp"

#include <cmath>

#include "inference/comparable_likelihoods.hpp"
#include "optimization/tolerances.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/nesting.hpp"

namespace silvafit::fit {
namespace {

/// Whether the fit is perfect: then its gain cannot be due to chance.
bool is_exact(const FittedModel& fit) {
  return fit.convergence.converged() && std::isinf(fit.log_likelihood) && fit.log_likelihood > 0.0;
}

void add(std::string& note, const std::string& text) {
  if (!note.empty()) note += "; ";
  note += text;
}

/// Limits of the p-value that do not depend on the random effects.
std::string general_note(const Nesting& nesting) {
  std::string note;
  if (nesting.has_other_edge) {
    add(note,
        "a parameter of the variance function or of the residuals' correlation is at a boundary in "
        "the smaller model: the p-value is too large");
  }
  if (nesting.has_bounded) {
    add(note,
        "a coefficient is at its bound in the smaller model: the p-value treats it as fixed there");
  }
  return note;
}

/// The reference distribution of a likelihood ratio.
ChiBarSquared reference_of(const Nesting& nesting, int freedom, std::string& note) {
  note = general_note(nesting);
  const int edges = nesting.correlated_effects + nesting.independent_effects;
  if (edges == 0) return {.base = freedom};
  if (nesting.correlated_effects == 0) {
    ChiBarSquared result = independent_variances(edges);
    result.base = freedom - edges;
    if (edges > 1) add(note, "the weights assume independent variance estimates");
    return result;
  }
  if (edges == 1) {
    // q correlated effects become q + 1: the case of Stram and Lee.
    return {.base = freedom - 1, .weights = {0.5, 0.5}};
  }
  // Several correlated effects at once: the weights of the cone of covariance matrices have no
  // simple form. The 50:50 mixture of the two largest gives an upper bound of the p-value that is
  // below that of chi-squared.
  add(note, "several correlated random effects are tested at once: the p-value is an upper bound");
  return {.base = freedom - 1, .weights = {0.5, 0.5}};
}

/// Likelihoods that are equal except for rounding have a ratio of 0. For a 50:50 mixture a small
/// positive value would give p = 0.5, and 0 gives p = 1.
double statistic_of(double larger, double smaller) {
  const double statistic = 2.0 * (larger - smaller);
  return std::abs(statistic) <= 2.0 * kRoundedLikelihood ? 0.0 : statistic;
}

/// Whether a model is less likely than one that it contains, by more than the tolerance of
/// searches.
bool ends_below(double statistic) {
  constexpr double kSearches = 1e-4;
  return statistic < -kSearches;
}

}  // namespace

NestedTest likelihood_ratio_test(const FittedModel& larger, const FittedModel& smaller) {
  if (!has_usable_likelihood(smaller) || !(has_usable_likelihood(larger) || is_exact(larger))) {
    throw UsageError("a fit has not converged");
  }
  if (const std::string reason = obstacle_to_comparing(larger, smaller); !reason.empty()) {
    throw UsageError(reason);
  }
  const Nesting how = nesting(larger, smaller);
  if (!how.is_nested) throw UsageError("not nested: " + how.reason);
  NestedTest test{
      .statistic = statistic_of(larger.log_likelihood, smaller.log_likelihood),
      .degrees_of_freedom = count_without_bounded(larger) - count_without_bounded(smaller)};
  if (test.degrees_of_freedom <= 0) {
    throw UsageError("the models have the same number of parameters");
  }
  test.p_chi_squared = ChiBarSquared{.base = test.degrees_of_freedom}.upper_tail(test.statistic);
  test.reference = reference_of(how, test.degrees_of_freedom, test.note);
  test.p = test.reference.upper_tail(test.statistic);
  if (ends_below(test.statistic)) {
    add(test.note,
        "the larger model has a lower log-likelihood than the smaller one, which it contains: its "
        "fit ended at a lower maximum, or the approximations of the method differ");
  }
  return test;
}

}  // namespace silvafit::fit
