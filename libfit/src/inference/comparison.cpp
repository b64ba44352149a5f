// SPDX-License-Identifier: MIT
#include "silvafit/fit/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "inference/comparable_likelihoods.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

/// The number of parameters of a published model may be unknown.
bool has_known_size(const FittedModel& fit) { return fit.parameter_count > 0; }

void add_weights(Comparison& comparison) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const ComparedFit& one : comparison.fits) smallest = std::min(smallest, one.fit->aic());
  double sum = 0.0;
  for (ComparedFit& one : comparison.fits) {
    const bool is_comparable = comparison.reason.empty();
    one.aic_difference = is_comparable ? one.fit->aic() - smallest : kNaN;
    one.akaike_weight = std::exp(-0.5 * one.aic_difference);
    if (has_known_size(*one.fit)) sum += one.akaike_weight;
  }
  for (ComparedFit& one : comparison.fits) one.akaike_weight /= sum;
}

ComparedPair compared_pair(const Comparison& comparison, std::size_t larger) {
  ComparedPair pair{.larger = larger, .smaller = larger - 1};
  const FittedModel& more = *comparison.fits[larger].fit;
  const FittedModel& fewer = *comparison.fits[larger - 1].fit;
  if (!has_known_size(more) || !has_known_size(fewer)) {
    pair.reason = "the number of estimated parameters is unknown";
    return pair;
  }
  try {
    pair.test = likelihood_ratio_test(more, fewer);
  } catch (const UsageError& error) {
    pair.reason = error.message();
  }
  return pair;
}

}  // namespace

Comparison compare(const std::vector<const FittedModel*>& fits) {
  if (fits.size() < 2) throw UsageError("a comparison needs at least two fits");
  Comparison comparison;
  for (const FittedModel* const fit : fits) {
    if (has_usable_likelihood(*fit)) {
      comparison.fits.push_back({.fit = fit});
    } else {
      comparison.failed.push_back(fit);
    }
  }
  std::ranges::stable_sort(comparison.fits, {}, [](const ComparedFit& one) {
    return has_known_size(*one.fit) ? count_without_bounded(*one.fit)
                                    : std::numeric_limits<int>::max();
  });
  for (std::size_t i = 1; i < comparison.fits.size() && comparison.reason.empty(); ++i) {
    comparison.reason = obstacle_to_comparing(*comparison.fits[0].fit, *comparison.fits[i].fit);
  }
  add_weights(comparison);
  for (std::size_t i = 1; i < comparison.fits.size(); ++i) {
    comparison.pairs.push_back(compared_pair(comparison, i));
  }
  return comparison;
}

}  // namespace silvafit::fit
