// SPDX-License-Identifier: MIT
#include "optimum_search/smaller_structures.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

namespace silvafit::fit {
namespace {

RandomEffects without(const RandomEffects& random, std::size_t effect) {
  RandomEffects result = random;
  result.coefficients.erase(result.coefficients.begin() + static_cast<Index>(effect));
  auto left = static_cast<int>(effect);
  for (std::size_t k = 0; k < result.blocks.size(); ++k) {
    if (left < result.blocks[k]) {
      if (--result.blocks[k] == 0)
        result.blocks.erase(result.blocks.begin() + static_cast<Index>(k));
      break;
    }
    left -= result.blocks[k];
  }
  return result;
}

/// Indices of the remaining effects.
std::vector<Index> others(Index count, Index left_out) {
  std::vector<Index> result;
  for (Index k = 0; k < count; ++k) {
    if (k != left_out) result.push_back(k);
  }
  return result;
}

NonlinearModel with_term(const NonlinearModel& model,
                         std::size_t term,
                         const RandomEffects& random) {
  std::vector<RandomEffects> terms = model.specification().random;
  terms[term] = random;
  return model.with_random_effects(std::move(terms));
}

void add_smaller(const NonlinearModel& model,
                 std::size_t term,
                 std::vector<SmallerStructure>& result) {
  const RandomEffects& random = model.specification().random[term];
  if (random.coefficients.size() < 2) return;
  const bool is_symmetric = random.covariance == Covariance::kCompoundSymmetry;
  const std::string of = model.term_count() > 1 ? " by " + random.group_name() : "";
  // With a common variance all effects are there, or none.
  for (std::size_t k = 0; !random.has_equal_variances() && k < random.coefficients.size(); ++k) {
    result.push_back(
        {.model = with_term(model, term, without(random, k)),
         .text = fmt::format("without the random effect of {}{}", random.coefficients[k], of),
         .term = term,
         .left_out = static_cast<Index>(k)});
  }
  const bool is_correlated = is_symmetric || random.covariance == Covariance::kGeneral ||
                             random.covariance == Covariance::kBlock;
  if (!is_correlated) return;
  RandomEffects independent = random;
  independent.covariance = is_symmetric ? Covariance::kIdentity : Covariance::kDiagonal;
  independent.blocks.clear();
  result.push_back({.model = with_term(model, term, independent),
                    .text = "with independent random effects" + of,
                    .term = term});
}

}  // namespace

std::vector<SmallerStructure> smaller_structures(const NonlinearModel& model) {
  std::vector<SmallerStructure> result;
  for (std::size_t t = model.term_count(); t-- > 0;) add_smaller(model, t, result);
  return result;
}

MixedEffectsFit reduced(const MixedEffectsFit& fit, const SmallerStructure& smaller) {
  MixedEffectsFit result = fit;
  EstimatedEffects& term = result.random[smaller.term];
  MatrixXd& covariance = term.covariance;
  MatrixXd& effects = term.effects;
  if (smaller.left_out < 0) {
    covariance = MatrixXd(covariance.diagonal().asDiagonal());
    return result;
  }
  const std::vector<Index> left = others(covariance.rows(), smaller.left_out);
  covariance = MatrixXd(covariance(left, left));
  effects = MatrixXd(effects(left, Eigen::all));
  return result;
}

double small_deviation(const NonlinearModel& model,
                       const SmallerStructure& smaller,
                       const MixedEffectsFit& fit) {
  if (smaller.left_out < 0) return 0.0;
  const std::vector<Index> places =
      model.coefficients_of(model.specification().random[smaller.term]);
  const MatrixXd jacobian = model.curve_at(model.extended(fit.estimate)).jacobian;
  const double slope = jacobian.col(places[static_cast<std::size_t>(smaller.left_out)]).norm() /
                       std::sqrt(static_cast<double>(model.observations()));
  constexpr double kShare = 0.1;
  const double deviation = kShare * fit.residual_sd.mean() / slope;
  return std::isfinite(deviation) ? deviation : 0.0;
}

MixedEffectsFit enlarged(const MixedEffectsFit& fit,
                         const SmallerStructure& smaller,
                         double deviation) {
  MixedEffectsFit result = fit;
  if (smaller.left_out < 0) return result;
  EstimatedEffects& term = result.random[smaller.term];
  MatrixXd& covariance = term.covariance;
  MatrixXd& effects = term.effects;
  const Index count = covariance.rows() + 1;
  const std::vector<Index> known = others(count, smaller.left_out);
  MatrixXd whole = MatrixXd::Zero(count, count);
  whole(known, known) = covariance;
  whole(smaller.left_out, smaller.left_out) = deviation * deviation;
  MatrixXd all = MatrixXd::Zero(count, effects.cols());
  all(known, Eigen::all) = effects;
  covariance = std::move(whole);
  effects = std::move(all);
  return result;
}

}  // namespace silvafit::fit
