// SPDX-License-Identifier: MIT
#include "least_squares/least_squares_verdict.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "least_squares/jacobian_factors.hpp"
#include "least_squares/variable_projection.hpp"
#include "optimization/candidate_points.hpp"
#include "silvafit/base/constants.hpp"
#include "verdict/thresholds.hpp"

namespace silvafit::fit {
namespace {

/// The change of the mean, as a length over all observations in units of each, when a coefficient
/// becomes zero and those adapt in which the mean is linear together with it; infinite if it is not
/// defined there. A small coefficient of a linear model is not felt; the rate k of
/// a*(1 - exp(-k*x)) is, however small, since no a gives the curve without it.
double change_without(const NonlinearModel& model,
                      const VectorXd& coefficients,
                      Index coefficient,
                      const VectorXd& units) {
  VectorXd without = coefficients;
  without[coefficient] = 0.0;
  auto [mean_without, others] = model.curve_at(without);
  const VectorXd change = (model.mean_at(coefficients) - mean_without).cwiseQuotient(units);
  const bool is_linear = model.is_bilinear(coefficient, coefficient);
  std::vector<Index> adapting;
  for (Index j = 0; is_linear && j < coefficients.size(); ++j) {
    const bool are_linear = model.is_bilinear(j, j) && model.is_bilinear(j, coefficient);
    if (j != coefficient && are_linear) adapting.push_back(j);
  }
  others = (units.cwiseInverse().asDiagonal() * others(Eigen::all, adapting)).eval();
  if (!change.allFinite() || !others.allFinite()) return kInfinity;
  if (adapting.empty()) return change.norm();
  const VectorXd lengths = others.colwise().norm();
  others *= (lengths.array() > 0.0).select(lengths.cwiseInverse(), 0.0).asDiagonal();
  return (change - others * others.colPivHouseholderQr().solve(change)).norm();
}

/// Coefficients so large that small changes do not affect the mean, although the mean depends on
/// them: they approach a limit that the formula has at infinity only.
std::vector<Index> saturated(const NonlinearModel& model, const NewtonPoint& point) {
  const MatrixXd jacobian = model.curve_at(point.coefficients).jacobian;
  std::vector<Index> result;
  for (Index j = 0; j < jacobian.cols(); ++j) {
    const double effect = jacobian.col(j).norm() * std::abs(point.coefficients[j]);
    const bool is_unfelt = effect <= Thresholds::kUnfelt * point.mean.norm();
    const VectorXd unit = VectorXd::Ones(point.mean.size());
    if (is_unfelt && change_without(model, point.coefficients, j, unit) >
                         Thresholds::kFeltWithout * point.mean.norm()) {
      result.push_back(j);
    }
  }
  return result;
}

}  // namespace

std::vector<std::string> names_of(const NonlinearModel& model,
                                  const std::vector<Index>& coefficients) {
  std::vector<std::string> result;
  result.reserve(coefficients.size());
  for (const Index j : coefficients) {
    result.push_back(model.coefficient_names()[static_cast<std::size_t>(j)]);
  }
  return result;
}

Finding confounding(const NonlinearModel& model, const std::vector<Index>& coefficients) {
  const bool are_steps = std::ranges::all_of(coefficients, [&](Index j) {
    const auto k = static_cast<std::size_t>(model.design().parameter_of(j));
    const ModelSpecification& specification = model.specification();
    return model.has_kink_in(j) &&
           specification.formula.right.derivative(specification.parameters[k].name).is_zero();
  });
  return {.kind = are_steps ? Finding::Kind::kSteps : Finding::Kind::kConfounded,
          .names = names_of(model, coefficients)};
}

std::vector<Index> undetermined(const NonlinearModel& model,
                                const VectorXd& coefficients,
                                const VectorXd& standard_errors,
                                const VectorXd& residual_sd) {
  std::vector<Index> result;
  for (Index j = 0; j < coefficients.size(); ++j) {
    const bool is_loose = standard_errors[j] > Thresholds::kLoose * std::abs(coefficients[j]);
    if (is_loose && change_without(model, coefficients, j, residual_sd) > Thresholds::kFelt)
      result.push_back(j);
  }
  return result;
}

bool is_identifiable(const NonlinearModel& model) {
  ProjectedModel projected(model);
  const CandidatePoints points(model, projected.size());
  constexpr std::size_t kPoints = 64;
  for (std::size_t number = 1; number <= kPoints; ++number) {
    if (!projected.evaluate(points(number))) continue;
    const MatrixXd jacobian = model.curve_at(projected.coefficients()).jacobian;
    if (jacobian.allFinite() && numerical_rank(jacobian) == jacobian.cols()) return true;
  }
  return false;
}

namespace {

/// The same for a fit by least squares.
std::vector<Index> undetermined(const NonlinearModel& model,
                                const NewtonPoint& point,
                                double sigma) {
  const VectorXd errors = sigma * point.unscaled_covariance.diagonal().cwiseSqrt();
  return undetermined(
      model, point.coefficients, errors, VectorXd::Constant(point.mean.size(), sigma));
}

void conclude_confounded(const NonlinearModel& model,
                         const NewtonPoint& point,
                         Convergence& result) {
  const std::vector<std::string> names = names_of(model, point.confounded);
  if (names.size() > 1 && is_identifiable(model)) {
    result.conclude(ConvergenceStatus::kNoMaximum,
                    {.kind = Finding::Kind::kSquaresKeepFalling, .names = names},
                    Evidence::Kind::kUnbounded);
    return;
  }
  result.conclude(ConvergenceStatus::kNotIdentifiable,
                  confounding(model, point.confounded),
                  Evidence::Kind::kNotIdentifiable);
}

/// Coefficients that are distinguished by small digits of the Jacobian only.
std::vector<Index> nearly_confounded(const NonlinearModel& model, const NewtonPoint& point) {
  const MatrixXd jacobian = model.curve_at(point.coefficients).jacobian;
  if (!jacobian.allFinite()) return {};
  return JacobianFactors(jacobian, JacobianFactors::kNearTolerance).confounded();
}

void conclude_failure(const NonlinearModel& model,
                      const NewtonPoint& point,
                      double sigma,
                      Convergence& result) {
  const std::vector<Index> loose = undetermined(model, point, sigma);
  if (!loose.empty()) {
    result.conclude(ConvergenceStatus::kNoMaximum,
                    {.kind = Finding::Kind::kSquaresKeepFalling, .names = names_of(model, loose)},
                    Evidence::Kind::kUnbounded);
    return;
  }
  const std::vector<Index> near = nearly_confounded(model, point);
  if (near.size() > 1) {
    result.conclude(ConvergenceStatus::kNotIdentifiable,
                    {.kind = Finding::Kind::kNearlyConfounded, .names = names_of(model, near)},
                    Evidence::Kind::kHardlyIdentifiable);
    return;
  }
  result.conclude(ConvergenceStatus::kMaximumNotReached,
                  {.kind = Finding::Kind::kNoMinimum, .values = {std::sqrt(point.decrement)}});
}

void conclude_success(const NonlinearModel& model,
                      const NewtonPoint& point,
                      double sigma,
                      bool exact,
                      Convergence& result) {
  if (exact) {
    result.conclude(ConvergenceStatus::kPerfectFit, {.kind = Finding::Kind::kPerfectFit});
    return;
  }
  const std::vector<Index> loose = undetermined(model, point, sigma);
  result.conclude(
      ConvergenceStatus::kConverged,
      {.kind = loose.empty() ? Finding::Kind::kMachinePrecision : Finding::Kind::kPoorlyDetermined,
       .names = names_of(model, loose)},
      Evidence::Kind::kHardlyIdentifiable);
  result.add(Evidence::Kind::kKink, names_of(model, point.kinked));
  result.find_kinks();
}

}  // namespace

bool is_exact(const NonlinearModel& model, double sum_of_squares) {
  return sum_of_squares <=
         Thresholds::kRounding * Thresholds::kRounding * model.response().squaredNorm();
}

Convergence judge(const NonlinearModel& model, const NewtonPoint& point, bool exact) {
  Convergence result{.newton_decrement = point.decrement, .rank = point.rank};
  if (!point.finite) {
    result.conclude(ConvergenceStatus::kDiverged, {.kind = Finding::Kind::kUndefinedDerivatives});
    return result;
  }
  const double freedom = static_cast<double>(model.observations() - model.coefficient_count());
  const double sigma = freedom > 0.0 ? std::sqrt(point.sum_of_squares / freedom) : 0.0;
  const std::vector<Index> lost = exact ? saturated(model, point) : std::vector<Index>{};
  if (!lost.empty()) {
    result.conclude(ConvergenceStatus::kNoMaximum,
                    {.kind = Finding::Kind::kPerfectOnlyAtLimit, .names = names_of(model, lost)},
                    Evidence::Kind::kUnbounded);
  } else if (point.rank < model.coefficient_count()) {
    conclude_confounded(model, point, result);
  } else if (exact || is_converged(point)) {
    conclude_success(model, point, sigma, exact, result);
  } else {
    conclude_failure(model, point, sigma, result);
  }
  return result;
}

Convergence too_few_observations(const NonlinearModel& model) {
  return {.status = ConvergenceStatus::kTooFewObservations,
          .findings = {{.kind = Finding::Kind::kTooFewObservations,
                        .values = {static_cast<double>(model.coefficient_count()),
                                   static_cast<double>(model.observations())}}}};
}

Convergence no_start() {
  return {.status = ConvergenceStatus::kNoStartValues,
          .findings = {{.kind = Finding::Kind::kNoStart}}};
}

}  // namespace silvafit::fit
