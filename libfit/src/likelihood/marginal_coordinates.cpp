// SPDX-License-Identifier: MIT
#include "likelihood/marginal_coordinates.hpp"

namespace silvafit::fit {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MarginalPoint MarginalCoordinates::point(const VectorXd& x) const {
  return {.observation = {.beta = layout_.beta(x),
                          .variance = layout_.variance_part(x),
                          .log_sigma = x[layout_.sigma_at()]},
          .outer_factor = layout_.own_factor(x, true),
          .inner_factor = layout_.own_factor(x, false)};
}

VectorXd MarginalCoordinates::gradient(const MarginalValue& value) const {
  VectorXd result(layout_.size());
  result << layout_.beta_gradient(value.by_beta),
      layout_.factor_gradient(true, value.by_outer_factor),
      layout_.factor_gradient(false, value.by_inner_factor), value.by_variance, value.by_log_sigma;
  return result;
}

VectorXd MarginalCoordinates::coordinates(const ObservationPoint& observation,
                                          const MatrixXd& outer,
                                          const MatrixXd& inner) const {
  return layout_.coordinates(
      observation.beta, outer, inner, observation.variance, observation.log_sigma);
}

MatrixXd MarginalCoordinates::spherical(const VectorXd& x,
                                        bool is_outer,
                                        const MatrixXd& effects) const {
  const auto frame = layout_.frame().effects(is_outer).triangularView<Eigen::Lower>();
  if (frame.rows() == 0) return effects;
  const MatrixXd factor = layout_.factor(is_outer).factor(layout_.factor_part(x, is_outer));
  return spherical_effects(factor, frame.solve(effects));
}

MatrixXd MarginalCoordinates::scaled_covariance(const VectorXd& x, bool is_outer) const {
  const MatrixXd root = layout_.factor(is_outer).factor(layout_.factor_part(x, is_outer));
  return root * root.transpose();
}

VectorXd MarginalCoordinates::widened(const VectorXd& x,
                                      bool is_outer,
                                      const VectorXd& direction,
                                      double size) const {
  const MatrixXd covariance =
      scaled_covariance(x, is_outer) + size * direction * direction.transpose();
  const RelativeFactor& form = layout_.factor(is_outer);
  VectorXd result = x;
  result.segment(layout_.factor_at(is_outer), form.parameter_count()) =
      form.from_covariance(covariance);
  return result;
}

}  // namespace silvafit::fit
