// SPDX-License-Identifier: MIT
#include "inference/surface_layout.hpp"

#include <utility>

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

SurfaceLayout::SurfaceLayout(const NonlinearModel& model,
                             const VarianceModel& variance,
                             VectorXd unit,
                             Index beta_count)
    : unit_(std::move(unit)),
      outer_unit_(unit_(model.coefficients_of(model.specification().outer_random))),
      inner_unit_(unit_(model.coefficients_of(model.specification().random))),
      beta_(beta_count),
      variance_(variance.parameter_count()),
      outer_(model.specification().outer_random.value_or(RandomEffects{}), outer_unit_),
      inner_(model.specification().random.value_or(RandomEffects{}), inner_unit_) {}

VectorXd SurfaceLayout::coordinates(const VectorXd& beta,
                                    const MatrixXd& outer,
                                    const MatrixXd& inner,
                                    const VectorXd& variance,
                                    double log_sigma) const {
  VectorXd x(size());
  if (beta_ > 0) x.head(beta_) = beta.cwiseQuotient(unit_);
  for (const bool is_outer : {true, false}) {
    const VectorXd& unit = effect_unit(is_outer);
    if (unit.size() == 0) continue;
    const MatrixXd scaled = unit.cwiseInverse().asDiagonal() * (is_outer ? outer : inner) *
                            unit.cwiseInverse().asDiagonal();
    const RelativeFactor& form = factor(is_outer);
    x.segment(factor_at(is_outer), form.parameter_count()) = form.from_covariance(scaled);
  }
  x.segment(variance_at(), variance_) = variance;
  x[sigma_at()] = log_sigma;
  return x;
}

}  // namespace silvafit::fit
