// SPDX-License-Identifier: MIT
#include "likelihood/profile_sums.hpp"

#include <cmath>
#include <numbers>

namespace silvafit::fit {

LinearMixedProfile ProfileSums::solve(const LinearMixedModel& model,
                                      const VectorXd& displacement,
                                      const HeldParameters& held) {
  LinearMixedProfile result;
  const Index last = total.rows() - 1;
  const Index p = last - model.random_only;
  result.information = total.topLeftCorner(p, p);
  information_.compute(result.information);
  if (information_.info() != Eigen::Success) return result;
  const VectorXd right = total.col(last).head(p);
  result.coefficients = information_.solve(right);
  result.sum_of_squares = total(last, last) - result.coefficients.dot(right);
  if (held.coefficients.size() > 0) {
    const VectorXd away = held.coefficients - result.coefficients;
    result.sum_of_squares += away.dot(result.information * away);
    result.coefficients = held.coefficients;
  }
  const double freedom = static_cast<double>(model.observations - (model.restricted ? p : 0));
  result.sigma2 = held.sigma2 > 0.0 ? held.sigma2 : result.sum_of_squares / freedom;
  if (!(result.sigma2 > 0.0)) return result;
  result.minus_log_likelihood =
      0.5 * freedom * (std::log(2.0 * std::numbers::pi * result.sigma2) + 1.0) + log_determinant +
      model.moments.sum_log_at(displacement);
  if (held.sigma2 > 0.0) {
    result.minus_log_likelihood += 0.5 * (result.sum_of_squares / result.sigma2 - freedom);
  }
  result.by_coefficients = (result.information * result.coefficients - right) / result.sigma2;
  result.by_log_sigma = freedom - result.sum_of_squares / result.sigma2;
  if (model.restricted) {
    const MatrixXd& triangle = information_.matrixLLT();
    result.minus_log_likelihood += triangle.diagonal().array().log().sum() + 0.5 * model.log_units;
  }
  result.is_valid = std::isfinite(result.minus_log_likelihood);
  return result;
}

Adjoint ProfileSums::adjoint(const LinearMixedModel& model, const LinearMixedProfile& at) const {
  const Index p = at.coefficients.size();
  Adjoint result{.count = 1};
  const double scale = 1.0 / std::sqrt(2.0 * at.sigma2);
  const auto random_only = static_cast<std::size_t>(model.random_only);
  for (const double value : at.coefficients) result.vectors.push_back(-value * scale);
  result.vectors.insert(result.vectors.end(), random_only, 0.0);
  result.vectors.push_back(scale);
  if (!model.restricted) return result;
  const MatrixXd inverse = information_.matrixL().solve(MatrixXd::Identity(p, p));
  for (Index k = 0; k < p; ++k) {
    for (Index c = 0; c < p; ++c) {
      result.vectors.push_back(std::numbers::sqrt2 / 2.0 * inverse(k, c));
    }
    result.vectors.insert(result.vectors.end(), random_only + 1, 0.0);
    ++result.count;
  }
  return result;
}

}  // namespace silvafit::fit
