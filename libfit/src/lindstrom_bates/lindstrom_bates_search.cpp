// SPDX-License-Identifier: MIT
#include "lindstrom_bates/lindstrom_bates_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "least_squares/jacobian_factors.hpp"
#include "least_squares/least_squares_verdict.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "optimization/tolerances.hpp"
#include "result/group_coefficients.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "variance/variance_kind.hpp"
#include "verdict/reducible.hpp"

namespace silvafit::fit {
namespace {

// Most converging runs need fewer passes over the data; most others never converge.
constexpr int kPassesOfOneRun = 500;
constexpr int kPassesOfAllRuns = 2000;
// A run from an earlier fit, or from a maximum of a marginal likelihood, nearly always converges,
// but slowly if penalized least squares does.
constexpr int kPassesFromFit = 1500;
// Converged: the next iteration would change theta by less than 1e-6 standard errors.
constexpr double kTolerance = 1e-14;

// For a start, an accuracy of a hundredth of a standard error is sufficient.
constexpr double kRoughTolerance = 1e-4;

/// One run, and further ones from the interior if it stopped at a singular covariance while the
/// likelihood increases towards the interior.
LindstromBatesOutcome run_from(LindstromBates& engine,
                               const LindstromBatesState& start,
                               Alternation how) {
  LindstromBatesOutcome outcome = engine.run(start, how);
  LindstromBatesState inside;
  constexpr int kAttempts = 3;
  for (int attempt = 0; attempt < kAttempts && engine.leave_boundary(outcome, inside); ++attempt) {
    LindstromBatesOutcome moved = engine.run(inside, how);
    if (!moved.is_valid || moved.log_likelihood <= outcome.log_likelihood + kRoundedLikelihood)
      break;
    outcome = std::move(moved);
  }
  return outcome;
}

bool is_better(const LindstromBatesOutcome& a, const LindstromBatesOutcome& b) {
  if (!a.is_valid || !b.is_valid) return a.is_valid;
  const bool is_end = a.converged || a.is_limit;
  if (is_end != (b.converged || b.is_limit)) return is_end;
  return compared(a.log_likelihood, a.is_limit) >
         compared(b.log_likelihood, b.is_limit) + kRoundedLikelihood;
}

/// The log-likelihood that a fit must reach: that of the pooled fit, unless a held exponent makes
/// it unreachable.
double least_likelihood(const VarianceFunction& function, const PooledFit& pooled) {
  return contains_constant(function) ? pooled.log_likelihood - kRoundedLikelihood : -kInfinity;
}

/// The best of several runs; a run counts as converged only if it reaches a given likelihood.
class Search {
 public:
  Search(LindstromBates& engine, double least) : engine_(engine), least_(least) {}

  void consider(const LindstromBatesState& start, Alternation how) {
    LindstromBatesOutcome outcome = run_from(engine_, start, how);
    outcome.is_limit = engine_.is_limit(outcome);
    if (outcome.is_limit && engine_.has_unbounded_range(outcome.state))
      unbounded_ = std::max(unbounded_, outcome.log_likelihood);
    outcome.converged = outcome.converged && !outcome.is_limit && outcome.log_likelihood > least_;
    if (is_better(outcome, best_)) best_ = std::move(outcome);
  }

  /// From one spread of the random effects. A wide one is suitable for most fits; with a narrow one
  /// the run stays near its starting coefficients.
  void try_once(double spread = 1.0) {
    engine_.set_short_step_limit(kFewShortSteps);
    consider(engine_.start(spread),
             spread < 1.0 ? Alternation::kCareful : Alternation::kInterleaved);
  }

  /// From the first-order start, then with random effects from large to small, the small ones again
  /// with more short steps. A start with small effects keeps groups that are far from the pooled
  /// fit from running into mirror images of their curves in the first step; the widest gives each
  /// group its own least-squares fit.
  void try_all_starts() {
    constexpr int kManyShortSteps = 100;
    // So wide that the coefficients of a group depend only on its own observations.
    constexpr double kOwnFits = 30.0;
    const bool is_second_try = best_.is_valid;
    try_once();
    if (best_.converged && !is_second_try) return;
    consider(engine_.first_order_start(), Alternation::kCareful);
    if (best_.converged) return;
    for (const double spread : {1.0, 0.1, 0.01, 0.001, kOwnFits}) {
      consider(engine_.start(spread), Alternation::kCareful);
    }
    if (best_.converged) return;
    engine_.set_short_step_limit(kManyShortSteps);
    for (const double spread : {0.1, 0.01}) {
      consider(engine_.start(spread), Alternation::kCareful);
    }
  }

  const LindstromBatesOutcome& best() const { return best_; }
  /// The highest log-likelihood with a range without bound.
  double unbounded() const { return unbounded_; }

 private:
  static constexpr int kFewShortSteps = 6;

  LindstromBates& engine_;
  double least_;
  LindstromBatesOutcome best_;
  double unbounded_ = -kInfinity;
};

bool is_held(const VarianceFactor& factor) {
  return factor.delta && (!kind_of(factor).has_constant() || factor.constant);
}

/// The factors of a variance function that have no free parameters, and their indices.
std::pair<VarianceFunction, std::vector<std::size_t>> held_factors(
    const VarianceFunction& function) {
  std::pair<VarianceFunction, std::vector<std::size_t>> result{function, {}};
  std::erase_if(result.first.factors,
                [](const VarianceFactor& factor) { return !is_held(factor); });
  for (std::size_t k = 0; k < function.factors.size(); ++k) {
    if (is_held(function.factors[k])) result.second.push_back(k);
  }
  return result;
}

/// Whether coefficients are equal except for rounding, so that another search is useless.
bool is_same_start(const VectorXd& a, const VectorXd& b) {
  constexpr double kSame = 1e-8;
  return ((a - b).array().abs() <= kSame * a.array().abs().max(b.array().abs())).all();
}

/// Whether coefficients give about the same curve as the pooled fit, so that the search from there
/// would have the same result.
bool has_same_curve(const NonlinearModel& model, const VectorXd& pooled, const VectorXd& other) {
  const auto squares = [&](const VectorXd& coefficients) {
    return (model.response() - model.mean_at(coefficients)).squaredNorm();
  };
  constexpr double kMuchWorse = 2.0;
  return squares(other) <= kMuchWorse * squares(pooled);
}

/// The reason why penalized least squares found no first step.
Convergence why_no_step(const NonlinearModel& model, const VectorXd& start) {
  const auto [mean, jacobian] = model.curve_at(start);
  Convergence result;
  if (is_exact(model, (model.response() - mean).squaredNorm())) {
    result.conclude(ConvergenceStatus::kNoMaximum, {.kind = Finding::Kind::kPerfectByFixedEffects});
    return result;
  }
  const std::vector<Index> confounded =
      jacobian.allFinite() ? JacobianFactors(jacobian).confounded() : std::vector<Index>();
  if (!confounded.empty() && !is_identifiable(model)) {
    result.conclude(ConvergenceStatus::kNotIdentifiable,
                    confounding(model, confounded),
                    Evidence::Kind::kNotIdentifiable);
    return result;
  }
  result.conclude(
      ConvergenceStatus::kDiverged,
      {.kind = Finding::Kind::kNoFirstStep, .reducible = reducible(model.specification())});
  return result;
}

MixedEffectsFit failed(const NonlinearModel& model, const VectorXd& start, Convergence reason) {
  MixedEffectsFit fit;
  name_terms(model, fit);
  fit.set_missing(model.specification());
  fit.estimate = start;
  fit.observations = model.observations();
  fit.fitted_population = VectorXd::Constant(model.observations(), kNaN);
  fit.fitted_conditional = fit.fitted_population;
  fit.residual_sd = fit.fitted_population;
  fit.convergence = std::move(reason);
  return fit;
}

}  // namespace

LindstromBatesSearch climb_lindstrom_bates(const NonlinearModel& model,
                                           const VectorXd& start,
                                           const MixedEffectsOptions& options,
                                           Persistence persistence,
                                           double spread) {
  const PooledFit pooled = pooled_fit(model, start, options);
  const int passes = persistence == Persistence::kOnce ? kPassesOfOneRun : kPassesOfAllRuns;
  const VarianceFunction& function = model.specification().variance;
  const auto [constant, factors_of] = held_factors(function);
  LindstromBatesWork work;
  std::optional<SmallerVariance> smaller;
  const bool is_correlated = model.specification().correlation.has_value();
  if (constant.factors.size() < function.factors.size() || is_correlated) {
    // The engine of the smaller fit is released before that of the larger uses memory.
    LindstromBates engine(model, pooled, constant, options, false);
    engine.set_tolerance(kRoughTolerance);
    engine.set_passes(passes);
    Search search(engine, least_likelihood(constant, pooled));
    search.try_once(spread);
    work += engine.work();
    if (search.best().is_valid) smaller = engine.variance_of(search.best());
  }
  auto engine = std::make_unique<LindstromBates>(model, pooled, function, options);
  engine->set_tolerance(kTolerance);
  std::vector<LindstromBatesState> states;
  if (smaller) states = engine->with_residuals(engine->start_from(*smaller, factors_of));
  engine->set_passes(passes);
  Search search(*engine, least_likelihood(function, pooled));
  for (const LindstromBatesState& state : states) {
    search.consider(state, Alternation::kInterleaved);
  }
  const bool is_below = smaller && smaller->converged &&
                        search.best().log_likelihood < smaller->log_likelihood - kHigher;
  if (!search.best().converged || is_below) {
    persistence == Persistence::kOnce ? search.try_once(spread) : search.try_all_starts();
  }
  work += engine->work();
  return {.engine = std::move(engine),
          .outcome = search.best(),
          .work = work,
          .unbounded = search.unbounded()};
}

LindstromBatesSearch search_lindstrom_bates(const NonlinearModel& model,
                                            const VectorXd& start,
                                            const MixedEffectsOptions& options) {
  const Persistence persistence = options.is_brief ? Persistence::kOnce : Persistence::kUntilFound;
  LindstromBatesSearch best = climb_lindstrom_bates(model, start, options, persistence);
  const bool is_doubtful = !best.outcome.converged;
  std::vector<VectorXd> others = options.starts;
  std::erase_if(others, [&](const VectorXd& other) { return is_same_start(start, other); });
  if (!is_doubtful)
    std::erase_if(others,
                  [&](const VectorXd& other) { return has_same_curve(model, start, other); });
  for (const VectorXd& other : others) {
    LindstromBatesSearch found = climb_lindstrom_bates(model, other, options, persistence);
    const double unbounded = std::max(best.unbounded, found.unbounded);
    if (is_better(found.outcome, best.outcome)) best = std::move(found);
    best.unbounded = unbounded;
  }
  return best;
}

LindstromBatesEnd lindstrom_bates_from(const NonlinearModel& model,
                                       const MixedEffectsFit& start,
                                       const MixedEffectsOptions& options) {
  const PooledFit pooled = pooled_fit(model, start.estimate, options);
  LindstromBates engine(model, pooled, model.specification().variance, options);
  engine.set_tolerance(kTolerance);
  engine.set_passes(kPassesFromFit);
  const LindstromBatesOutcome outcome =
      run_from(engine, engine.start_at(start), Alternation::kInterleaved);
  LindstromBatesEnd end{.work = engine.work()};
  if (!outcome.is_valid) return end;
  const bool is_above =
      outcome.log_likelihood > least_likelihood(model.specification().variance, pooled);
  end.fit = engine.result(outcome);
  if (!is_above || engine.has_unbounded_range(outcome.state))
    end.fit->convergence.status = ConvergenceStatus::kMaximumNotReached;
  return end;
}

std::vector<MixedEffectsFit> higher_maxima(const NonlinearModel& model,
                                           const MixedEffectsFit& fit,
                                           const MixedEffectsOptions& options) {
  const PooledFit pooled = pooled_fit(model, fit.estimate, options);
  LindstromBates engine(model, pooled, model.specification().variance, options);
  engine.set_tolerance(kTolerance);
  engine.set_passes(kPassesFromFit);
  const LindstromBatesOutcome outcome =
      run_from(engine, engine.start_at(fit), Alternation::kInterleaved);
  std::vector<MixedEffectsFit> higher;
  for (const LindstromBatesState& state : engine.other_maxima(outcome)) {
    const LindstromBatesOutcome end = run_from(engine, state, Alternation::kInterleaved);
    if (end.is_valid) higher.push_back(engine.result(end));
  }
  return higher;
}

std::optional<MixedEffectsFit> refit_lindstrom_bates(const NonlinearModel& model,
                                                     const MixedEffectsFit& start,
                                                     const MixedEffectsOptions& options) {
  std::optional<MixedEffectsFit> fit = lindstrom_bates_from(model, start, options).fit;
  if (!fit || !fit->convergence.converged()) return std::nullopt;
  describe(model, *fit);
  judge(model, *fit, Rounds::kAlternations, options.reml);
  return fit;
}

MixedEffectsFit fit_lindstrom_bates(const NonlinearModel& model,
                                    const VectorXd& start,
                                    const MixedEffectsOptions& options) {
  if (start.size() != model.coefficient_count()) {
    throw UsageError(fmt::format(
        "the start has {} values for {} coefficients", start.size(), model.coefficient_count()));
  }
  MixedEffectsFit fit;
  Obstacle obstacle;
  bool is_valid = false;
  double unbounded = kNaN;
  {
    // The memory of the search is as large as the data, and not needed for the convergence test.
    const LindstromBatesSearch search = search_lindstrom_bates(model, start, options);
    is_valid = search.outcome.is_valid;
    unbounded = search.unbounded;
    if (model.specification().correlation) obstacle = search.outcome.obstacle;
    if (is_valid) fit = search.engine->result(search.outcome);
  }
  if (!is_valid) fit = failed(model, start, why_no_step(model, start));
  describe(model, fit);
  if (is_valid) judge(model, fit, Rounds::kAlternations, options.reml, obstacle);
  note_unbounded_range(unbounded, fit);
  return fit;
}

}  // namespace silvafit::fit
