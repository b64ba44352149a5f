// SPDX-License-Identifier: MIT
#include "optimum_search/optimum_search.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "marginal_likelihood/marginal_fit.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "optimization/tolerances.hpp"
#include "optimum_search/candidate_fits.hpp"
#include "optimum_search/local_optima.hpp"
#include "optimum_search/marginal_maxima.hpp"
#include "optimum_search/search_evidence.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

// With at least this many observations, starting points are compared on a part of the data.
constexpr Index kManyObservations = 4000;

/// The observations of evenly chosen clusters, or evenly chosen observations if there are few
/// clusters: about 2,000.
std::vector<Index> representative_rows(const NonlinearModel& model) {
  constexpr Index kRows = 2000;
  constexpr Index kFewestClusters = 30;
  const Index step = (model.observations() + kRows - 1) / kRows;
  std::vector<Index> rows;
  if (model.cluster_count() < step * kFewestClusters) {
    for (Index i = 0; i < model.observations(); i += step) rows.push_back(i);
    return rows;
  }
  for (Index c = 0; c < model.cluster_count(); c += step) {
    const Index end = model.group_begin(model.cluster_begin(c + 1));
    for (Index i = model.group_begin(model.cluster_begin(c)); i < end; ++i) rows.push_back(i);
  }
  return rows;
}

class OptimumSearch {
 public:
  OptimumSearch(const NonlinearModel& model,
                const LeastSquaresFit& pooled,
                Method method,
                const MixedEffectsOptions& options,
                const FitModelOptions& wishes)
      : model_(model), pooled_(pooled), method_(method), options_(options), wishes_(wishes) {}

  MixedEffectsFit run() {
    if (model_.observations() >= kManyObservations && !model_.is_linear()) learn_from_part();
    LocalOptima found = local_optima();
    if (found.ends().empty()) return usual_fit();
    if (model_.specification().random.empty()) return best_without_random_effects(found);
    return is_marginal(method_) ? marginal_maximum(found) : best_fixed_point(found);
  }

  /// The coefficients of the best fit, without standard errors and message; none without a fit.
  std::optional<VectorXd> best_coefficients() {
    const LocalOptima found = local_optima();
    if (found.ends().empty()) return std::nullopt;
    return best_of(found.ends()).fit.estimate;
  }

 private:
  /// Those from the user's starts and from the program's own are searched separately, so that a
  /// start changes nothing in the search without it. Of equal fits the first is reported.
  LocalOptima local_optima() const {
    std::vector<StartingPoint> given;
    for (const VectorXd& start : options_.starts) {
      given.push_back({.coefficients = start, .origin = std::string(kStartValues)});
    }
    std::vector<StartingPoint> own = own_starts();
    if (given.empty()) return searched(std::move(own));
    LocalOptima result = searched(std::move(given));
    result.add(searched(std::move(own)));
    return result;
  }

  std::vector<StartingPoint> own_starts() const {
    // The likelihood of a linear model with constant variance has one maximum, which any start
    // reaches.
    if (model_.is_linear() && model_.specification().variance.factors.empty()) {
      return {{.coefficients = pooled_.estimate, .origin = std::string(kPooledFit)}};
    }
    if (from_part_.size() == 0) return starting_points(model_, pooled_, wishes_.spread_starts);
    return {{.coefficients = pooled_.estimate, .origin = std::string(kPooledFit)},
            {.coefficients = from_part_, .origin = "a part of the observations"}};
  }

  LocalOptima searched(std::vector<StartingPoint> starts) const {
    LocalOptima result(model_, options_, std::move(starts));
    result.search(!is_marginal(method_));
    return result;
  }

  /// The result if no start leads to a fit.
  MixedEffectsFit usual_fit() const {
    return is_marginal(method_) ? fit_marginal(model_, pooled_.estimate, method_, options_)
                                : fit_lindstrom_bates(model_, pooled_.estimate, options_);
  }

  /// With many observations each start is expensive; a part of them is enough to compare starts.
  void learn_from_part() {
    const NonlinearModel part = model_.subset(representative_rows(model_));
    const LeastSquaresFit pooled =
        fit_least_squares(part, {.other_minima = true, .further_starts = wishes_.spread_starts});
    if (!pooled.estimate.allFinite()) return;
    MixedEffectsOptions options = options_;
    options.trace = nullptr;
    OptimumSearch search(part, pooled, method_, options, wishes_);
    if (auto found = search.best_coefficients()) from_part_ = *std::move(found);
  }

  MixedEffectsFit best_without_random_effects(const LocalOptima& found) const {
    return judged(chosen(found.ends(), best_of(found.ends())), found.ends(), {});
  }

  MixedEffectsFit best_fixed_point(LocalOptima& found) const {
    take_wished_roles(found.ends());
    const Candidate& best = best_of(found.ends());
    const Candidate& shown = chosen(found.ends(), best);
    const SearchEvidence evidence = of_shown(linearization_evidence(found, shown), shown, best);
    polish(found.ends()[static_cast<std::size_t>(&shown - found.ends().data())]);
    return judged(shown, found.ends(), evidence);
  }

  /// An end that was reached by careful steps has fewer digits than the method can give.
  void polish(Candidate& candidate) const {
    constexpr double kExact = 1e-12;  // squared standard errors
    const Convergence& reached = candidate.fit.convergence;
    if (!reached.converged() || reached.newton_decrement <= kExact) return;
    MixedEffectsOptions options = options_;
    options.starts.clear();
    const LindstromBatesEnd end = lindstrom_bates_from(model_, candidate.fit, options);
    const bool is_better = end.fit && end.fit->convergence.converged() &&
                           end.fit->convergence.newton_decrement < reached.newton_decrement;
    if (is_better && is_same(*end.fit, candidate.fit)) candidate.fit = *end.fit;
  }

  /// What the marginal likelihood says about an end of Lindstrom and Bates' method.
  SearchEvidence linearization_evidence(const LocalOptima& found, const Candidate& shown) const {
    SearchEvidence result;
    std::vector<ContainedModel> higher = found.contained();
    std::erase_if(higher, [&](const ContainedModel& model) {
      return !(model.log_likelihood > shown.fit.log_likelihood + kHigher);
    });
    result.contained = higher_than(shown.rank, higher);
    result.is_restricted = options_.reml;
    result.marginal = Method::kInteraction;
    result.marginal_here = shown.rank;
    result.marginal_maximum = std::max(shown.rank, highest_converged(found.maxima()));
    // A maximum of this model above that of the smaller one is the answer, wherever it is.
    const bool is_exceeded =
        result.contained && result.marginal_maximum > result.contained->rank + kHigher;
    if (model_.is_linear() || is_exceeded) return result;
    const double laplace = marginal_log_likelihood(model_, shown.fit, Method::kLaplace, options_);
    if (!std::isfinite(laplace)) return result;
    const MarginalEnd end = marginal_from(model_, shown.fit, Method::kLaplace, options_);
    if (!end.fit || !end.fit->convergence.converged()) return result;
    result.marginal = Method::kLaplace;
    result.marginal_here = laplace;
    result.marginal_maximum = std::max(laplace, end.fit->log_likelihood);
    return result;
  }

  MixedEffectsFit marginal_maximum(const LocalOptima& found) const {
    const std::size_t asked = static_cast<std::size_t>(wishes_.spread_starts) / 4;
    MarginalMaxima maxima(model_, pooled_.estimate, method_, options_, found);
    maxima.search(found.has_several() ? kClimbs + 3 * asked : 1);
    take_wished_roles(maxima.all());
    const Candidate& best = maxima.best();
    const Candidate& shown = chosen(maxima.all(), best);
    return judged(shown, maxima.all(), of_shown(maxima.evidence(shown), shown, best));
  }

  void take_wished_roles(std::vector<Candidate>& all) const {
    for (Candidate& candidate : all) {
      candidate.fit = with_wished_roles(model_, candidate.fit, method_, options_, wishes_);
    }
  }

  const Candidate& chosen(const std::vector<Candidate>& all, const Candidate& best) const {
    return chosen_optimum(model_.coefficient_names(), all, best, wishes_);
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
    MixedEffectsFit fit = best.fit;
    // A failed fit already has a message with the reason.
    if (fit.convergence.findings.empty()) {
      describe(model_, fit);
      if (is_marginal(method_)) compute_errors(model_, method_, options_, fit);
      judge(model_,
            fit,
            is_marginal(method_) ? Rounds::kEvaluations : Rounds::kAlternations,
            options_.reml,
            best.obstacle);
    }
    fit.optima = optima_of(best, all, is_marginal(method_));
    judge_search(model_.specification(), evidence, fit);
    if (fit.convergence.converged()) judge_quadrature(fit, quadrature_at(fit), evidence);
    return fit;
  }

  /// Kinks of the formula in random coefficients, and the likelihood by quadrature with twice the
  /// points that the fit has, or would have.
  QuadratureCheck quadrature_at(const MixedEffectsFit& fit) const {
    QuadratureCheck check{.kinks = model_.random_kinks()};
    if (check.kinks.empty() && method_ != Method::kQuadrature) return check;
    MixedEffectsOptions options = options_;
    options.quadrature_points = check.points = 2 * options.quadrature_points + 1;
    try {
      check_marginal(model_, Method::kQuadrature, options);
    } catch (const UsageError&) {
      return check;  // too many effects or points
    }
    check.log_likelihood = marginal_log_likelihood(model_, fit, Method::kQuadrature, options);
    return check;
  }

  const NonlinearModel& model_;
  const LeastSquaresFit& pooled_;
  Method method_;
  const MixedEffectsOptions& options_;
  const FitModelOptions& wishes_;
  VectorXd from_part_;  ///< (p) best coefficients of a part of the data; empty without one
};

}  // namespace

MixedEffectsFit search_optimum(const NonlinearModel& model,
                               const LeastSquaresFit& pooled,
                               Method method,
                               const MixedEffectsOptions& options,
                               const FitModelOptions& wishes) {
  if (is_marginal(method)) check_marginal(model, method, options);
  return OptimumSearch(model, pooled, method, options, wishes).run();
}

}  // namespace silvafit::fit
