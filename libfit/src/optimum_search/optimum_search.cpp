// SPDX-License-Identifier: MIT
#include "optimum_search/optimum_search.hpp"

#include <optional>
#include <utility>
#include <vector>

#include "marginal_likelihood/marginal_fit.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "optimum_search/candidate_fits.hpp"
#include "optimum_search/fixed_points.hpp"
#include "optimum_search/marginal_maxima.hpp"
#include "optimum_search/representative_rows.hpp"
#include "optimum_search/search_verdict.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// With at least this many observations, starting points are compared on a part of the data.
constexpr Index kManyObservations = 4000;

class OptimumSearch {
 public:
  OptimumSearch(const NonlinearModel& model,
                const LeastSquaresFit& pooled,
                const OptimumSearchOptions& options)
      : model_(model),
        pooled_(pooled),
        options_(options),
        points_(model, pooled, options, from_part_) {}

  MixedEffectsFit run() {
    if (model_.observations() >= kManyObservations) learn_from_part();
    points_.search();
    if (points_.all().empty()) return usual_fit();
    if (model_.specification().random.empty()) return best_without_random_effects();
    return options_.integration ? marginal_maximum(*options_.integration) : best_fixed_point();
  }

  /// The coefficients of the best fit, without standard errors and message; none without a fit.
  std::optional<VectorXd> best_coefficients() {
    points_.search();
    if (points_.all().empty()) return std::nullopt;
    if (!model_.specification().random.empty()) points_.compare();
    return best_of(points_.all()).fit.estimate;
  }

 private:
  /// The result if no start leads to a fit.
  MixedEffectsFit usual_fit() {
    return options_.integration
               ? fit_marginal(model_, pooled_.estimate, *options_.integration, options_.marginal)
               : fit_lindstrom_bates(model_, pooled_.estimate, options_.linearized);
  }

  /// With many observations each start is expensive; a part of them is enough to compare starts.
  void learn_from_part() {
    const NonlinearModel part = model_.subset(representative_rows(model_));
    const LeastSquaresFit pooled =
        fit_least_squares(part, {.other_minima = true, .further_starts = options_.spread_starts});
    if (!pooled.estimate.allFinite()) return;
    OptimumSearchOptions options = options_;
    options.linearized.trace = nullptr;
    if (auto found = OptimumSearch(part, pooled, options).best_coefficients()) {
      from_part_ = *std::move(found);
    }
  }

  MixedEffectsFit best_without_random_effects() {
    std::vector<Candidate>& all = points_.all();
    for (Candidate& candidate : all) candidate.rank = candidate.fit.log_likelihood;
    return judged(best_of(all), all, {});
  }

  MixedEffectsFit best_fixed_point() {
    points_.compare();
    const Candidate& best = best_of(points_.all());
    return judged(best, points_.all(), points_.evidence(best));
  }

  MixedEffectsFit marginal_maximum(Integration integration) {
    points_.has_several_ends() ? points_.compare() : points_.compare_briefly();
    MarginalMaxima maxima(model_, pooled_, options_, integration, points_);
    maxima.search();
    return judged(maxima.best(), maxima.all(), maxima.evidence());
  }

  MixedEffectsFit judged(const Candidate& best,
                         const std::vector<Candidate>& all,
                         const SearchEvidence& evidence) const {
    const bool is_marginal = options_.integration.has_value();
    MixedEffectsFit fit = best.fit;
    // A failed fit already has a message with the reason.
    if (fit.convergence.verdict.empty()) {
      describe(model_, fit);
      judge(model_,
            fit,
            is_marginal ? Rounds::kEvaluations : Rounds::kAlternations,
            options_.linearized.reml,
            best.obstacle);
    }
    fit.optima = optima_of(best, all, is_marginal);
    judge_search(fit, evidence);
    return fit;
  }

  const NonlinearModel& model_;
  const LeastSquaresFit& pooled_;
  const OptimumSearchOptions& options_;
  VectorXd from_part_;  ///< (p) best coefficients of a part of the data; empty without one
  FixedPoints points_;
};

}  // namespace

MixedEffectsFit search_optimum(const NonlinearModel& model,
                               const LeastSquaresFit& pooled,
                               const OptimumSearchOptions& options) {
  if (options.integration) check_marginal(model, *options.integration, options.marginal);
  return OptimumSearch(model, pooled, options).run();
}

}  // namespace silvafit::fit
