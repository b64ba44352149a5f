// SPDX-License-Identifier: MIT
#include "optimum_search/optimum_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "lindstrom_bates/lindstrom_bates_search.hpp"
#include "marginal_likelihood/marginal_fit.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "optimum_search/candidate_fits.hpp"
#include "optimum_search/representative_rows.hpp"
#include "optimum_search/search_budget.hpp"
#include "optimum_search/search_verdict.hpp"
#include "optimum_search/smaller_structures.hpp"
#include "optimum_search/starting_points.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// How much less a model's likelihood may be than that of one that it contains: linearizations at
// nearly the same point differ by as much.
constexpr double kSlack = 0.05;
// From so many observations on, starting points are compared on a part of the data.
constexpr Index kManyObservations = 4000;
// Spreads of random effects to start from, as shares of the usual one.
constexpr double kNarrow = 0.1;
constexpr double kVeryNarrow = 0.01;

class OptimumSearch {
 public:
  OptimumSearch(const NonlinearModel& model,
                const LeastSquaresFit& pooled,
                const OptimumSearchOptions& options)
      : model_(model),
        pooled_(pooled),
        options_(options),
        budget_(model,
                options.integration == Integration::kQuadrature ? options.marginal.quadrature_points
                                                                : 1) {}

  MixedEffectsFit run() {
    if (model_.observations() >= kManyObservations) learn_from_part();
    linearize_from_all();
    if (linearized_.empty()) return usual_fit();
    if (model_.specification().random.empty())
      return judged(best_of(by_own_likelihood(linearized_)));
    return options_.integration ? marginal_maximum() : best_fixed_point();
  }

  /// The coefficients of the best fit, neither described nor judged; nothing without one.
  std::optional<VectorXd> best_coefficients() {
    linearize_from_all();
    if (linearized_.empty()) return std::nullopt;
    if (!model_.specification().random.empty()) compare_fixed_points();
    return best_of(linearized_).fit.estimate;
  }

 private:
  /// What is reported where no start leads anywhere.
  MixedEffectsFit usual_fit() {
    return options_.integration
               ? fit_marginal(model_, pooled_.estimate, *options_.integration, options_.marginal)
               : fit_lindstrom_bates(model_, pooled_.estimate, options_.linearized);
  }

  /// With many observations each start is expensive; a part of them shows which starts differ.
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

  std::vector<StartingPoint> points() const {
    const std::vector<VectorXd>& given = options_.linearized.starts;
    if (from_part_.size() == 0) {
      return starting_points(model_, pooled_, {.given = given, .spread = options_.spread_starts});
    }
    std::vector<StartingPoint> result;
    for (const VectorXd& start : given) {
      result.push_back({.coefficients = start, .origin = std::string(kStartValues)});
    }
    result.push_back({.coefficients = pooled_.estimate, .origin = "least squares"});
    result.push_back({.coefficients = from_part_, .origin = "a part of the observations"});
    return result;
  }

  void linearize_from_all() {
    const std::vector<StartingPoint> starts = points();
    const std::size_t given = options_.linearized.starts.size();
    for (std::size_t k = 0; k < starts.size(); ++k) {
      // What the user asks for, and the pooled fit, are tried whatever they cost.
      if (k > given && budget_.is_spent() && has_converged(linearized_)) break;
      linearize_from(starts[k], Persistence::kOnce);
      if (k >= given) continue;
      // Narrow random effects stay near the coefficients that they start from.
      for (const double spread : {kNarrow, kVeryNarrow}) {
        linearize_from(starts[k], Persistence::kOnce, spread);
      }
    }
    if (has_several_ends()) linearize_from(starts[given], Persistence::kOnce, kNarrow);
    if (!has_converged(linearized_)) linearize_from(starts.front(), Persistence::kUntilFound);
  }

  /// Whether starts have led to different points, or nowhere; else more of them are of no use.
  bool has_several_ends() const { return linearized_.size() > 1; }

  void linearize_from(const StartingPoint& point, Persistence persistence, double spread = 1.0) {
    LindstromBatesSearch found =
        climb_lindstrom_bates(model_, point.coefficients, without_starts(), persistence, spread);
    // What the user asks for must not displace anything else.
    if (point.origin != kStartValues) budget_.spend_alternations(found.outcome.iterations);
    if (!found.outcome.is_valid) return;
    add_candidate(linearized_,
                  {.fit = found.engine->result(found.outcome),
                   .origin = point.origin,
                   .obstacle = found.outcome.obstacle});
  }

  static std::vector<Candidate>& by_own_likelihood(std::vector<Candidate>& candidates) {
    for (Candidate& candidate : candidates) candidate.rank = candidate.fit.log_likelihood;
    return candidates;
  }

  /// By Laplace's method if it holds for all, else by the first-order method, which always does.
  void rank_by_marginal_likelihood(std::vector<Candidate>& candidates) {
    for (const Integration integration : {Integration::kLaplace, Integration::kInteraction}) {
      rank_integration_ = integration;
      bool holds = true;
      for (Candidate& candidate : candidates) {
        candidate.rank =
            marginal_log_likelihood(model_, candidate.fit, integration, options_.marginal);
        holds = holds && std::isfinite(candidate.rank);
      }
      if (holds) return;
    }
  }

  /// Whether a part of the observations has told all starts apart: on all of them one fixed point
  /// is left, and its likelihood is near the marginal one.
  bool is_settled() const {
    constexpr double kNear = 2.0;
    return from_part_.size() > 0 && linearized_.size() == 1 &&
           std::abs(linearized_.front().rank - linearized_.front().fit.log_likelihood) < kNear;
  }

  /// Ranks the fixed points and goes on from them to others.
  std::optional<ContainedModel> compare_fixed_points() {
    rank_by_marginal_likelihood(linearized_);
    if (is_settled()) return compare_linearized_with_smaller();
    follow_to_maxima();
    std::optional<ContainedModel> higher = compare_linearized_with_smaller();
    follow_to_maxima();
    finish_given_up();
    return higher;
  }

  /// Runs that stopped early above the best fixed point, often at a singular covariance, continue
  /// from there with independent random effects.
  void finish_given_up() {
    constexpr std::size_t kMost = 2;
    const Candidate best = best_of(linearized_);
    std::vector<Candidate> higher;
    for (const Candidate& candidate : linearized_) {
      if (!candidate.fit.convergence.converged() && candidate.rank > best.rank) {
        higher.push_back(candidate);
      }
    }
    std::ranges::stable_sort(higher, std::ranges::greater(), &Candidate::rank);
    higher.resize(std::min(kMost, higher.size()));
    for (const Candidate& start : higher) {
      if (budget_.is_spent()) return;
      auto found =
          lindstrom_bates_from(model_, with_independent_effects(start.fit), without_starts());
      if (!found) continue;
      budget_.spend_alternations(found->convergence.iterations);
      add_candidate(linearized_, {.fit = *std::move(found), .origin = start.origin});
    }
    if (!higher.empty()) rank_by_marginal_likelihood(linearized_);
  }

  MixedEffectsFit best_fixed_point() {
    SearchEvidence evidence;
    evidence.contained = compare_fixed_points();
    const Candidate& best = best_of(linearized_);
    evidence.marginal_here = best.rank;
    evidence.marginal_maximum = highest_marginal_;
    evidence.marginal = rank_integration_;
    return judged(best, evidence);
  }

  /// The maximum of the marginal likelihood near each of the best fixed points leads to further
  /// ones, from which it goes on.
  void follow_to_maxima() {
    constexpr int kRounds = 3;
    constexpr std::size_t kBest = 3;
    for (int round = 0; round < kRounds && !budget_.is_spent(); ++round) {
      const std::size_t known = linearized_.size();
      std::vector<MixedEffectsFit> starts;
      for (const Candidate* const candidate : highest_few(linearized_, kBest)) {
        if (!candidate->is_followed) starts.push_back(candidate->fit);
      }
      for (Candidate& candidate : linearized_) {
        candidate.is_followed =
            candidate.is_followed || std::ranges::any_of(starts, [&](const MixedEffectsFit& fit) {
              return is_same(candidate.fit, fit);
            });
      }
      for (const MixedEffectsFit& start : starts) follow_to_maximum(start);
      if (linearized_.size() == known) return;
      rank_by_marginal_likelihood(linearized_);
    }
  }

  void follow_to_maximum(const MixedEffectsFit& start) {
    auto maximum = marginal_from(model_, start, rank_integration_, options_.marginal);
    if (!maximum || !maximum->convergence.converged()) {
      maximum = marginal_from(model_, start, Integration::kInteraction, options_.marginal);
    }
    constexpr int kTypical = 100;
    budget_.spend_evaluations(maximum ? maximum->convergence.iterations : kTypical);
    if (!maximum || !std::isfinite(maximum->log_likelihood)) return;
    highest_marginal_ = std::max(highest_marginal_, maximum->log_likelihood);
    const std::string origin = "maximum of the marginal likelihood";
    if (auto found = lindstrom_bates_from(model_, *maximum, without_starts())) {
      budget_.spend_alternations(found->convergence.iterations);
      add_candidate(linearized_, {.fit = *std::move(found), .origin = origin});
    }
    if (!has_several_ends()) return;
    linearize_from(
        {.coefficients = maximum->estimate, .origin = origin}, Persistence::kOnce, kVeryNarrow);
  }

  /// The model without random effects, by generalized least squares: a maximum of its likelihood is
  /// one of the mixed model's, too, on the boundary.
  void compare_without_random_effects(std::vector<ContainedModel>& contained) const {
    const NonlinearModel fixed = model_.with_random_effects({});
    const LindstromBatesSearch found =
        climb_lindstrom_bates(fixed, first_coefficients(), without_starts(), Persistence::kOnce);
    if (!found.outcome.is_valid || !found.outcome.converged) return;
    contained.push_back({.text = "without random effects",
                         .log_likelihood = found.outcome.log_likelihood,
                         .rank = found.outcome.log_likelihood});
  }

  /// Fits with a smaller random structure. The whole model starts from those that end higher than
  /// it, and from those that have not come from it.
  std::optional<ContainedModel> compare_linearized_with_smaller() {
    std::vector<ContainedModel> contained;
    compare_without_random_effects(contained);
    for (const SmallerStructure& smaller : structures_to_compare()) {
      if (budget_.is_spent()) break;
      const Candidate best = best_of(linearized_);
      for (const MixedEffectsFit& found : smaller_fits(smaller, best.fit)) {
        budget_.spend_alternations(2 * found.convergence.iterations);
        const double rank =
            marginal_log_likelihood(smaller.model, found, rank_integration_, options_.marginal);
        const bool is_contained = is_higher(found, best.fit);
        if (is_contained) {
          contained.push_back(
              {.text = smaller.text, .log_likelihood = found.log_likelihood, .rank = rank});
        }
        auto again =
            lindstrom_bates_from(model_,
                                 enlarged(found, smaller, small_deviation(model_, smaller, found)),
                                 options_.linearized);
        const std::string origin = "the fit " + smaller.text;
        const std::size_t known = linearized_.size();
        if (again) budget_.spend_alternations(again->convergence.iterations);
        if (again) add_candidate(linearized_, {.fit = *std::move(again), .origin = origin});
        linearize_from({.coefficients = found.estimate, .origin = origin}, Persistence::kOnce);
        if (linearized_.size() > known) rank_by_marginal_likelihood(linearized_);
      }
    }
    // At a fixed point the marginal likelihood is below its maximum; that is the method's bias.
    return higher_than(std::max(best_of(linearized_).rank, highest_marginal_), contained);
  }

  /// None where a part of the observations has done.
  std::vector<SmallerStructure> structures_to_compare() const {
    return is_settled() ? std::vector<SmallerStructure>() : smaller_structures(model_);
  }

  /// The fit of a smaller structure that the whole model's fit leads to, if it is higher, and that
  /// from the pooled coefficients, if it is another.
  std::vector<MixedEffectsFit> smaller_fits(const SmallerStructure& smaller,
                                            const MixedEffectsFit& whole) const {
    std::vector<MixedEffectsFit> result;
    const auto near =
        lindstrom_bates_from(smaller.model, reduced(whole, smaller), without_starts());
    if (is_higher(near, whole)) result.push_back(*near);
    if (smaller.left_out < 0) return result;
    LindstromBatesSearch own = climb_lindstrom_bates(
        smaller.model, first_coefficients(), without_starts(), Persistence::kOnce);
    if (!own.outcome.is_valid || !own.outcome.converged) return result;
    MixedEffectsFit fit = own.engine->result(own.outcome);
    if (!near || result.empty() || !is_same(*near, fit)) result.push_back(std::move(fit));
    return result;
  }

  const VectorXd& first_coefficients() const {
    return from_part_.size() > 0 ? from_part_ : pooled_.estimate;
  }

  MixedEffectsOptions without_starts() const {
    MixedEffectsOptions options = options_.linearized;
    options.starts.clear();
    return options;
  }

  static bool is_higher(const std::optional<MixedEffectsFit>& smaller,
                        const MixedEffectsFit& whole) {
    return smaller && smaller->convergence.converged() &&
           smaller->log_likelihood > whole.log_likelihood + kSlack;
  }

  MixedEffectsFit marginal_maximum() {
    const Integration integration = *options_.integration;
    rank_by_marginal_likelihood(linearized_);
    compare_linearized_with_smaller();
    add_first_order_maximum();
    for (Candidate& candidate : linearized_) {
      candidate.rank =
          marginal_log_likelihood(model_, candidate.fit, integration, options_.marginal);
    }
    follow_linearized();
    if (!has_converged(maxima_)) follow_patiently();
    SearchEvidence evidence;
    evidence.contained = compare_marginal_with_smaller();
    evidence.first_order_maximum = first_order_maximum_;
    finish_highest();
    evidence.unfinished = highest_unfinished();
    return judged(best_of(by_own_likelihood(maxima_)), evidence);
  }

  /// The maximum from each of the linear models' ends.
  void follow_linearized() {
    // The user's starts do not displace the others.
    const std::size_t tried = 3 * (1 + options_.linearized.starts.size());
    const std::vector<const Candidate*> starts = best_few(linearized_, linearized_.size());
    for (std::size_t k = 0; k < starts.size(); ++k) {
      // Further ones are tried only until one leads to a maximum.
      const bool is_enough = k >= tried ? has_converged(maxima_) || budget_.is_spent()
                                        : has_converged(maxima_) && budget_.is_spent();
      if (is_enough) return;
      try_marginal(starts[k]->fit, starts[k]->origin);
    }
  }

  /// Where no short search has ended at a maximum: a longer one from the best start, with all that
  /// there is to fall back on.
  void follow_patiently() {
    const Candidate& start = best_of(linearized_);
    MixedEffectsFit first = start.fit;
    describe(model_, first);
    judge(model_, first, Rounds::kAlternations, false);
    MixedEffectsFit found = fit_marginal_from(
        model_, pooled_.estimate, first, *options_.integration, options_.marginal);
    budget_.spend_evaluations(found.convergence.iterations);
    maxima_.push_back({.fit = std::move(found), .origin = start.origin});
  }

  /// Where Laplace's likelihood does not hold at a fixed point, the maximum of the first-order one,
  /// which holds everywhere, is often a point where it does.
  void add_first_order_maximum() {
    if (*options_.integration == Integration::kInteraction ||
        *options_.integration == Integration::kFirstOrder) {
      return;
    }
    if (rank_integration_ == Integration::kLaplace) return;
    auto found = marginal_from(
        model_, best_of(linearized_).fit, Integration::kInteraction, options_.marginal);
    if (!found) return;
    first_order_maximum_ = found->log_likelihood;
    linearized_.push_back(
        {.fit = *std::move(found), .origin = "maximum of the first-order likelihood"});
  }

  /// The highest point that was reached, whether or not it is a maximum.
  const Candidate& highest() const {
    return *std::ranges::max_element(maxima_, {}, [](const Candidate& candidate) {
      const double value = candidate.fit.log_likelihood;
      return std::isnan(value) ? -std::numeric_limits<double>::infinity() : value;
    });
  }

  /// A search that was given up at the highest point, or ended there with few digits, goes on.
  void finish_highest() {
    const auto place = static_cast<std::size_t>(&highest() - maxima_.data());
    const Candidate start = maxima_[place];
    constexpr double kExact = 1e-9;  // squared standard errors
    const bool is_finished =
        start.fit.convergence.converged() && start.fit.convergence.newton_decrement <= kExact;
    if (is_finished || !std::isfinite(start.fit.log_likelihood)) return;
    Obstacle obstacle;
    auto found = marginal_from(model_,
                               start.fit,
                               *options_.integration,
                               options_.marginal,
                               {.is_complete = true},
                               &obstacle);
    if (!found) return;
    if (is_same(*found, start.fit) &&
        found->convergence.newton_decrement < start.fit.convergence.newton_decrement) {
      maxima_[place].fit = *std::move(found);
      return;
    }
    add_candidate(
        maxima_,
        {.fit = *std::move(found), .origin = start.origin, .obstacle = std::move(obstacle)});
  }

  /// The log-likelihood of the highest point if no search has converged there; else NaN.
  /// Laplace's increases without bound towards points at which it is not valid and is not used.
  double highest_unfinished() const {
    const bool is_first_order = options_.integration == Integration::kInteraction ||
                                options_.integration == Integration::kFirstOrder;
    if (!is_first_order) return kNaN;
    return highest().fit.convergence.converged() ? kNaN : highest().fit.log_likelihood;
  }

  void try_marginal(const MixedEffectsFit& start, const std::string& origin) {
    Obstacle obstacle;
    auto found = marginal_from(model_,
                               start,
                               *options_.integration,
                               options_.marginal,
                               {.known = highest_converged(maxima_)},
                               &obstacle);
    if (!found) return;
    budget_.spend_evaluations(found->convergence.iterations);
    add_candidate(maxima_,
                  {.fit = *std::move(found), .origin = origin, .obstacle = std::move(obstacle)});
  }

  std::optional<ContainedModel> compare_marginal_with_smaller() {
    std::vector<ContainedModel> contained;
    compare_without_random_effects(contained);
    for (const SmallerStructure& smaller : structures_to_compare()) {
      if (budget_.is_spent()) break;
      const MixedEffectsFit before = best_of(by_own_likelihood(maxima_)).fit;
      if (!std::isfinite(before.log_likelihood)) break;
      const auto found = marginal_from(
          smaller.model, reduced(before, smaller), *options_.integration, options_.marginal);
      if (found) budget_.spend_evaluations(found->convergence.iterations);
      if (!found || !found->convergence.converged()) continue;
      if (is_higher(found, before)) {
        contained.push_back({.text = smaller.text,
                             .log_likelihood = found->log_likelihood,
                             .rank = found->log_likelihood});
      }
      if (!is_higher(found, before) && !has_several_ends()) continue;
      try_marginal(enlarged(*found, smaller, small_deviation(model_, smaller, before)),
                   "the fit " + smaller.text);
    }
    return higher_than(best_of(by_own_likelihood(maxima_)).rank, contained);
  }

  MixedEffectsFit judged(const Candidate& best, const SearchEvidence& evidence = {}) {
    const bool is_marginal = options_.integration.has_value();
    MixedEffectsFit fit = best.fit;
    // A fit that failed has been judged where the reason is known.
    if (fit.convergence.verdict.empty()) {
      describe(model_, fit);
      judge(model_,
            fit,
            is_marginal ? Rounds::kEvaluations : Rounds::kAlternations,
            options_.linearized.reml,
            best.obstacle);
    }
    fit.optima = optima_of(best, is_marginal ? maxima_ : linearized_, is_marginal);
    judge_search(fit, evidence);
    return fit;
  }

  const NonlinearModel& model_;
  const LeastSquaresFit& pooled_;
  const OptimumSearchOptions& options_;
  VectorXd from_part_;                 ///< (p) the best of a part of the data; empty without one
  std::vector<Candidate> linearized_;  ///< fixed points of Lindstrom and Bates' method
  std::vector<Candidate> maxima_;      ///< of a marginal likelihood
  SearchBudget budget_;
  Integration rank_integration_ = Integration::kLaplace;
  /// Of the first-order likelihood, where Laplace's does not hold at all fixed points.
  double first_order_maximum_ = kNaN;
  double highest_marginal_ = -std::numeric_limits<double>::infinity();
};

}  // namespace

MixedEffectsFit search_optimum(const NonlinearModel& model,
                               const LeastSquaresFit& pooled,
                               const OptimumSearchOptions& options) {
  if (options.integration) check_marginal(model, *options.integration, options.marginal);
  return OptimumSearch(model, pooled, options).run();
}

}  // namespace silvafit::fit
