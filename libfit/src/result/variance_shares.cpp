// SPDX-License-Identifier: MIT
#include "result/variance_shares.hpp"

#include "model/nested_terms.hpp"
#include "result/nested_effects.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd variance_of_effects(const FittedModel& fit,
                             const NonlinearModel& model,
                             const MatrixXd& slopes) {
  VectorXd result = VectorXd::Zero(model.observations());
  const auto add = [&](const RandomEffects* random, const MatrixXd& covariance) {
    if (random == nullptr) return;
    const MatrixXd chosen = slopes(Eigen::all, model.coefficients_of(random));
    result += (chosen * covariance).cwiseProduct(chosen).rowwise().sum();
  };
  add(finer_term(fit.specification), finer(fit).covariance);
  add(coarser_term(fit.specification), coarser(fit).covariance);
  return result;
}

VarianceShares variance_shares(const FittedModel& fit,
                               const NonlinearModel& model,
                               const VectorXd& residual_sd) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  MatrixXd slopes;
  model.evaluate(fit.estimate, mean, &slopes, workspace);
  const double rows = static_cast<double>(model.observations());
  const double fixed = (mean.array() - mean.mean()).square().sum() / (rows - 1.0);
  const double random = variance_of_effects(fit, model, slopes).mean();
  const double total = fixed + random + residual_sd.squaredNorm() / rows;
  return {.marginal = fixed / total, .conditional = (fixed + random) / total};
}

}  // namespace silvafit::fit
