// SPDX-License-Identifier: MIT
#include "optimum_search/optimum_search.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "marginal_likelihood/marginal_fit.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "optimum_search/candidate_fits.hpp"
#include "optimum_search/fixed_points.hpp"
#include "optimum_search/marginal_maxima.hpp"
#include "optimum_search/representative_rows.hpp"
#include "optimum_search/search_verdict.hpp"
#include "silvafit/base/constants.hpp"

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
      : model_(model), pooled_(pooled), options_(options) {}

  MixedEffectsFit run() {
    if (model_.observations() >= kManyObservations) learn_from_part();
    std::vector<FixedPoints> searches = search_fixed_points();
    if (searches.empty()) return usual_fit();
    if (model_.specification().random.empty()) return best_without_random_effects(searches);
    return options_.integration ? marginal_maximum(searches, *options_.integration)
                                : best_fixed_point(searches);
  }

  /// The coefficients of the best fit, without standard errors and message; none without a fit.
  std::optional<VectorXd> best_coefficients() {
    std::vector<FixedPoints> searches = search_fixed_points();
    if (searches.empty()) return std::nullopt;
    if (model_.specification().random.empty()) {
      return best_without_random_effects(searches).estimate;
    }
    compare(searches);
    return best_of(searches.front().all()).fit.estimate;
  }

 private:
  /// Searches that have led to fits. Those from the user's starts and from the program's own are
  /// separate, so that a start changes nothing in the search without it.
  std::vector<FixedPoints> search_fixed_points() {
    std::vector<FixedPoints> result;
    // Of equal fits, such as those of an alias of a frequency, the first is reported.
    for (const Starts starts : {Starts::kGiven, Starts::kFound}) {
      if (starts == Starts::kGiven && options_.linearized.starts.empty()) continue;
      FixedPoints points(model_, pooled_, options_, from_part_, starts);
      points.search();
      if (!points.all().empty()) result.push_back(std::move(points));
    }
    return result;
  }

  /// Compares the fixed points of each search; then the first one has those of all.
  static void compare(std::vector<FixedPoints>& searches) {
    for (FixedPoints& points : searches) points.compare();
    for (std::size_t k = 1; k < searches.size(); ++k) {
      searches.front().absorb(std::move(searches[k]));
    }
  }

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

  MixedEffectsFit best_without_random_effects(std::vector<FixedPoints>& searches) {
    std::vector<Candidate> all;
    for (FixedPoints& points : searches) {
      for (Candidate& candidate : points.all()) add_candidate(all, std::move(candidate));
    }
    for (Candidate& candidate : all) candidate.rank = candidate.fit.log_likelihood;
    return judged(chosen(all, best_of(all)), all, {});
  }

  MixedEffectsFit best_fixed_point(std::vector<FixedPoints>& searches) {
    compare(searches);
    FixedPoints& points = searches.front();
    const Candidate& best = best_of(points.all());
    const Candidate& shown = chosen(points.all(), best);
    return judged(shown, points.all(), of_shown(points.evidence(shown), shown, best));
  }

  MixedEffectsFit marginal_maximum(std::vector<FixedPoints>& searches, Integration integration) {
    std::optional<MarginalMaxima> maxima;
    for (FixedPoints& points : searches) {
      points.has_several_ends() ? points.compare() : points.compare_briefly();
      MarginalMaxima found(model_, pooled_, options_, integration, points);
      found.search();
      if (maxima) {
        maxima->absorb(std::move(found));
      } else {
        maxima.emplace(std::move(found));
      }
    }
    const Candidate& best = maxima->best();
    const Candidate& shown = chosen(maxima->all(), best);
    return judged(shown, maxima->all(), of_shown(maxima->evidence(shown), shown, best));
  }

  const Candidate& chosen(const std::vector<Candidate>& all, const Candidate& best) const {
    return chosen_optimum(model_.coefficient_names(), all, best, options_.wishes);
  }

  /// If the user's wishes exclude the best fit, others that are higher are no evidence against the
  /// one that is shown.
  static SearchEvidence of_shown(SearchEvidence evidence,
                                 const Candidate& shown,
                                 const Candidate& best) {
    if (&shown == &best) return evidence;
    evidence.contained.reset();
    evidence.marginal_maximum = evidence.marginal_here;
    evidence.first_order_maximum = evidence.unfinished = kNaN;
    return evidence;
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
    judge_search(model_.specification(), evidence, fit);
    if (fit.convergence.converged()) judge_kinks(fit, kinks_at(fit), evidence);
    return fit;
  }

  /// Kinks of the formula in random coefficients, and the likelihood by quadrature with twice the
  /// points that the fit has, or would have.
  Kinks kinks_at(const MixedEffectsFit& fit) const {
    Kinks kinks{.coefficients = model_.random_kinks()};
    if (kinks.coefficients.empty()) return kinks;
    MarginalOptions options = options_.marginal;
    options.quadrature_points = kinks.points = 2 * options.quadrature_points + 1;
    try {
      check_marginal(model_, Integration::kQuadrature, options);
    } catch (const UsageError&) {
      return kinks;  // too many effects
    }
    kinks.by_quadrature = marginal_log_likelihood(model_, fit, Integration::kQuadrature, options);
    return kinks;
  }

  const NonlinearModel& model_;
  const LeastSquaresFit& pooled_;
  const OptimumSearchOptions& options_;
  VectorXd from_part_;  ///< (p) best coefficients of a part of the data; empty without one
};

}  // namespace

MixedEffectsFit search_optimum(const NonlinearModel& model,
                               const LeastSquaresFit& pooled,
                               const OptimumSearchOptions& options) {
  if (options.integration) check_marginal(model, *options.integration, options.marginal);
  return OptimumSearch(model, pooled, options).run();
}

}  // namespace silvafit::fit
