// SPDX-License-Identifier: MIT
#include "likelihood/marginal_coordinates.hpp"

namespace silvafit::fit {

MarginalPoint MarginalCoordinates::point(const VectorXd& x) const {
  MarginalPoint point{.observation = {.beta = model_.extended(layout_.beta(x)),
                                      .variance = layout_.variance_part(x),
                                      .log_sigma = x[layout_.sigma_at()]}};
  for (std::size_t term = 0; term < layout_.terms(); ++term) {
    point.factors.push_back(layout_.own_factor(x, term));
  }
  return point;
}

VectorXd MarginalCoordinates::gradient(const VectorXd& x, const MarginalValue& value) const {
  VectorXd result(layout_.size());
  const Index p = layout_.beta_count();
  result.head(p) = layout_.beta_gradient(value.by_beta.head(p));
  for (std::size_t term = 0; term < layout_.terms(); ++term) {
    const VectorXd slopes = layout_.factor_gradient(x, term, value.by_factors[term]);
    result.segment(layout_.factor_at(term), slopes.size()) = slopes;
  }
  result.segment(layout_.variance_at(), layout_.variance_count()) = value.by_variance;
  result[layout_.sigma_at()] = value.by_log_sigma;
  return result;
}

VectorXd MarginalCoordinates::coordinates(const ObservationPoint& observation,
                                          const std::vector<MatrixXd>& covariances) const {
  return layout_.coordinates(
      observation.beta, covariances, observation.variance, observation.log_sigma);
}

std::vector<MatrixXd> MarginalCoordinates::spherical(const VectorXd& x,
                                                     const std::vector<MatrixXd>& effects) const {
  std::vector<MatrixXd> result;
  for (std::size_t term = 0; term < layout_.terms(); ++term) {
    const auto frame = layout_.frame().effects[term].triangularView<Eigen::Lower>();
    const MatrixXd factor = layout_.factor(term).factor(layout_.factor_part(x, term));
    result.push_back(spherical_effects(factor, frame.solve(effects[term])));
  }
  return result;
}

MatrixXd MarginalCoordinates::scaled_covariance(const VectorXd& x, std::size_t term) const {
  const MatrixXd root = layout_.factor(term).factor(layout_.factor_part(x, term));
  return root * root.transpose();
}

VectorXd MarginalCoordinates::widened(const VectorXd& x,
                                      std::size_t term,
                                      const VectorXd& direction,
                                      double size) const {
  const MatrixXd covariance = scaled_covariance(x, term) + size * direction * direction.transpose();
  const RelativeFactor& form = layout_.factor(term);
  VectorXd result = x;
  result.segment(layout_.factor_at(term), form.parameter_count()) =
      form.from_covariance(covariance);
  return result;
}

}  // namespace silvafit::fit
