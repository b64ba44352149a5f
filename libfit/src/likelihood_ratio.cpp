// SPDX-License-Identifier: MIT
#include "silvafit/fit/likelihood_ratio.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

bool is_usable(const FittedModel& fit) {
  return fit.convergence.converged && std::isfinite(fit.log_likelihood);
}

bool has_same_fixed_effects(const FittedModel& a, const FittedModel& b) {
  return a.specification.formula.right.text() == b.specification.formula.right.text() &&
         a.coefficient_names == b.coefficient_names;
}

/// Why the likelihoods of two fits cannot be compared; empty if they can.
std::string obstacle(const FittedModel& a, const FittedModel& b) {
  if (a.observations != b.observations) {
    return fmt::format("the fits are to {} and {} observations", a.observations, b.observations);
  }
  if (a.specification.formula.left != b.specification.formula.left) {
    return fmt::format(
        "the responses are {} and {}", a.specification.formula.left, b.specification.formula.left);
  }
  const bool is_known = !a.response_fingerprint.empty() && !b.response_fingerprint.empty();
  if (is_known && a.response_fingerprint != b.response_fingerprint) {
    return "the fits are to different observations of the response";
  }
  // Without random effects all methods have one likelihood.
  const bool is_one_method = a.method == b.method && a.quadrature_points == b.quadrature_points;
  if (is_mixed(a.method) && is_mixed(b.method) && !is_one_method) {
    return a.method == b.method
               ? std::string("the likelihoods have different numbers of quadrature points")
               : fmt::format("the likelihoods of {} and {} are different approximations",
                             method_text(a.method),
                             method_text(b.method));
  }
  if (a.reml != b.reml) {
    return "one likelihood is restricted and the other is not";
  }
  if (a.reml && !has_same_fixed_effects(a, b)) {
    return "restricted likelihoods of different fixed effects are of different contrasts of the "
           "data; fit both by maximum likelihood";
  }
  return {};
}

/// What a likelihood ratio is compared with.
ChiBarSquared reference_of(const Nesting& nesting,
                           int freedom,
                           const std::optional<Eigen::MatrixXd>& variances,
                           std::string& note) {
  if (nesting.correlated_effects == 0 && nesting.independent_effects == 0) {
    if (nesting.has_other_edge) {
      note =
          "a parameter of the variance function is at the end of its range in the smaller "
          "model: the p-value is too large";
    }
    return {.base = freedom};
  }
  const int edges = nesting.correlated_effects + nesting.independent_effects;
  if (nesting.correlated_effects == 0) {
    const bool is_known = variances.has_value() && variances->rows() == edges;
    ChiBarSquared result =
        is_known ? correlated_variances(*variances) : independent_variances(edges);
    result.base = freedom - edges;
    if (edges > 1 && !is_known) note = "weights as if the estimated variances were independent";
    return result;
  }
  if (edges == 1) {
    // q correlated effects become q + 1: Stram and Lee's case.
    return {.base = freedom - 1, .weights = {0.5, 0.5}};
  }
  // Several at once, correlated: the weights of the cone of covariance matrices have no simple
  // form. Half and half of the two largest is an upper bound of the p-value, and below
  // chi-squared's.
  note = "several correlated effects at once: the p-value is an upper bound";
  return {.base = freedom - 1, .weights = {0.5, 0.5}};
}

void add_weights(Comparison& comparison) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const ComparedFit& one : comparison.fits) smallest = std::min(smallest, one.fit->aic());
  double sum = 0.0;
  for (ComparedFit& one : comparison.fits) {
    const bool is_comparable = comparison.reason.empty();
    one.aic_difference = is_comparable ? one.fit->aic() - smallest : kNaN;
    one.akaike_weight = std::exp(-0.5 * one.aic_difference);
    sum += one.akaike_weight;
  }
  for (ComparedFit& one : comparison.fits) one.akaike_weight /= sum;
}

ComparedPair compared_pair(const Comparison& comparison, std::size_t larger) {
  ComparedPair pair{.larger = larger, .smaller = larger - 1};
  try {
    pair.test =
        likelihood_ratio_test(*comparison.fits[larger].fit, *comparison.fits[larger - 1].fit);
  } catch (const UsageError& error) {
    pair.reason = error.message();
  }
  return pair;
}

}  // namespace

NestedTest likelihood_ratio_test(const FittedModel& larger,
                                 const FittedModel& smaller,
                                 const std::optional<Eigen::MatrixXd>& variances) {
  for (const FittedModel* const fit : {&larger, &smaller}) {
    if (!is_usable(*fit)) {
      throw UsageError("a fit that has not converged has no likelihood to test with");
    }
  }
  if (const std::string reason = obstacle(larger, smaller); !reason.empty()) {
    throw UsageError(reason);
  }
  const Nesting how = nesting(larger, smaller);
  if (!how.is_nested) throw UsageError("not nested: " + how.reason);
  NestedTest test{.statistic = 2.0 * (larger.log_likelihood - smaller.log_likelihood),
                  .degrees_of_freedom = larger.parameter_count - smaller.parameter_count};
  if (test.degrees_of_freedom <= 0) {
    throw UsageError("the models have as many parameters, so that there is nothing to test");
  }
  test.p_chi_squared = ChiBarSquared{.base = test.degrees_of_freedom}.upper_tail(test.statistic);
  test.reference = reference_of(how, test.degrees_of_freedom, variances, test.note);
  test.p = test.reference.upper_tail(test.statistic);
  return test;
}

Comparison compare(const std::vector<const FittedModel*>& fits) {
  if (fits.size() < 2) throw UsageError("a comparison needs two fits at least");
  Comparison comparison;
  for (const FittedModel* const fit : fits) {
    if (is_usable(*fit)) {
      comparison.fits.push_back({.fit = fit});
    } else {
      comparison.failed.push_back(fit);
    }
  }
  std::ranges::stable_sort(
      comparison.fits, {}, [](const ComparedFit& one) { return one.fit->parameter_count; });
  for (std::size_t i = 1; i < comparison.fits.size() && comparison.reason.empty(); ++i) {
    comparison.reason = obstacle(*comparison.fits[0].fit, *comparison.fits[i].fit);
  }
  add_weights(comparison);
  for (std::size_t i = 1; i < comparison.fits.size(); ++i) {
    comparison.pairs.push_back(compared_pair(comparison, i));
  }
  return comparison;
}

}  // namespace silvafit::fit
