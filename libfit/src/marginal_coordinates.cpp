// SPDX-License-Identifier: MIT
#include "marginal_coordinates.hpp"

#include <utility>

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

MarginalCoordinates::MarginalCoordinates(const NonlinearModel& model,
                                         const MarginalLikelihood& likelihood,
                                         Index variance_parameters,
                                         VectorXd unit)
    : unit_(std::move(unit)),
      outer_unit_(unit_(likelihood.places().outer)),
      inner_unit_(unit_(likelihood.places().inner)),
      beta_(unit_.size()),
      variance_(variance_parameters),
      outer_(model.specification().outer_random.value_or(RandomEffects{}), outer_unit_),
      inner_(model.specification().random.value_or(RandomEffects{}), inner_unit_) {}

MarginalPoint MarginalCoordinates::point(const VectorXd& x) const {
  return {.observation = {.beta = x.head(beta_).cwiseProduct(unit_),
                          .variance = x.segment(x.size() - 1 - variance_, variance_),
                          .log_sigma = x[x.size() - 1]},
          .outer_factor = outer_unit_.asDiagonal() * outer_.factor(outer_parameters(x)),
          .inner_factor = inner_unit_.asDiagonal() * inner_.factor(inner_parameters(x))};
}

VectorXd MarginalCoordinates::gradient(const MarginalValue& value) const {
  VectorXd result(size());
  result << value.by_beta.cwiseProduct(unit_),
      outer_.gradient(outer_unit_.asDiagonal() * value.by_outer_factor),
      inner_.gradient(inner_unit_.asDiagonal() * value.by_inner_factor), value.by_variance,
      value.by_log_sigma;
  return result;
}

VectorXd MarginalCoordinates::coordinates(const ObservationPoint& observation,
                                          const MatrixXd& outer,
                                          const MatrixXd& inner) const {
  const auto scaled = [](const MatrixXd& covariance, const VectorXd& unit) -> MatrixXd {
    return unit.cwiseInverse().asDiagonal() * covariance * unit.cwiseInverse().asDiagonal();
  };
  VectorXd x(size());
  x << observation.beta.cwiseQuotient(unit_), outer_.from_covariance(scaled(outer, outer_unit_)),
      inner_.from_covariance(scaled(inner, inner_unit_)), observation.variance,
      observation.log_sigma;
  return x;
}

MatrixXd MarginalCoordinates::scaled_covariance(const VectorXd& x, bool is_outer) const {
  const MatrixXd factor =
      is_outer ? outer_.factor(outer_parameters(x)) : inner_.factor(inner_parameters(x));
  return factor * factor.transpose();
}

VectorXd MarginalCoordinates::widened(const VectorXd& x,
                                      bool is_outer,
                                      const VectorXd& direction,
                                      double size) const {
  const MatrixXd covariance =
      scaled_covariance(x, is_outer) + size * direction * direction.transpose();
  VectorXd result = x;
  if (is_outer) {
    result.segment(beta_, outer_.parameter_count()) = outer_.from_covariance(covariance);
  } else {
    result.segment(beta_ + outer_.parameter_count(), inner_.parameter_count()) =
        inner_.from_covariance(covariance);
  }
  return result;
}

}  // namespace silvafit::fit
