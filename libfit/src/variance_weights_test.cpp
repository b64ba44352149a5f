// SPDX-License-Identifier: MIT
#include "variance_weights.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using Eigen::VectorXd;
using namespace silvafit::fit;
using Kind = VarianceFunction::Kind;

namespace {

VectorXd values() { return VectorXd::LinSpaced(7, 0.4, 12.0); }

/// R nlme's definition of the residual standard deviation.
double by_definition(const VarianceEstimate& estimate, double sigma, double v) {
  switch (estimate.function.kind) {
    case Kind::kNone:
      return sigma;
    case Kind::kExponential:
      return sigma * std::exp(estimate.delta * v);
    case Kind::kPower:
      return sigma * std::pow(std::abs(v), estimate.delta);
    case Kind::kConstantPlusPower:
      return sigma * (estimate.constant + std::pow(std::abs(v), estimate.delta));
  }
  return 0.0;
}

}  // namespace

TEST_CASE("internal parameters mean what nlme's parameters mean") {
  for (const Kind kind :
       {Kind::kNone, Kind::kExponential, Kind::kPower, Kind::kConstantPlusPower}) {
    const VarianceModel model({.kind = kind}, values());
    const VectorXd parameters = VectorXd::Constant(model.parameter_count(), 0.8);
    const double internal_sigma = 1.7;
    const ResidualScale scale = model.scale(values(), parameters, true);
    const VarianceEstimate estimate = model.estimate(parameters);
    const double sigma = internal_sigma * model.sigma_factor(parameters);
    for (Eigen::Index i = 0; i < values().size(); ++i) {
      CHECK(internal_sigma / std::sqrt(scale.weight[i]) ==
            Approx(by_definition(estimate, sigma, values()[i])).epsilon(1e-13));
    }
    CHECK(scale.sum_log == Approx(-0.5 * scale.weight.log().sum()).epsilon(1e-12).margin(1e-13));
  }
}

TEST_CASE("a constant variance is a point of every function") {
  for (const Kind kind : {Kind::kExponential, Kind::kPower, Kind::kConstantPlusPower}) {
    const VarianceModel model({.kind = kind}, values());
    const ResidualScale scale = model.scale(values(), model.constant(), false);
    CHECK((scale.weight - 1.0).abs().maxCoeff() < 1e-14);
  }
  const VarianceModel both({.kind = Kind::kConstantPlusPower}, values());
  CHECK(std::isinf(both.estimate(both.constant()).constant));
}

TEST_CASE("values near zero are floored and counted") {
  const VarianceModel model({.kind = Kind::kPower}, values());
  VectorXd v = values();
  v[2] = 0.0;
  v[3] = -1e-9;
  CHECK(model.floored(v) == 2);
  CHECK(model.scale(v, VectorXd::Constant(1, 0.5), false).weight.allFinite());
}
