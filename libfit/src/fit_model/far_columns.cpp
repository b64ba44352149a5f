// SPDX-License-Identifier: MIT
#include "fit_model/far_columns.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "least_squares/location_coefficients.hpp"
#include "silvafit/base/constants.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

/// Whether the slopes of the mean by the coefficients are nearly dependent, as those of an
/// intercept and a slope are if the column is far from 0.
bool are_slopes_dependent(const NonlinearModel& model, const VectorXd& coefficients) {
  if (coefficients.size() != model.coefficient_count() || !coefficients.allFinite()) return true;
  const MatrixXd slopes = model.curve_at(coefficients).jacobian.colwise().normalized();
  if (!slopes.allFinite()) return true;
  return Eigen::BDCSVD<MatrixXd>(slopes).singularValues().minCoeff() < 1.0 / kFarFromZero;
}

/// Whether a search may have failed because a column is far from 0.
bool may_depend_on_origin(const Convergence& convergence) {
  switch (convergence.status) {
    case ConvergenceStatus::kContainedModelHigher:
    case ConvergenceStatus::kInvalidApproximation:
    case ConvergenceStatus::kDiverged:
    case ConvergenceStatus::kIterationLimit:
    case ConvergenceStatus::kMaximumNotReached:
    case ConvergenceStatus::kNotIdentifiable:
    case ConvergenceStatus::kNoStartValues:
      return true;
    default:
      return std::ranges::any_of(convergence.evidence, [](const Evidence& item) {
        return item.kind == Evidence::Kind::kUnbounded;
      });
  }
}

const double kLogLargest = std::log(std::numeric_limits<double>::max());

/// Whether powers that differ within the data by more than a factor of e^2 are beyond the range of
/// numbers at all of them.
bool are_powers_beyond_numbers(const TypicalValue& typical) {
  constexpr double kChange = 2.0;
  const double log_ratio = std::log(typical.high / typical.low);
  return log_ratio > 0.0 && kChange * std::abs(std::log(typical.middle)) > kLogLargest * log_ratio;
}

/// Refuses a fit whose variance function or sigma is beyond the range of numbers.
/// \returns  whether it is
bool note_far_variance(const NonlinearModel& model, FittedModel& fit) {
  for (const VarianceFactorEstimate& estimate : fit.variance.factors) {
    const VarianceFactor& factor = estimate.factor;
    const VarianceKind& kind = kind_of(factor);
    if (factor.column.empty() || !kind.has_delta() || factor.delta) continue;
    const TypicalValue typical = kind.typical(model.column(factor.column));
    // A constant that is estimated hides that: it is infinite then, a constant variance.
    const bool is_failed = !fit.convergence.converged() || kind.has_constant();
    const bool is_power = kind.reads_logarithm() && are_powers_beyond_numbers(typical);
    const bool is_sigma_lost = !std::isnormal(fit.sigma) &&
                               std::abs(kind.log_offset(estimate, typical)) > 0.5 * kLogLargest;
    if (!is_sigma_lost && !(is_power && is_failed)) continue;
    fit.convergence.conclude(ConvergenceStatus::kMaximumNotReached,
                             {.kind = Finding::Kind::kFarVariance,
                              .names = {factor.column},
                              .values = {typical.middle}});
    return true;
  }
  return false;
}

}  // namespace

void note_far_columns(const NonlinearModel& model, FittedModel& fit) {
  if (note_far_variance(model, fit)) return;
  Convergence& convergence = fit.convergence;
  if (convergence.converged() || !may_depend_on_origin(convergence)) return;
  if (!are_slopes_dependent(model, fit.estimate)) return;
  for (const FarColumn& column : far_columns(model)) {
    convergence.find(
        {.kind = Finding::Kind::kFarColumn, .names = {column.name}, .values = {column.middle}});
  }
}

}  // namespace silvafit::fit
