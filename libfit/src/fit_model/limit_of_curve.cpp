// SPDX-License-Identifier: MIT
#include "fit_model/limit_of_curve.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "least_squares/least_squares_verdict.hpp"
#include "least_squares/variable_projection.hpp"
#include "mixed_effects/expected_information.hpp"
#include "model/coefficient_frame.hpp"
#include "model/held_coefficients.hpp"
#include "optimization/tolerances.hpp"
#include "silvafit/base/constants.hpp"
#include "verdict/thresholds.hpp"

namespace silvafit::fit {
namespace {

/// The covariance of the coefficients by the expected information of the population's curve.
MatrixXd covariance_at_population(const NonlinearModel& model, const FitResult& result) {
  const FittedModel& fit = result.fit;
  return expected_covariance(model,
                             fit,
                             model.extended(fit.estimate),
                             result.residual_sd,
                             frame_at(model, fit.estimate).beta);
}

/// Standard errors; infinite if a relative change of the coefficient moves the curve by rounding
/// errors only. These make the information singular, so that others are not known and given as 0.
VectorXd errors_of(const NonlinearModel& model,
                   const VectorXd& estimate,
                   const MatrixXd& expected) {
  VectorXd errors = expected.diagonal().cwiseSqrt();
  const auto [mean, jacobian] = model.curve_at(model.extended(estimate));
  for (Index j = 0; j < errors.size(); ++j) {
    const double effect = jacobian.col(j).norm() * std::abs(estimate[j]);
    if (effect <= Thresholds::kUnfelt * mean.norm()) {
      errors[j] = kInfinity;
    } else if (!std::isfinite(errors[j])) {
      errors[j] = 0.0;
    }
  }
  return errors;
}

/// Coefficients that the population's curve hardly determines, least determined first. Of a search
/// without a maximum a cause is known to exist, so that smaller errors make candidates, too.
std::vector<Index> candidates(const NonlinearModel& model,
                              const FitResult& result,
                              const MatrixXd& expected) {
  const FittedModel& fit = result.fit;
  const VectorXd errors = errors_of(model, fit.estimate, expected);
  const double weight = fit.convergence.converged() ? 1.0 : 10.0;
  std::vector<Index> found = undetermined(model, fit.estimate, weight * errors, result.residual_sd);
  std::ranges::stable_sort(found, std::ranges::greater(), [&](Index j) {
    return errors[j] / std::abs(fit.estimate[j]);
  });
  return found;
}

/// Whether the search ended somewhere, at a maximum or not, or where the likelihood has no
/// curvature in a direction; only then its end can be on the way to a limit.
bool has_end(const Convergence& convergence) {
  const auto is_nearly_flat = [](const Evidence& item) {
    return item.kind == Evidence::Kind::kHardlyIdentifiable;
  };
  return convergence.converged() ||
         (convergence.status == ConvergenceStatus::kNotIdentifiable &&
          std::ranges::any_of(convergence.evidence, is_nearly_flat)) ||
         convergence.status == ConvergenceStatus::kMaximumNotReached ||
         convergence.status == ConvergenceStatus::kIterationLimit;
}

bool are_within(const CoefficientBounds& bounds, const FittedModel& fit) {
  for (std::size_t j = 0; j < fit.coefficient_names.size(); ++j) {
    const auto found = bounds.find(fit.coefficient_names[j]);
    const double value = fit.estimate[static_cast<Index>(j)];
    if (found == bounds.end()) continue;
    if (!(value >= found->second.low && value <= found->second.high)) return false;
  }
  return true;
}

/// Whether the likelihood with the coefficient held far towards one side is as high as that of the
/// fit. Where the formula has no values so far away, nearer values are tried.
bool is_flat_towards(const FittedModel& fit,
                     Index coefficient,
                     double sign,
                     const HeldFit& held_fit,
                     const CoefficientBounds& bounds) {
  for (const double decades : {3.0, 2.0, 1.0, 0.3}) {
    const double value = fit.estimate[coefficient] * std::pow(10.0, sign * decades);
    const HeldValues held{{fit.coefficient_names[static_cast<std::size_t>(coefficient)], value}};
    for (const FittedModel* const nearby : {&fit, static_cast<const FittedModel*>(nullptr)}) {
      const FittedModel far = held_fit(held, nearby).fit;
      const bool is_as_high = far.log_likelihood >= fit.log_likelihood - kSameLikelihood;
      if (is_as_high && are_within(bounds, far)) return true;
      if (far.convergence.converged() && nearby == nullptr) return false;
    }
  }
  return false;
}

/// Whether the likelihood falls far less than the standard error of a coefficient says. On a long
/// ridge its Hessian is inaccurate, since it is no parabola within the steps of the differences.
bool has_understated_error(const FittedModel& fit,
                           const MatrixXd& expected,
                           const HeldFit& held_fit) {
  const VectorXd ratio = expected.diagonal().cwiseQuotient(fit.covariance.diagonal()).cwiseSqrt();
  Index widest = -1;
  for (Index j = 0; j < ratio.size(); ++j) {
    if (!(ratio[j] > Thresholds::kFar)) continue;
    if (has_effects(fit.specification, fit.coefficient_names[static_cast<std::size_t>(j)]))
      continue;
    if (widest < 0 || ratio[j] > ratio[widest]) widest = j;
  }
  if (widest < 0) return false;
  const double step = Thresholds::kErrors * std::sqrt(fit.covariance(widest, widest));
  return std::ranges::any_of(std::vector{step, -step}, [&](double change) {
    const HeldValues held{
        {fit.coefficient_names[static_cast<std::size_t>(widest)], fit.estimate[widest] + change}};
    double height = held_fit(held, &fit).fit.log_likelihood;
    // The search along the ridge from nearby may fail.
    if (!std::isfinite(height)) height = held_fit(held, nullptr).fit.log_likelihood;
    return height > fit.log_likelihood - Thresholds::kFlat;
  });
}

void state_expected_errors(const NonlinearModel& model,
                           const MatrixXd& expected,
                           FittedModel& fit) {
  const bool has_factor = !is_marginal(fit.method) && !fit.reml;
  fit.covariance = (has_factor ? likelihood_factor(model) : 1.0) * expected;
  fit.convergence.find({.kind = Finding::Kind::kExpectedErrors});
}

}  // namespace

void mark_limit(const NonlinearModel& model,
                const HeldFit& held_fit,
                FitResult& result,
                const CoefficientBounds& bounds) {
  FittedModel& fit = result.fit;
  const bool is_known = result.residual_sd.size() > 0 && result.residual_sd.allFinite();
  if (!has_end(fit.convergence) || !is_known) return;
  const MatrixXd expected = covariance_at_population(model, result);
  const std::vector<Index> loose = candidates(model, result, expected);
  const auto held = std::ranges::find_if(loose, [&](Index j) {
    return !has_effects(fit.specification, fit.coefficient_names[static_cast<std::size_t>(j)]);
  });
  const bool has_limit =
      held != loose.end() && (is_flat_towards(fit, *held, 1.0, held_fit, bounds) ||
                              is_flat_towards(fit, *held, -1.0, held_fit, bounds));
  if (!has_limit) {
    if (fit.convergence.converged() && expected.allFinite() &&
        has_understated_error(fit, expected, held_fit))
      state_expected_errors(model, expected, fit);
    return;
  }
  std::erase_if(fit.convergence.evidence, [](const Evidence& item) {
    return item.kind == Evidence::Kind::kHardlyIdentifiable;
  });
  fit.convergence.conclude(ConvergenceStatus::kNoMaximum,
                           {.kind = Finding::Kind::kLimitOfCurve, .names = names_of(model, loose)},
                           Evidence::Kind::kUnbounded);
  // The Hessian is not one at a maximum.
  fit.covariance.setConstant(kNaN);
}

std::map<std::string, double> start_beyond_infinity(const NonlinearModel& model,
                                                    const FittedModel& fit) {
  const bool is_unbounded = fit.convergence.status == ConvergenceStatus::kNoMaximum &&
                            fit.estimate.allFinite() &&
                            std::ranges::any_of(fit.convergence.evidence, [](const Evidence& item) {
                              return item.kind == Evidence::Kind::kUnbounded;
                            });
  if (!is_unbounded) return {};
  ProjectedModel projected(model);
  std::vector<std::pair<double, VectorXd>> curves;  // log sum of squares, coefficients
  double closest = kInfinity;
  std::vector<Index> unbounded;
  double largest = 1.0;
  for (Index j = 0; j < fit.estimate.size(); ++j) {
    const std::string& name = fit.coefficient_names[static_cast<std::size_t>(j)];
    if (!fit.convergence.has(Evidence::Kind::kUnbounded, name)) continue;
    unbounded.push_back(j);
    largest = std::max(largest, std::abs(fit.estimate[j]));
  }
  // A search may have gone on to any power of ten.
  for (double share = 1.0; share > 1e-15 / largest; share /= 10.0) {
    VectorXd here = fit.estimate;
    here(unbounded) *= -share;
    if (!projected.evaluate(projected.nonlinear_part(here))) continue;
    curves.emplace_back(std::log(projected.residuals().squaredNorm()), projected.coefficients());
    closest = std::min(closest, curves.back().first);
  }
  const double farthest = closest + 4.0 * 4.0 / static_cast<double>(model.observations());
  std::erase_if(curves, [&](const auto& curve) { return !(curve.first <= farthest); });
  std::map<std::string, double> start;
  if (curves.empty()) return start;
  for (std::size_t j = 0; j < fit.coefficient_names.size(); ++j) {
    start[fit.coefficient_names[j]] = curves.back().second[static_cast<Index>(j)];
  }
  return start;
}

}  // namespace silvafit::fit
