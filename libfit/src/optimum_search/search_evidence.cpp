// SPDX-License-Identifier: MIT
#include "optimum_search/search_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "optimization/tolerances.hpp"
#include "verdict/reducible.hpp"
#include "verdict/thresholds.hpp"

namespace silvafit::fit {

namespace {

/// The likelihood by which optima are compared.
double rank_of(const LocalOptimum& optimum) {
  return std::isfinite(optimum.marginal_log_likelihood) ? optimum.marginal_log_likelihood
                                                        : optimum.log_likelihood;
}

/// The note on another optimum with a similar likelihood.
const LocalOptimum* close_optimum(const MixedEffectsFit& fit) {
  const auto found =
      std::find_if(fit.optima.begin() + 1, fit.optima.end(), [&](const LocalOptimum& optimum) {
        return rank_of(optimum) > rank_of(fit.optima.front()) - kDoubtful;
      });
  return found == fit.optima.end() ? nullptr : &*found;
}

/// The best optimum, if the user's wishes exclude it; else null.
const LocalOptimum* higher_optimum(const MixedEffectsFit& fit) {
  const auto highest = std::ranges::max_element(fit.optima, {}, rank_of);
  return rank_of(*highest) > rank_of(fit.optima.front()) + kHigher ? &*highest : nullptr;
}

/// Difference of the linearized likelihood from the marginal one, at the estimates and at its
/// maximum; for restricted likelihood, that of the marginal one at the estimates from its maximum.
double linearization_error(const MixedEffectsFit& fit, const SearchEvidence& evidence) {
  if (evidence.is_restricted) {
    const double below = evidence.marginal_maximum - evidence.marginal_here;
    return std::isfinite(below) ? below : 0.0;
  }
  double error = 0.0;
  for (const double marginal : {evidence.marginal_here, evidence.marginal_maximum}) {
    if (std::isfinite(marginal)) error = std::max(error, std::abs(marginal - fit.log_likelihood));
  }
  return error;
}

/// \param values  likelihoods of the sentence, before the estimates
void find_optimum(Finding::Kind kind,
                  const LocalOptimum& optimum,
                  std::vector<double> values,
                  MixedEffectsFit& fit) {
  fit.convergence.evidence.push_back({.kind = Evidence::Kind::kOtherOptimum,
                                      .term = optimum.origin,
                                      .value = optimum.log_likelihood});
  values.insert(values.end(), optimum.estimate.begin(), optimum.estimate.end());
  fit.convergence.find({.kind = kind, .names = fit.coefficient_names, .values = std::move(values)});
}

/// The other optimum that is worth a sentence, if any.
void find_other_optimum(MixedEffectsFit& fit) {
  if (fit.optima.size() < 2) return;
  if (const LocalOptimum* const higher = higher_optimum(fit)) {
    find_optimum(
        Finding::Kind::kHigherOptimum, *higher, {higher->log_likelihood, fit.log_likelihood}, fit);
    return;
  }
  const auto from_start = std::ranges::find(fit.optima, kStartValues, &LocalOptimum::origin);
  if (from_start != fit.optima.end() && from_start != fit.optima.begin()) {
    find_optimum(Finding::Kind::kLowerFromStart, *from_start, {from_start->log_likelihood}, fit);
  } else if (const LocalOptimum* const other = close_optimum(fit)) {
    find_optimum(Finding::Kind::kCloseOptimum, *other, {other->log_likelihood}, fit);
  }
}

}  // namespace

std::optional<ContainedModel> higher_than(double rank,
                                          const std::vector<ContainedModel>& contained) {
  const auto highest = std::ranges::max_element(contained, {}, &ContainedModel::rank);
  if (highest == contained.end() || !(highest->rank > rank + kHigher)) return std::nullopt;
  // The simplest of those that are equally high: they come first.
  return *std::ranges::find_if(contained, [&](const ContainedModel& model) {
    return model.rank > std::max(rank, highest->rank - kHigher);
  });
}

void judge_search(const ModelSpecification& specification,
                  const SearchEvidence& evidence,
                  MixedEffectsFit& fit) {
  Convergence& convergence = fit.convergence;
  if (!convergence.converged()) return;
  const double useless =
      std::max(10.0 * kDoubtful, Thresholds::kUseless * static_cast<double>(fit.observations));
  const std::string method = word_of(evidence.marginal);
  if (evidence.contained) {
    const ContainedModel& contained = *evidence.contained;
    convergence.evidence.push_back({.kind = Evidence::Kind::kContainedModel,
                                    .term = contained.text,
                                    .value = contained.log_likelihood});
    Finding found{
        .kind = Finding::Kind::kContainedDoubt,
        .names = {contained.text},
        .values = {contained.log_likelihood, fit.log_likelihood, evidence.marginal_maximum}};
    if (evidence.marginal_maximum > contained.rank + kHigher) found.names.push_back(method);
    // A fixed point of the alternation, which nlme reports as well, need not be the highest one.
    const bool is_doubt =
        !evidence.method && contained.log_likelihood - fit.log_likelihood < useless;
    if (!is_doubt) {
      found.kind = Finding::Kind::kContainedHigher;
      convergence.conclude(ConvergenceStatus::kContainedModelHigher, std::move(found));
      return;
    }
    convergence.find(std::move(found));
  }
  if (evidence.first_order_maximum > fit.log_likelihood + 10.0 * kDoubtful) {
    convergence.evidence.push_back({.kind = Evidence::Kind::kMarginalMaximum,
                                    .term = "focei",
                                    .value = evidence.first_order_maximum});
    convergence.conclude(ConvergenceStatus::kInvalidApproximation,
                         {.kind = Finding::Kind::kFirstOrderHigher,
                          .values = {evidence.first_order_maximum, fit.log_likelihood}});
    return;
  }
  if (evidence.unfinished > fit.log_likelihood + kHigher) {
    convergence.evidence.push_back(
        {.kind = Evidence::Kind::kHigherEnd, .value = evidence.unfinished});
    convergence.conclude(
        ConvergenceStatus::kMaximumNotReached,
        {.kind = evidence.method == Method::kInteraction ? Finding::Kind::kUnfinishedFirstOrder
                                                         : Finding::Kind::kUnfinishedHigher,
         .values = {fit.log_likelihood, evidence.unfinished},
         .reducible = reducible(specification)});
    return;
  }
  const double error = linearization_error(fit, evidence);
  if (error > kDoubtful) {
    convergence.evidence.push_back(
        {.kind = Evidence::Kind::kMarginal, .term = method, .value = evidence.marginal_here});
    convergence.evidence.push_back({.kind = Evidence::Kind::kMarginalMaximum,
                                    .term = method,
                                    .value = evidence.marginal_maximum});
  }
  if (!evidence.is_restricted && error > useless) {
    // Earlier findings on boundaries and floored values remain valid.
    convergence.status = ConvergenceStatus::kInvalidApproximation;
    convergence.find(
        {.kind = Finding::Kind::kLinearizationFar,
         .names = {method},
         .values = {fit.log_likelihood, evidence.marginal_here, evidence.marginal_maximum}});
    return;
  }
  if (error > kDoubtful) {
    convergence.find({.kind = Finding::Kind::kLinearizationDoubtful,
                      .names = {method},
                      .values = {evidence.marginal_here, evidence.marginal_maximum}});
  }
  find_other_optimum(fit);
}

void judge_quadrature(MixedEffectsFit& fit,
                      const QuadratureCheck& check,
                      const SearchEvidence& evidence) {
  Convergence& convergence = fit.convergence;
  const bool is_quadrature = evidence.method == Method::kQuadrature;
  if ((check.kinks.empty() && !is_quadrature) || !convergence.converged()) return;
  const double error = std::abs(check.log_likelihood - fit.log_likelihood);
  if (is_quadrature && !(error > kHigher)) return;
  Finding found{
      .kind = Finding::Kind::kKink,
      .names = check.kinks,
      .values = {static_cast<double>(check.points), check.log_likelihood, fit.log_likelihood}};
  if (std::isfinite(check.log_likelihood)) {
    convergence.evidence.push_back(
        {.kind = Evidence::Kind::kMarginal, .term = "agq", .value = check.log_likelihood});
    found.kind = check.kinks.empty()      ? Finding::Kind::kFewPoints
                 : is_quadrature          ? Finding::Kind::kKinkFewPoints
                 : evidence.is_restricted ? Finding::Kind::kKinkRestricted
                                          : Finding::Kind::kKinkByQuadrature;
  }
  convergence.find(std::move(found));
}

}  // namespace silvafit::fit
