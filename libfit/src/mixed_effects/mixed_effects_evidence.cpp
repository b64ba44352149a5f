// SPDX-License-Identifier: MIT
#include "mixed_effects/mixed_effects_evidence.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
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
#include "model/simpler_model.hpp"
#include "model/symmetric_eigen.hpp"
#include "model/variance_weights.hpp"
#include "result/estimated_terms.hpp"
#include "result/group_coefficients.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/text.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  MatrixXd jacobian;
  model.evaluate(coefficients, mean, &jacobian, workspace);
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
  constexpr double kConfounded = 1e-12;
  return static_cast<int>((values.array() > kConfounded * values.maxCoeff()).count());
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

/// Advice if a search did not converge.
std::string advice(const NonlinearModel& model, const std::string& usual) {
  if (model.specification().random.empty()) {
    return "Use a simpler variance function or other start values; `method=ols` shows whether the "
           "curve itself fits the data.";
  }
  if (!has_single_observations(model)) return "Try " + usual + ".";
  const std::string& group = model.specification().random.back().group;
  return fmt::format(
      "Each group of {} has one observation, so random effects and residuals are hardly "
      "identifiable. Remove the random effects, or use groups with several observations.",
      group);
}

/// ", mostly in sd(b), and the evaluation limit is reached".
std::string obstacle_text(const Obstacle& obstacle) {
  std::string result;
  if (!obstacle.moving.empty()) result = ", mostly in " + obstacle.moving;
  if (!obstacle.text.empty()) result += ", and " + obstacle.text;
  return result;
}

/// Whether all methods have the same likelihood.
bool has_exact_linearization(const NonlinearModel& model) {
  const auto depends_on_mean = [](const VarianceFactor& factor) {
    return factor.column.empty() && kind_of(factor).reads_value();
  };
  return model.is_linear() &&
         std::ranges::none_of(model.specification().variance.factors, depends_on_mean);
}

std::string failure(const NonlinearModel& model,
                    const MixedEffectsFit& fit,
                    Rounds rounds,
                    const Obstacle& obstacle) {
  const ModelSpecification& specification = model.specification();
  const std::vector<std::string> kinks = model.random_kinks();
  if (obstacle.text == kNoClearMode && !kinks.empty()) {
    return fmt::format(
        "Not converged: {}; the formula has a kink in {}. Use `method=agq` with more points, such "
        "as `agq_points=15`, or {}.",
        kNoClearMode,
        fmt::join(kinks, ", "),
        simpler_model(specification));
  }
  if (obstacle.text == kNoClearMode) {
    return fmt::format("Not converged: {}. Use `method=focei`, or {}.",
                       kNoClearMode,
                       simpler_model(specification));
  }
  if (rounds == Rounds::kAlternations) {
    constexpr double kShown = 1e-12;
    const std::string by = distance(fit) > kShown
                               ? fmt::format(" by {:.2g} standard errors", distance(fit))
                               : std::string();
    return fmt::format(
        "Not converged after {}: the estimates still change{}{}. {}",
        counted(fit.convergence.iterations, "alternation", "alternations"),
        by,
        obstacle_text(obstacle),
        advice(model,
               !kinks.empty() ? fmt::format("the method agq, since the formula has a kink in {}",
                                            fmt::join(kinks, ", "))
               : specification.correlation ? simpler_model(specification)
               : has_exact_linearization(model)
                   ? simpler_model(specification) + "; another method has the same likelihood"
                   : "the method focei or laplace, or " + simpler_model(specification)));
  }
  const std::string where =
      std::isfinite(fit.convergence.newton_decrement)
          ? fmt::format("the maximum is still {:.2g} standard errors away", distance(fit))
          : "the best point found is not a maximum of the likelihood";
  return fmt::format("Not converged after {} evaluations of the likelihood: {}{}. {}",
                     fit.convergence.iterations,
                     where,
                     obstacle_text(obstacle),
                     advice(model, simpler_model(specification)));
}

std::string success(const MixedEffectsFit& fit, Rounds rounds) {
  constexpr double kResolved = 1e-9;
  const double step = std::max(kResolved, distance(fit));
  if (rounds == Rounds::kAlternations) {
    return fmt::format(
        "Converged after {}: further iterations change no estimate by more than {:.0e} standard "
        "errors.",
        counted(fit.convergence.iterations, "alternation", "alternations"),
        step);
  }
  return fmt::format(
      "Converged after {} evaluations: the maximum is within {:.0e} standard errors of the "
      "estimates.",
      fit.convergence.iterations,
      step);
}

/// "a", "a and b", "a, b and c".
std::string in_words(const std::vector<std::string>& names) {
  if (names.size() < 2) return fmt::format("{}", fmt::join(names, ""));
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

/// The reason for confounded variance components, and the remedy, as far as the groups show it.
/// \param is_of_effects  standard deviations or correlations are among them
std::string remedy(const NonlinearModel& model, bool is_of_effects) {
  const ModelSpecification& specification = model.specification();
  if (is_of_effects && has_single_observations(model)) {
    return fmt::format(
        ": each group of {} has one observation. Remove the random effects by {}, or use groups "
        "with several observations.",
        specification.random.back().group,
        specification.random.back().group);
  }
  if (is_of_effects && specification.random.size() > 1 && model.crossed() == nullptr &&
      model.group_count() == model.cluster_count()) {
    return fmt::format(": each group of {} has one of {}. Remove one of the two groupings.",
                       specification.random.front().group,
                       specification.random.back().group);
  }
  return is_of_effects ? ". Remove one of them, or one of their random effects."
                       : ". Remove one of them.";
}

std::string divergence(const std::string& names) {
  return fmt::format(
      "Not converged: the search diverged to values at which the mean hardly depends on {}. Use "
      "other start values, fewer random effects, or a curve with fewer coefficients.",
      names);
}

std::string confounding(const NonlinearModel& model,
                        const MixedEffectsFit& fit,
                        const Confounded& confounded) {
  const std::string names = listed(model, confounded.coefficients);
  if (confounded.coefficients.size() == 1) {
    return fmt::format(
        "Not converged: {} is not identifiable: the mean does not depend on it. Remove it.", names);
  }
  if (!names.empty()) {
    return fmt::format(
        "Not converged: {} are not identifiable: their effects on the mean are linearly dependent. "
        "Remove one of them.",
        names);
  }
  const std::vector<std::string>& variances = confounded.variances.names;
  if (variances.size() == 1) {
    return fmt::format(
        "Not converged: {} is not identifiable: the likelihood does not depend on it. Remove it.",
        variances.front());
  }
  if (!variances.empty()) {
    return fmt::format(
        "Not converged: {} are not identifiable: their effects on the likelihood are linearly "
        "dependent{}",
        in_words(variances),
        remedy(model, confounded.variances.has_effects));
  }
  if (fit.convergence.rank < fit.estimate.size()) {
    if (confounded.nearly.size() > 1) {
      return fmt::format(
          "Not converged: {} are hardly identifiable: their effects on the mean are nearly "
          "linearly "
          "dependent. Remove one of them.",
          listed(model, confounded.nearly));
    }
    return "Not converged: the coefficients are not identifiable: their estimates are linearly "
           "dependent. Remove a covariate or a parameter.";
  }
  return {};
}

/// Adds the parameters that are named in a message on confounding.
void add_confounding(const NonlinearModel& model,
                     const Confounded& confounded,
                     Convergence& convergence) {
  using enum Evidence::Kind;
  if (!confounded.coefficients.empty()) {
    convergence.add(kNotIdentifiable, names_of(model, confounded.coefficients));
  } else if (!confounded.variances.names.empty()) {
    convergence.add(kNotIdentifiable, confounded.variances.names);
  } else {
    convergence.add(kHardlyIdentifiable, names_of(model, confounded.nearly));
  }
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
  const std::string verdict = is_far_off ? divergence(listed(model, confounded.coefficients))
                                         : confounding(model, fit, confounded);
  if (verdict.empty()) return false;
  convergence.status =
      is_far_off ? ConvergenceStatus::kDiverged : ConvergenceStatus::kNotIdentifiable;
  convergence.verdict = verdict;
  add_confounding(model, confounded, convergence);
  return true;
}

/// Coefficients that the data hardly determine. Their standard errors become those of the expected
/// information, because the other Hessian is inaccurate there (see expected_covariance()).
std::vector<Index> find_undetermined(const NonlinearModel& model,
                                     const PopulationSlopes& slopes,
                                     MixedEffectsFit& fit) {
  if (fit.residual_sd.size() == 0 || !fit.residual_sd.allFinite()) return {};
  MatrixXd covariance = expected_covariance(
      model, fit, group_coefficients(model, fit), fit.residual_sd, slopes.frame.beta);
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
  convergence.status = ConvergenceStatus::kNoMaximum;
  convergence.add(Evidence::Kind::kUnbounded, names_of(model, loose));
  convergence.verdict =
      "Not converged: the log-likelihood keeps increasing, ever more slowly, while " +
      unbounded_text(model, loose);
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
      convergence.status = ConvergenceStatus::kNoMaximum;
      convergence.evidence.push_back({.kind = Evidence::Kind::kUnbounded, .term = name});
      convergence.verdict = fmt::format(
          "Not converged: the log-likelihood keeps increasing, ever more slowly, while {} of {} "
          "grows without bound: only the observations with {} {} have another variance. Use a "
          "power, or a stratum for these observations.",
          name,
          factor.factor.text(),
          column.empty() ? "a fitted value of" : column + " =",
          fmt::format("{:.6g}", use.only_at));
    }
  }
}

/// Records that the likelihood has no maximum.
void note_degeneracy(Degeneracy found, MixedEffectsFit& fit) {
  if (found.text.empty()) return;
  Convergence& convergence = fit.convergence;
  convergence.status = found.status;
  convergence.verdict = "Not converged: " + found.text;
  std::ranges::move(found.evidence, std::back_inserter(convergence.evidence));
}

/// The message and the evidence of a converged fit.
std::string success_verdict(const NonlinearModel& model,
                            const std::vector<Index>& loose,
                            Rounds rounds,
                            MixedEffectsFit& fit) {
  Convergence& convergence = fit.convergence;
  convergence.add(Evidence::Kind::kHardlyIdentifiable, names_of(model, loose));
  std::string verdict = loose.empty() ? success(fit, rounds) : undetermined_text(model, loose);
  if (convergence.has_boundary()) {
    verdict += fmt::format(" Boundary (singular) fit: {}. A simpler structure fits equally well.",
                           fmt::join(convergence.boundary(), "; "));
  }
  for (const VarianceFactorEstimate& factor : fit.variance.factors) {
    const Index few = few_with_power(factor, variable_of(model, fit, factor));
    if (few == 0) continue;
    convergence.evidence.push_back(
        {.kind = Evidence::Kind::kPowerOfFew, .term = "delta", .value = static_cast<double>(few)});
    verdict += fmt::format(
        " The power of the variance matters for {} only: with an exponent of {:.3g} the variance "
        "of all others is constant.",
        counted(few, "observation", "observations"),
        factor.delta[0]);
  }
  if (fit.floored_variances > 0) {
    convergence.evidence.push_back({.kind = Evidence::Kind::kFlooredValues,
                                    .term = "fitted values",
                                    .value = static_cast<double>(fit.floored_variances)});
    verdict +=
        fmt::format(" {} near zero for a power variance and set to a lower limit{}.",
                    counted(fit.floored_variances, "fitted value is too", "fitted values are too"),
                    has_constant(fit.variance) ? "" : "; constant-plus-power may fit better");
  }
  return verdict;
}

}  // namespace

bool has_diverged(const NonlinearModel& model, const MixedEffectsFit& fit) {
  if (!fit.estimate.allFinite() || frame_at(model, fit.estimate).has_full_rank) return false;
  return !confounded_at(model, fit.estimate).empty() && is_identifiable(model);
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
  fit.convergence.rank = information_rank(slopes.frame, fit);
  const std::vector<Index> loose = find_undetermined(model, slopes, fit);
  name_boundary(model, slopes, fit);
  if (fit.convergence.converged()) {
    fit.convergence.verdict = success_verdict(model, loose, rounds, fit);
  } else {
    fit.convergence.status = obstacle.status;
    fit.convergence.verdict = failure(model, fit, rounds, obstacle);
    if (!obstacle.moving.empty()) {
      fit.convergence.add(Evidence::Kind::kMoving, {obstacle.moving});
    }
    note_unbounded(model, loose, fit);
  }
  note_unbounded_powers(model, fit);
  Degeneracy degenerate = degeneracy(model, slopes.frame, fit);
  const bool is_confounded = note_confounding(
      model, slopes.frame.has_full_rank, is_restricted, obstacle, degenerate.is_exact, fit);
  if (!is_confounded) note_degeneracy(std::move(degenerate), fit);
}

}  // namespace silvafit::fit
