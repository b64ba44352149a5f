// SPDX-License-Identifier: MIT
#include "least_squares/least_squares_verdict.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "least_squares/jacobian_factors.hpp"
#include "least_squares/variable_projection.hpp"
#include "optimization/candidate_points.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The change of the mean, as a length over all observations in units of each, when a coefficient
/// becomes zero; infinite if the mean is not defined then.
double change_without(const NonlinearModel& model,
                      const VectorXd& coefficients,
                      Index coefficient,
                      const VectorXd& units) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  VectorXd mean_without;
  VectorXd without = coefficients;
  without[coefficient] = 0.0;
  model.evaluate(coefficients, mean, nullptr, workspace);
  model.evaluate(without, mean_without, nullptr, workspace);
  const double change = (mean_without - mean).cwiseQuotient(units).norm();
  return std::isfinite(change) ? change : std::numeric_limits<double>::infinity();
}

/// Coefficients so large that small changes do not affect the mean, although the mean depends on
/// them: they approach a limit that the formula has at infinity only.
std::vector<Index> saturated(const NonlinearModel& model, const NewtonPoint& point) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  Eigen::MatrixXd jacobian;
  model.evaluate(point.coefficients, mean, &jacobian, workspace);
  std::vector<Index> result;
  for (Index j = 0; j < jacobian.cols(); ++j) {
    const double effect = jacobian.col(j).norm() * std::abs(point.coefficients[j]);
    const bool is_unfelt = effect <= 1e-12 * point.mean.norm();
    const VectorXd unit = VectorXd::Ones(point.mean.size());
    if (is_unfelt &&
        change_without(model, point.coefficients, j, unit) > 1e-6 * point.mean.norm()) {
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

std::string listed(const NonlinearModel& model, const std::vector<Index>& coefficients) {
  std::string text;
  for (std::size_t k = 0; k < coefficients.size(); ++k) {
    if (k > 0) text += k + 1 == coefficients.size() ? " and " : ", ";
    text += model.coefficient_names()[static_cast<std::size_t>(coefficients[k])];
  }
  return text;
}

std::vector<Index> undetermined(const NonlinearModel& model,
                                const VectorXd& coefficients,
                                const VectorXd& standard_errors,
                                const VectorXd& residual_sd) {
  std::vector<Index> result;
  for (Index j = 0; j < coefficients.size(); ++j) {
    const bool is_loose = standard_errors[j] > 10.0 * std::abs(coefficients[j]);
    if (is_loose && change_without(model, coefficients, j, residual_sd) > 1.0) result.push_back(j);
  }
  return result;
}

bool is_identifiable(const NonlinearModel& model) {
  ProjectedModel projected(model);
  const CandidatePoints points(model, projected.size());
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  Eigen::MatrixXd jacobian;
  constexpr std::size_t kPoints = 64;
  for (std::size_t number = 1; number <= kPoints; ++number) {
    if (!projected.evaluate(points(number))) continue;
    model.evaluate(projected.coefficients(), mean, &jacobian, workspace);
    if (jacobian.allFinite() && numerical_rank(jacobian) == jacobian.cols()) return true;
  }
  return false;
}

std::string unbounded_text(const NonlinearModel& model, const std::vector<Index>& coefficients) {
  const bool one = coefficients.size() == 1;
  return fmt::format(
      "{} {} without bound: the data do not cover the part of the curve that {}. Use a model with "
      "fewer coefficients.",
      listed(model, coefficients),
      one ? "grows" : "grow",
      one ? "it describes" : "they describe");
}

std::string undetermined_text(const NonlinearModel& model, const std::vector<Index>& coefficients) {
  return fmt::format(
      "Converged, but {} poorly determined (standard error more than ten times the estimate).",
      listed(model, coefficients) + (coefficients.size() == 1 ? " is" : " are"));
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

/// Sets a status, its coefficients, and the convergence message.
void conclude(const NonlinearModel& model,
              ConvergenceStatus status,
              Evidence::Kind kind,
              const std::vector<Index>& coefficients,
              std::string verdict,
              Convergence& result) {
  result.status = status;
  result.verdict = std::move(verdict);
  result.add(kind, names_of(model, coefficients));
}

void conclude_confounded(const NonlinearModel& model,
                         const NewtonPoint& point,
                         Convergence& result) {
  using enum Evidence::Kind;
  const std::string names = listed(model, point.confounded);
  const bool is_one = point.confounded.size() == 1;
  if (!is_one && is_identifiable(model)) {
    conclude(model,
             ConvergenceStatus::kNoMaximum,
             kUnbounded,
             point.confounded,
             "The sum of squares keeps decreasing while " + unbounded_text(model, point.confounded),
             result);
    return;
  }
  conclude(model,
           ConvergenceStatus::kNotIdentifiable,
           kNotIdentifiable,
           point.confounded,
           names + (is_one ? " is not identifiable: the mean does not depend on it. Remove it."
                           : " are not identifiable: their columns of the Jacobian are linearly "
                             "dependent. Remove one of them."),
           result);
}

/// Coefficients that are distinguished by small digits of the Jacobian only.
std::vector<Index> nearly_confounded(const NonlinearModel& model, const NewtonPoint& point) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  Eigen::MatrixXd jacobian;
  model.evaluate(point.coefficients, mean, &jacobian, workspace);
  if (!jacobian.allFinite()) return {};
  return JacobianFactors(jacobian, JacobianFactors::kNearTolerance).confounded();
}

void conclude_failure(const NonlinearModel& model,
                      const NewtonPoint& point,
                      double sigma,
                      Convergence& result) {
  using enum Evidence::Kind;
  const std::vector<Index> loose = undetermined(model, point, sigma);
  if (!loose.empty()) {
    conclude(model,
             ConvergenceStatus::kNoMaximum,
             kUnbounded,
             loose,
             "The sum of squares keeps decreasing, ever more slowly, while " +
                 unbounded_text(model, loose),
             result);
    return;
  }
  const std::vector<Index> near = nearly_confounded(model, point);
  if (near.size() > 1) {
    conclude(model,
             ConvergenceStatus::kNotIdentifiable,
             kHardlyIdentifiable,
             near,
             fmt::format("{} are hardly identifiable: their effects on the mean are nearly "
                         "linearly dependent. Remove one of them.",
                         listed(model, near)),
             result);
    return;
  }
  result.status = ConvergenceStatus::kMaximumNotReached;
  result.verdict = fmt::format(
      "No minimum was reached: the estimates are still {:.2g} standard errors away. Give other "
      "start values or use a model with fewer coefficients.",
      std::sqrt(point.decrement));
}

void conclude_success(const NonlinearModel& model,
                      const NewtonPoint& point,
                      double sigma,
                      bool exact,
                      Convergence& result) {
  if (exact) {
    result.status = ConvergenceStatus::kPerfectFit;
    result.verdict =
        "Perfect fit: sigma is 0 and the log-likelihood is infinite. Do not compare this model "
        "with others by these values.";
    return;
  }
  const std::vector<Index> loose = undetermined(model, point, sigma);
  std::string verdict = "Converged to machine precision.";
  if (!loose.empty()) verdict = undetermined_text(model, loose);
  conclude(model,
           ConvergenceStatus::kConverged,
           Evidence::Kind::kHardlyIdentifiable,
           loose,
           std::move(verdict),
           result);
}

}  // namespace

bool is_exact(const NonlinearModel& model, double sum_of_squares) {
  constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();
  return sum_of_squares <= kRounding * kRounding * model.response().squaredNorm();
}

Convergence judge(const NonlinearModel& model, const NewtonPoint& point, bool exact) {
  Convergence result{.newton_decrement = point.decrement, .rank = point.rank};
  if (!point.finite) {
    result.status = ConvergenceStatus::kDiverged;
    result.verdict =
        "The derivatives of the formula became infinite or undefined during the search. Give "
        "start values, or use another model.";
    return result;
  }
  const double freedom = static_cast<double>(model.observations() - model.coefficient_count());
  const double sigma = freedom > 0.0 ? std::sqrt(point.sum_of_squares / freedom) : 0.0;
  const std::vector<Index> lost = exact ? saturated(model, point) : std::vector<Index>{};
  if (!lost.empty()) {
    conclude(model,
             ConvergenceStatus::kNoMaximum,
             Evidence::Kind::kUnbounded,
             lost,
             "Perfect fit, reached only while " + unbounded_text(model, lost),
             result);
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
          .verdict = fmt::format(
              "{} coefficients need at least as many observations, but there are {}. Use a model "
              "with fewer coefficients or more data.",
              model.coefficient_count(),
              model.observations())};
}

Convergence no_start() {
  return {.status = ConvergenceStatus::kNoStartValues,
          .verdict =
              "No start values were found at which the formula is finite for all "
              "observations. Give start values."};
}

}  // namespace silvafit::fit
