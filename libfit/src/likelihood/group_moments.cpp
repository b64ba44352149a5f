// SPDX-License-Identifier: MIT
#include <numeric>

#include "likelihood/linear_mixed_profile.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

GroupMoments::GroupMoments(Index width,
                           Index groups,
                           Index parameters,
                           std::vector<std::pair<Index, Index>> pairs,
                           std::vector<Index> rows)
    : width_(width), parameters_(parameters), pairs_(std::move(pairs)), rows_(std::move(rows)) {
  if (rows_.empty()) {
    rows_.resize(static_cast<std::size_t>(width));
    std::iota(rows_.begin(), rows_.end(), Index{0});
  }
  products_.setZero(size() * terms(), groups);
  if (!has_all_rows()) totals_.setZero(width * width, terms());
  sum_log_.setZero(terms());
  center_.setZero(parameters);
}

void GroupMoments::keep(Index group, const double* products) {
  for (Index t = 0; t < terms(); ++t) {
    const Eigen::Map<const MatrixXd> whole(products + t * width_ * width_, width_, width_);
    Eigen::Map<MatrixXd>(term(group, t), std::ssize(rows_), width_) = whole(rows_, Eigen::all);
  }
}

MatrixXd GroupMoments::total(Index term) const {
  if (!has_all_rows()) return totals_.col(term).reshaped(width_, width_);
  MatrixXd sum = MatrixXd::Zero(width_, width_);
  for (Index group = 0; group < groups(); ++group) {
    sum += Eigen::Map<const MatrixXd>(this->term(group, term), width_, width_);
  }
  return sum;
}

void GroupMoments::divide_columns(const VectorXd& sizes) {
  VectorXd divisors = VectorXd::Ones(width_);
  divisors.head(width_ - 1) = sizes;
  const VectorXd factor = divisors.cwiseInverse();
  const VectorXd of_rows = factor(rows_);
  for (Index group = 0; group < groups(); ++group) {
    for (Index t = 0; t < terms(); ++t) {
      Eigen::Map<MatrixXd> products(term(group, t), std::ssize(rows_), width_);
      products = of_rows.asDiagonal() * products * factor.asDiagonal();
    }
  }
  const VectorXd of_totals = (factor * factor.transpose()).reshaped();
  if (!has_all_rows()) totals_ = of_totals.asDiagonal() * totals_;
}

VectorXd GroupMoments::term_weights(const VectorXd& displacement) const {
  const double s = displacement.dot(center_);
  VectorXd weights(terms());
  weights[0] = 1.0 + 2.0 * s + 2.0 * s * s;
  weights.segment(1, parameters_) = (1.0 + 2.0 * s) * displacement;
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto [i, j] = pairs_[k];
    weights[1 + parameters_ + static_cast<Index>(k)] =
        displacement[i] * displacement[j] * (i == j ? 0.5 : 1.0);
  }
  return std::exp(-2.0 * s) * weights;
}

VectorXd GroupMoments::by_displacement(const VectorXd& by_term,
                                       const VectorXd& displacement) const {
  const double s = displacement.dot(center_);
  const auto by_first = by_term.segment(1, parameters_);
  VectorXd result = (1.0 + 2.0 * s) * by_first;
  double by_s = -4.0 * s * s * by_term[0] - 4.0 * s * by_first.dot(displacement);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto [i, j] = pairs_[k];
    const double value = by_term[1 + parameters_ + static_cast<Index>(k)];
    result[i] += value * displacement[j];
    if (i != j) result[j] += value * displacement[i];
    by_s -= 2.0 * value * displacement[i] * displacement[j] * (i == j ? 0.5 : 1.0);
  }
  return std::exp(-2.0 * s) * (result + by_s * center_);
}

double GroupMoments::sum_log_at(const VectorXd& displacement) const {
  double sum = sum_log_[0] + sum_log_.segment(1, parameters_).dot(displacement);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto [i, j] = pairs_[k];
    sum += sum_log_[1 + parameters_ + static_cast<Index>(k)] * displacement[i] * displacement[j] *
           (i == j ? 0.5 : 1.0);
  }
  return sum;
}

VectorXd GroupMoments::sum_log_gradient(const VectorXd& displacement) const {
  VectorXd result = sum_log_.segment(1, parameters_);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto [i, j] = pairs_[k];
    const double value = sum_log_[1 + parameters_ + static_cast<Index>(k)];
    result[i] += value * displacement[j];
    if (i != j) result[j] += value * displacement[i];
  }
  return result;
}

}  // namespace silvafit::fit
