// SPDX-License-Identifier: MIT
#include "mixed_effects/mixed_effects_evidence.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "least_squares/jacobian_factors.hpp"
#include "least_squares/least_squares_verdict.hpp"
#include "mixed_effects/boundary.hpp"
#include "mixed_effects/confounded_variances.hpp"
#include "mixed_effects/degenerate_fit.hpp"
#include "mixed_effects/degrees_of_freedom.hpp"
#include "mixed_effects/expected_information.hpp"
#include "model/coefficient_frame.hpp"
#include "model/correlated_rows.hpp"
#include "model/symmetric_eigen.hpp"
#include "model/variance_weights.hpp"
#include "optimization/tolerances.hpp"
#include "result/group_coefficients.hpp"
#include "silvafit/base/constants.hpp"
#include "variance/variance_kind.hpp"
#include "verdict/reducible.hpp"
#include "verdict/thresholds.hpp"

namespace silvafit::fit {
namespace {

bool has_constant(const VarianceEstimate& variance) {
  return std::ranges::any_of(variance.factors, [](const VarianceFactorEstimate& factor) {
    return kind_of(factor.factor).has_constant();
  });
}

/// Parameters that are not identifiable at a maximum.
struct Confounded {
  std::vector<Index> coefficients{};
  std::vector<Index> nearly{};  ///< those among them that are nearly not identifiable
  ConfoundedVariances variances{};
};

/// Coefficients that are not identifiable from the mean.
std::vector<Index> confounded_at(const NonlinearModel& model,
                                 const MatrixXd& coefficients,
                                 double tolerance = JacobianFactors::kRankTolerance) {
  MatrixXd jacobian = model.curve_at(coefficients).jacobian;
  jacobian.conservativeResize(Eigen::NoChange, model.coefficient_count());
  // All coefficients are held.
  if (jacobian.cols() == 0 || !jacobian.allFinite()) return {};
  return JacobianFactors(jacobian, tolerance).confounded();
}

Confounded confounded_parameters(const NonlinearModel& model,
                                 const MixedEffectsFit& fit,
                                 bool has_full_rank,
                                 bool is_restricted) {
  const MatrixXd coefficients = group_coefficients(model, fit);
  // The groups may identify coefficients that the population curve does not identify.
  Confounded result{.coefficients = has_full_rank ? confounded_at(model, coefficients)
                                                  : confounded_at(model, fit.estimate)};
  result.nearly = confounded_at(model, fit.estimate, JacobianFactors::kNearTolerance);
  const VarianceModel variance(model.specification().variance, VarianceData::of(model));
  result.variances = confounded_variances(model,
                                          variance,
                                          {.coefficients = coefficients,
                                           .effects = covariances_of(fit),
                                           .variance = variance.parameters(fit.variance),
                                           .fitted = fit.fitted_conditional,
                                           .residual_sd = fit.residual_sd,
                                           .is_restricted = is_restricted});
  return result;
}

/// Number of identifiable coefficients, from the information matrix at the optimum, in
/// coordinates that do not depend on the origin of a covariate.
int information_rank(const CoefficientFrame& frame, const MixedEffectsFit& fit) {
  if (fit.covariance.size() == 0 || !fit.covariance.allFinite()) return 0;
  const Eigen::PartialPivLU<MatrixXd> inverse(frame.beta);
  const MatrixXd half = inverse.solve(fit.covariance);
  const MatrixXd covariance = inverse.solve(half.transpose());
  const VectorXd deviations = covariance.diagonal().cwiseSqrt();
  if (!deviations.allFinite() || deviations.minCoeff() <= 0.0) return 0;
  const MatrixXd correlation =
      deviations.cwiseInverse().asDiagonal() * covariance * deviations.cwiseInverse().asDiagonal();
  const VectorXd values = symmetric_eigen(correlation).values;
  return static_cast<int>((values.array() > Thresholds::kConfounded * values.maxCoeff()).count());
}

/// Distance of the fit from the optimum, in standard errors.
double distance(const MixedEffectsFit& fit) {
  return std::sqrt(std::max(0.0, fit.convergence.newton_decrement));
}

/// Whether random effects are confounded with the residual because of single observations.
bool has_single_observations(const NonlinearModel& model) {
  return model.term_count() > 0 &&
         model.group_count(model.term_count() - 1) == model.observations();
}

/// Whether all methods have the same likelihood.
bool has_exact_linearization(const NonlinearModel& model) {
  const auto depends_on_mean = [](const VarianceFactor& factor) {
    return factor.column.empty() && kind_of(factor).reads_value();
  };
  return model.is_linear() &&
         std::ranges::none_of(model.specification().variance.factors, depends_on_mean);
}

/// The advice if a search did not converge.
Finding advice(const NonlinearModel& model, Rounds rounds) {
  const ModelSpecification& specification = model.specification();
  if (specification.random.empty()) return {.kind = Finding::Kind::kTryLeastSquares};
  if (has_single_observations(model)) {
    return {.kind = Finding::Kind::kSingleObservations,
            .names = {specification.random.back().group}};
  }
  Finding result{.kind = Finding::Kind::kTrySimplerOnly, .reducible = reducible(specification)};
  if (rounds == Rounds::kEvaluations) return result;
  if (std::vector<std::string> kinks = model.random_kinks(); !kinks.empty()) {
    return {.kind = Finding::Kind::kTryKinks, .names = std::move(kinks)};
  }
  if (!specification.correlation) {
    result.kind = has_exact_linearization(model) ? Finding::Kind::kTryOtherMethod
                                                 : Finding::Kind::kTrySimpler;
  }
  return result;
}

/// Records why a search has ended without an optimum.
void note_failure(const NonlinearModel& model,
                  Rounds rounds,
                  const Obstacle& obstacle,
                  MixedEffectsFit& fit) {
  using enum Finding::Kind;
  Convergence& convergence = fit.convergence;
  if (obstacle.cause == kNoClearMode) {
    std::vector<std::string> kinks = model.random_kinks();
    convergence.conclude(obstacle.status, {.kind = kNoClearMode});
    convergence.find({.kind = kinks.empty() ? kUseFocei : kUseAgq,
                      .names = std::move(kinks),
                      .reducible = reducible(model.specification())});
  } else {
    const bool is_alternating = rounds == Rounds::kAlternations;
    constexpr double kShown = 1e-12;
    const bool has_distance =
        is_alternating ? distance(fit) > kShown : std::isfinite(convergence.newton_decrement);
    convergence.conclude(
        obstacle.status,
        {.kind = is_alternating ? (has_distance ? kStillChangingBy : kStillChanging)
                                : (has_distance ? kMaximumAway : kNoMaximumFound),
         .values = {static_cast<double>(convergence.iterations), distance(fit)}});
    if (!obstacle.moving.empty()) {
      convergence.find({.kind = kMovingMost, .names = {obstacle.moving}});
    }
    const bool is_mixed = model.term_count() > 0;
    if (obstacle.cause && (is_mixed || *obstacle.cause != kSquaresDiverge)) {
      convergence.find({.kind = *obstacle.cause});
    }
    convergence.find(advice(model, rounds));
  }
  if (!obstacle.moving.empty()) convergence.add(Evidence::Kind::kMoving, {obstacle.moving});
}

/// The reason for confounded variance components, and the remedy, as far as the groups show it.
/// \param is_of_effects  standard deviations or correlations are among them
Finding remedy(const NonlinearModel& model, bool is_of_effects) {
  const std::vector<RandomEffects>& terms = model.specification().random;
  if (is_of_effects && has_single_observations(model)) {
    return {.kind = Finding::Kind::kSingleObservationsOf, .names = {terms.back().group}};
  }
  if (is_of_effects && terms.size() > 1 && model.crossed() == nullptr &&
      model.group_count() == model.cluster_count()) {
    return {.kind = Finding::Kind::kEqualGroupings,
            .names = {terms.front().group, terms.back().group}};
  }
  return {.kind = is_of_effects ? Finding::Kind::kRemoveOneEffect : Finding::Kind::kRemoveOne};
}

/// Records what is not identifiable; false if everything is.
bool conclude_confounding(const NonlinearModel& model,
                          const Confounded& confounded,
                          MixedEffectsFit& fit) {
  using enum Finding::Kind;
  Convergence& convergence = fit.convergence;
  const auto conclude = [&](Finding reason) {
    const bool is_hardly = reason.kind == kNearlyConfounded || reason.kind == kDependentEstimates;
    convergence.conclude(
        ConvergenceStatus::kNotIdentifiable,
        std::move(reason),
        is_hardly ? Evidence::Kind::kHardlyIdentifiable : Evidence::Kind::kNotIdentifiable);
    return true;
  };
  if (!confounded.coefficients.empty()) {
    return conclude(confounding(model, confounded.coefficients));
  }
  if (!confounded.variances.names.empty()) {
    const std::vector<std::string>& names = confounded.variances.names;
    const bool is_correlation = names.size() == 1 && names.front().starts_with("cor(");
    conclude({.kind = is_correlation ? kUnseenCorrelation : kConfoundedVariances, .names = names});
    if (confounded.variances.names.size() > 1) {
      convergence.find(remedy(model, confounded.variances.has_effects));
    }
    return true;
  }
  if (convergence.rank >= fit.estimate.size()) return false;
  return conclude({.kind = confounded.nearly.size() > 1 ? kNearlyConfounded : kDependentEstimates,
                   .names = names_of(model, confounded.nearly)});
}

/// Records parameters that are not identifiable; false if there are none. For a fit that has not
/// converged, only coefficients that are not identifiable from the mean at its end are recorded.
bool note_confounding(const NonlinearModel& model,
                      bool has_full_rank,
                      bool is_restricted,
                      const Obstacle& obstacle,
                      bool is_exact,
                      MixedEffectsFit& fit) {
  Convergence& convergence = fit.convergence;
  if (!convergence.converged() && has_full_rank) return false;
  Confounded confounded = confounded_parameters(model, fit, has_full_rank, is_restricted);
  // If a search has diverged, the mean does not depend on some coefficients only there.
  const bool is_far_off = !confounded.coefficients.empty() && is_identifiable(model);
  // With a residual variance of zero identifiability cannot be tested.
  if (is_exact && (confounded.coefficients.empty() || is_far_off)) return false;
  if (!convergence.converged()) {
    const bool is_explained =
        is_far_off && obstacle.status == ConvergenceStatus::kInvalidApproximation;
    if (confounded.coefficients.empty() || is_explained) return false;
    confounded.variances = {};
  }
  for (const Index j : confounded.coefficients) {
    fit.covariance.row(j).setConstant(kNaN);
    fit.covariance.col(j).setConstant(kNaN);
  }
  if (!confounded.coefficients.empty()) {
    convergence.rank = std::min(convergence.rank, static_cast<int>(fit.estimate.size()) - 1);
  }
  convergence.rank = std::max(0, convergence.rank - confounded.variances.directions);
  if (!is_far_off) return conclude_confounding(model, confounded, fit);
  convergence.conclude(
      ConvergenceStatus::kDiverged,
      {.kind = Finding::Kind::kDivergedAway, .names = names_of(model, confounded.coefficients)},
      Evidence::Kind::kNotIdentifiable);
  return true;
}

/// Coefficients that the data hardly determine. Their standard errors become those of the expected
/// information, because the other Hessian is inaccurate there (see expected_covariance()).
/// \param has_factor  whether covariances have nlme's factor N / (N - p)
std::vector<Index> find_undetermined(const NonlinearModel& model,
                                     const PopulationSlopes& slopes,
                                     bool has_factor,
                                     MixedEffectsFit& fit) {
  if (fit.residual_sd.size() == 0 || !fit.residual_sd.allFinite()) return {};
  const auto& correlation = fit.variance.correlation;
  if (correlation && least_variance(*correlation) < Thresholds::kDependent) return {};
  MatrixXd covariance = expected_covariance(
      model, fit, group_coefficients(model, fit), fit.residual_sd, slopes.frame.beta);
  if (has_factor) covariance *= likelihood_factor(model);
  std::vector<Index> loose =
      undetermined(model, fit.estimate, covariance.diagonal().cwiseSqrt(), fit.residual_sd);
  // Coefficients that are not identifiable have no expected covariance.
  if (!loose.empty() && covariance.allFinite()) fit.covariance = std::move(covariance);
  return loose;
}

/// A search that goes on to coefficients which the data hardly determine has no maximum to reach.
void note_unbounded(const NonlinearModel& model,
                    const std::vector<Index>& loose,
                    MixedEffectsFit& fit) {
  Convergence& convergence = fit.convergence;
  if (loose.empty() || convergence.status == ConvergenceStatus::kInvalidApproximation) return;
  convergence.conclude(
      ConvergenceStatus::kNoMaximum,
      {.kind = Finding::Kind::kLikelihoodKeepsRising, .names = names_of(model, loose)},
      Evidence::Kind::kUnbounded);
}

/// Records exponents of the variance function that are not determined: with one that is larger
/// without bound, the same few observations have a variance of their own.
void note_unbounded_powers(const NonlinearModel& model, MixedEffectsFit& fit) {
  Convergence& convergence = fit.convergence;
  for (const VarianceFactorEstimate& factor : fit.variance.factors) {
    if (factor.factor.delta) continue;
    for (const PowerUse& use : power_uses(model, factor, variable_of(model, fit, factor))) {
      if (std::isnan(use.only_at)) continue;
      const std::string name = use.stratum.empty() ? "delta" : "delta of " + use.stratum;
      const std::string& column = factor.factor.column;
      convergence.evidence.push_back({.kind = Evidence::Kind::kUnbounded, .term = name});
      convergence.conclude(ConvergenceStatus::kNoMaximum,
                           {.kind = Finding::Kind::kUnboundedPower,
                            .names = {name,
                                      factor.factor.text(),
                                      column.empty() ? "a fitted value of" : column + " ="},
                            .values = {use.only_at}});
    }
  }
}

/// Records that the curve passes through all observations for which the power is 0, such as those
/// with the response and the fitted value 0: the smaller the constant, the higher the likelihood.
void note_vanishing_constants(const NonlinearModel& model, MixedEffectsFit& fit) {
  for (const VarianceFactorEstimate& factor : fit.variance.factors) {
    const bool is_free = kind_of(factor.factor).has_constant() && !factor.factor.constant;
    if (!is_free || !(factor.delta.minCoeff() > 0.0)) continue;
    const VectorXd v = variable_of(model, fit, factor);
    const bool has_strata = factor.constant.size() > 1;
    Eigen::ArrayXd zeros = Eigen::ArrayXd::Zero(factor.constant.size());
    Eigen::ArrayXd exact = zeros;
    for (Index i = 0; i < v.size(); ++i) {
      if (v[i] != 0.0) continue;
      const Index s =
          has_strata ? model.strata(factor.factor.stratum).of_rows[static_cast<std::size_t>(i)] : 0;
      zeros[s] += 1.0;
      if (model.response()[i] == fit.fitted_conditional[i]) exact[s] += 1.0;
    }
    const double vanishing = ((zeros > 0.0) && (exact == zeros)).select(zeros, 0.0).sum();
    if (vanishing == 0.0) continue;
    fit.convergence.conclude(ConvergenceStatus::kNoMaximum,
                             {.kind = Finding::Kind::kVanishingConstant,
                              .names = {factor.factor.text()},
                              .values = {vanishing}});
  }
}

void note_strata_without_freedom(const NonlinearModel& model, MixedEffectsFit& fit) {
  Convergence& convergence = fit.convergence;
  const bool is_search_lost = convergence.status == ConvergenceStatus::kMaximumNotReached;
  std::vector<std::string> strata = strata_without_freedom(
      model, fit, is_search_lost ? PassingEffects::kAll : PassingEffects::kSome);
  if (strata.empty()) return;
  if (is_search_lost) {
    convergence.conclude(ConvergenceStatus::kNoMaximum,
                         {.kind = Finding::Kind::kVanishingStratum, .names = std::move(strata)});
  } else {
    convergence.find({.kind = Finding::Kind::kStratumOfFew, .names = std::move(strata)});
  }
}

/// Records that the likelihood has no maximum.
void note_degeneracy(Degeneracy found, MixedEffectsFit& fit) {
  if (!found.reason) return;
  fit.convergence.conclude(found.status, *std::move(found.reason));
  std::ranges::move(found.evidence, std::back_inserter(fit.convergence.evidence));
}

/// The findings of a converged fit.
/// \param ends  of name_boundary()
void note_success(const NonlinearModel& model,
                  const std::vector<Index>& loose,
                  Rounds rounds,
                  const std::vector<std::string>& ends,
                  MixedEffectsFit& fit) {
  using enum Finding::Kind;
  Convergence& convergence = fit.convergence;
  convergence.add(Evidence::Kind::kHardlyIdentifiable, names_of(model, loose));
  if (loose.empty()) {
    constexpr double kResolved = 1e-9;
    convergence.find(
        {.kind = rounds == Rounds::kAlternations ? kSettledAlternations : kSettledEvaluations,
         .values = {static_cast<double>(convergence.iterations),
                    std::max(kResolved, distance(fit))}});
  } else {
    convergence.find({.kind = kPoorlyDetermined, .names = names_of(model, loose)});
  }
  convergence.find_kinks();
  std::vector<std::string> simpler = convergence.boundary();
  for (const std::string& end : ends) std::erase(simpler, end);
  if (!simpler.empty()) convergence.find({.kind = kSingular, .names = std::move(simpler)});
  if (!ends.empty()) convergence.find({.kind = kCorrelationEnd, .names = ends});
  const std::vector<std::string> exact = strata_without_residuals(model, fit);
  for (const std::string& stratum : exact) {
    convergence.add_boundary({.term = "sd of " + stratum, .value = 0.0});
  }
  if (!exact.empty()) convergence.find({.kind = kExactStratum, .names = exact});
  for (const VarianceFactorEstimate& factor : fit.variance.factors) {
    for (const PowerUse& use : power_uses(model, factor, variable_of(model, fit, factor))) {
      if (use.few == 0) continue;
      const std::string of = use.stratum.empty() ? "" : " of " + use.stratum;
      const auto few = static_cast<double>(use.few);
      convergence.evidence.push_back(
          {.kind = Evidence::Kind::kPowerOfFew, .term = "delta" + of, .value = few});
      convergence.find({.kind = kPowerOfFew, .names = {of}, .values = {few, use.delta}});
    }
  }
  if (fit.floored_variances > 0) {
    const auto floored = static_cast<double>(fit.floored_variances);
    convergence.evidence.push_back(
        {.kind = Evidence::Kind::kFlooredValues, .term = "fitted values", .value = floored});
    convergence.find(
        {.kind = has_constant(fit.variance) ? kFloored : kFlooredPower, .values = {floored}});
  }
}

}  // namespace

bool has_diverged(const NonlinearModel& model, const MixedEffectsFit& fit) {
  if (!fit.estimate.allFinite() || frame_at(model, fit.estimate).has_full_rank) return false;
  return !confounded_at(model, fit.estimate).empty() && is_identifiable(model);
}

bool has_unbounded_range(const NonlinearModel& model, const MixedEffectsFit& fit) {
  const auto& correlation = fit.variance.correlation;
  if (!correlation || !correlation->values.allFinite()) return false;
  const std::shared_ptr<const CorrelatedRows> rows = CorrelatedRows::of(model);
  const CorrelationStructure& structure = rows->structure();
  return structure.has_unbounded_range(structure.unconstrained(correlation->values));
}

bool has_unbounded_power(const NonlinearModel& model, const MixedEffectsFit& fit) {
  return std::ranges::any_of(fit.variance.factors, [&](const VarianceFactorEstimate& factor) {
    if (factor.factor.delta || !kind_of(factor.factor).has_constant()) return false;
    return std::ranges::any_of(power_uses(model, factor, variable_of(model, fit, factor)),
                               [](const PowerUse& use) { return !std::isnan(use.only_at); });
  });
}

double compared(double log_likelihood, bool is_unbounded) {
  return is_unbounded ? log_likelihood - kDoubtful : log_likelihood;
}

void note_unbounded_range(double log_likelihood, MixedEffectsFit& fit) {
  if (!fit.convergence.converged() || !(log_likelihood > fit.log_likelihood + kHigher)) return;
  fit.convergence.find(
      {.kind = Finding::Kind::kRangeDoubt, .values = {log_likelihood, fit.log_likelihood}});
}

void describe(const NonlinearModel& model, MixedEffectsFit& fit) {
  fit.coefficient_names = model.coefficient_names();
  name_terms(model, fit);
  FixedFreedom freedom = fixed_freedom_at(model, fit.estimate);
  fit.degrees_of_freedom = std::move(freedom.of_tests);
  fit.coefficients_between = std::move(freedom.coefficients_between);
}

void judge(const NonlinearModel& model,
           MixedEffectsFit& fit,
           Rounds rounds,
           bool is_restricted,
           const Obstacle& obstacle) {
  const PopulationSlopes slopes = population_slopes(model, fit);
  // A covariance with unknown parts comes with its rank.
  if (!fit.covariance.array().isNaN().any() || fit.convergence.rank == 0)
    fit.convergence.rank = information_rank(slopes.frame, fit);
  const bool has_factor = rounds == Rounds::kAlternations && !is_restricted;
  const std::vector<Index> loose = find_undetermined(model, slopes, has_factor, fit);
  const std::vector<std::string> ends = name_boundary(model, slopes, fit);
  if (has_unbounded_range(model, fit)) {
    fit.convergence.conclude(ConvergenceStatus::kNoMaximum,
                             {.kind = Finding::Kind::kRangeUnbounded});
  } else if (fit.convergence.converged()) {
    note_success(model, loose, rounds, ends, fit);
  } else {
    note_failure(model, rounds, obstacle, fit);
    note_unbounded(model, loose, fit);
  }
  note_unbounded_powers(model, fit);
  note_vanishing_constants(model, fit);
  Degeneracy degenerate = degeneracy(model, slopes.frame, fit);
  const bool is_confounded = note_confounding(
      model, slopes.frame.has_full_rank, is_restricted, obstacle, degenerate.is_exact, fit);
  if (!is_confounded) note_degeneracy(std::move(degenerate), fit);
  if (!is_restricted) note_strata_without_freedom(model, fit);
  if (!fit.convergence.converged() && rounds == Rounds::kAlternations &&
      !model.fixed_kinks().empty()) {
    const bool is_mixed = !model.specification().random.empty();
    fit.convergence.find({.kind = is_mixed ? Finding::Kind::kKinkUnsettled
                                           : Finding::Kind::kKinkUnsettledWithoutEffects,
                          .names = model.fixed_kinks()});
  }
}

}  // namespace silvafit::fit
