// SPDX-License-Identifier: MIT
#include "result/variance_shares.hpp"

namespace silvafit::fit {

VectorXd variance_of_effects(const FittedModel& fit,
                             const NonlinearModel& model,
                             const MatrixXd& slopes) {
  VectorXd result = VectorXd::Zero(model.observations());
  for (std::size_t t = fit.random.size(); t-- > 0;) {
    const MatrixXd chosen = slopes(Eigen::all, model.coefficients_of(fit.specification.random[t]));
    result += (chosen * fit.random[t].covariance).cwiseProduct(chosen).rowwise().sum();
  }
  return result;
}

VarianceShares variance_shares(const FittedModel& fit,
                               const NonlinearModel& model,
                               const VectorXd& residual_sd) {
  const auto [mean, slopes] = model.curve_at(model.extended(fit.estimate));
  const double rows = static_cast<double>(model.observations());
  const double fixed = (mean.array() - mean.mean()).square().sum() / (rows - 1.0);
  const double random = variance_of_effects(fit, model, slopes).mean();
  const double total = fixed + random + residual_sd.squaredNorm() / rows;
  return {.marginal = fixed / total, .conditional = (fixed + random) / total};
}

}  // namespace silvafit::fit
