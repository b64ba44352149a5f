// SPDX-License-Identifier: MIT
#include "least_squares/variable_projection.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>

#include "verdict/thresholds.hpp"

namespace silvafit::fit {
namespace {

/// Scaled columns below this share of the largest are rounding.
constexpr double kRankTolerance = 1e-13;

/// Whether the mean without its linear terms is so far from the response that the terms which have
/// to cancel it leave rounding errors only: no residual is known there.
bool is_lost(const VectorXd& offset, const VectorXd& response) {
  return std::numeric_limits<double>::epsilon() * offset.stableNorm() >
         Thresholds::kRoundedResidual * response.stableNorm();
}

}  // namespace

CoefficientSplit split_coefficients(const NonlinearModel& model) {
  const Index p = model.coefficient_count();
  std::vector<Index> order(static_cast<std::size_t>(p));
  std::iota(order.begin(), order.end(), Index{0});
  const auto partners = [&](Index i) {
    return std::ranges::count_if(order, [&](Index j) { return model.is_bilinear(i, j); });
  };
  std::vector<Index> by_partners = order;
  std::ranges::stable_sort(by_partners, std::greater<>(), partners);
  CoefficientSplit split;
  for (const Index i : by_partners) {
    const bool joins = model.is_bilinear(i, i) && std::ranges::all_of(split.linear, [&](Index j) {
                         return model.is_bilinear(i, j);
                       });
    if (joins) split.linear.push_back(i);
  }
  std::ranges::sort(split.linear);
  std::ranges::set_difference(order, split.linear, std::back_inserter(split.nonlinear));
  return split;
}

ProjectedModel::ProjectedModel(const NonlinearModel& model)
    : model_(model), split_(split_coefficients(model)) {}

VectorXd ProjectedModel::nonlinear_part(const VectorXd& coefficients) const {
  return coefficients(split_.nonlinear);
}

bool ProjectedModel::evaluate(const VectorXd& nonlinear) {
  coefficients_.setZero(model_.coefficient_count());
  coefficients_(split_.nonlinear) = nonlinear;
  model_.evaluate(coefficients_, mean_, split_.linear.empty() ? nullptr : &jacobian_, workspace_);
  residuals_ = model_.response() - mean_;
  if (!split_.linear.empty() && is_lost(mean_, model_.response())) return false;
  return residuals_.allFinite() && solve_linear();
}

bool ProjectedModel::solve_linear() {
  const auto count = static_cast<Index>(split_.linear.size());
  if (count == 0) return true;
  basis_ = jacobian_(Eigen::all, split_.linear);
  if (!basis_.allFinite()) return false;
  // Equal column lengths, so that the rank does not depend on the units of coefficients.
  VectorXd scale = basis_.colwise().stableNorm();
  scale = (scale.array() > 0.0).select(scale, 1.0);
  basis_ *= scale.cwiseInverse().asDiagonal();
  if (count == 1) {  // the common case: one column is its own factorization
    const double value = basis_.col(0).dot(residuals_);
    coefficients_[split_.linear[0]] = value / scale[0];
    residuals_ -= value * basis_.col(0);
    return residuals_.allFinite();
  }
  Eigen::ColPivHouseholderQR<MatrixXd> qr(basis_.rows(), basis_.cols());
  qr.setThreshold(kRankTolerance);
  qr.compute(basis_);
  const VectorXd solution = qr.solve(residuals_);
  coefficients_(split_.linear) = solution.cwiseQuotient(scale);
  residuals_ -= basis_ * solution;
  if (qr.rank() == 0) {
    basis_.resize(basis_.rows(), 0);
  } else {
    basis_ = qr.householderQ() * MatrixXd::Identity(basis_.rows(), qr.rank());
  }
  return residuals_.allFinite() && coefficients_.allFinite();
}

bool ProjectedModel::evaluate_jacobian(MatrixXd& jacobian) {
  VectorXd mean;
  model_.evaluate(coefficients_, mean, &jacobian_, workspace_);
  jacobian = -jacobian_(Eigen::all, split_.nonlinear);
  if (!jacobian.allFinite()) return false;
  if (!split_.linear.empty()) jacobian -= basis_ * (basis_.transpose() * jacobian).eval();
  return jacobian.allFinite();
}

}  // namespace silvafit::fit
