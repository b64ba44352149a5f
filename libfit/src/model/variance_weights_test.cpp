// SPDX-License-Identifier: MIT
#include "model/variance_weights.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using Eigen::VectorXd;
using namespace silvafit::fit;
using Kind = VarianceFactor::Kind;

namespace {

VectorXd values() { return VectorXd::LinSpaced(7, 0.4, 12.0); }

VarianceModel model_of(const char* function) {
  return {parse_variance_function(function), {.response = values()}};
}

/// R nlme's definition of the residual standard deviation.
double by_definition(const VarianceEstimate& estimate, double sigma, double v) {
  if (estimate.factors.empty()) return sigma;
  switch (estimate.factors[0].factor.kind) {
    case Kind::kExponential:
      return sigma * std::exp(estimate.delta() * v);
    case Kind::kPower:
      return sigma * std::pow(std::abs(v), estimate.delta());
    case Kind::kConstantPlusPower:
      return sigma * (estimate.constant() + std::pow(std::abs(v), estimate.delta()));
    default:
      return 0.0;
  }
}

}  // namespace

TEST_CASE("internal parameters give the variance functions of nlme's parameters") {
  for (const char* const function : {"none",
                                     "exponential",
                                     "power",
                                     "constant-plus-power",
                                     "power(delta = 0.5)",
                                     "exponential(delta = 0.1)",
                                     "constant-plus-power(delta = 0.7)",
                                     "constant-plus-power(constant = 2)"}) {
    const VarianceModel model = model_of(function);
    const VectorXd parameters = VectorXd::Constant(model.parameter_count(), 0.8);
    const double internal_sigma = 1.7;
    const ResidualScale scale = model.scale(values(), parameters, true);
    const VarianceEstimate estimate = model.estimate(parameters);
    const double sigma = internal_sigma * model.sigma_factor(parameters);
    CHECK(model.log_scale_of(estimate, sigma) ==
          Approx(std::log(internal_sigma)).epsilon(1e-13).margin(1e-13));
    for (Eigen::Index i = 0; i < values().size(); ++i) {
      CHECK(internal_sigma / std::sqrt(scale.weight[i]) ==
            Approx(by_definition(estimate, sigma, values()[i])).epsilon(1e-13));
    }
    CHECK(scale.sum_log == Approx(-0.5 * scale.weight.log().sum()).epsilon(1e-12).margin(1e-13));
  }
}

TEST_CASE("an estimate from other data is converted correctly if its constant is dominant") {
  const VarianceModel model = model_of("constant-plus-power");
  VarianceEstimate estimate = model.estimate(model.start());
  const double sigma = 0.3;
  for (const double constant : {1e-6, 1.0, 1e12, 1e30}) {
    INFO(constant);
    estimate.factors[0].constant[0] = constant;
    const double internal = std::exp(model.log_scale_of(estimate, sigma));
    const ResidualScale scale = model.scale(values(), model.parameters(estimate), false);
    for (Eigen::Index i = 0; i < values().size(); ++i) {
      // If the constant is 1e12 times as large, the angle has eight digits of the power.
      CHECK(internal / std::sqrt(scale.weight[i]) ==
            Approx(by_definition(estimate, sigma, values()[i])).epsilon(1e-10));
    }
  }
}

TEST_CASE("the name of a column does not matter") {
  for (const char* const function : {"exponential", "power", "constant-plus-power"}) {
    const auto weights = [&](const std::string& column) {
      const VarianceModel model(parse_variance_function(std::string(function) + "(" + column + ")"),
                                {.response = values(), .columns = {{column, values()}}});
      return model.scale(values(), VectorXd::Constant(model.parameter_count(), 0.8), false).weight;
    };
    const Eigen::ArrayXd expected = weights("dbh");
    // Names that the formulas of the functions use internally.
    for (const char* const column : {"a", "b", "d", "f", "k", "o", "t", "v"}) {
      INFO(function << " of " << column);
      CHECK((weights(column) == expected).all());
    }
  }
}

TEST_CASE("a constant variance is a special case of every function") {
  for (const char* const function : {"exponential", "power", "constant-plus-power"}) {
    const VarianceModel model = model_of(function);
    const ResidualScale scale = model.scale(values(), model.constant(), false);
    CHECK((scale.weight - 1.0).abs().maxCoeff() < 1e-14);
  }
  const VarianceModel both = model_of("constant-plus-power");
  CHECK(std::isinf(both.estimate(both.constant()).constant()));
}

TEST_CASE("values near zero are floored and counted") {
  const VarianceModel model = model_of("power");
  VectorXd v = values();
  v[2] = 0.0;
  v[3] = -1e-9;
  CHECK(model.floored(v) == 2);
  CHECK(model.scale(v, VectorXd::Constant(1, 0.5), false).weight.allFinite());
}

TEST_CASE("strata and products of variance functions agree with nlme's definitions") {
  VarianceData data{.response = values()};
  data.columns["dbh"] = VectorXd::LinSpaced(7, 3.0, 30.0);
  data.strata.push_back(
      {.column = "species", .labels = {"fir", "oak"}, .of_rows = {0, 1, 1, 0, 0, 1, 0}});
  const VarianceModel model(
      parse_variance_function("stratum(species) * power(fitted | species) * exponential(dbh)"),
      data);
  REQUIRE(model.parameter_count() == 1 + 2 + 1);
  const VectorXd parameters = Eigen::Vector4d(0.3, 0.5, 0.9, 0.2);
  const ResidualScale scale = model.scale(values(), parameters, true);
  const VarianceEstimate estimate = model.estimate(parameters);
  const double sigma = 1.7 * model.sigma_factor(parameters);
  for (Eigen::Index i = 0; i < 7; ++i) {
    const Eigen::Index stratum = data.strata[0].of_rows[static_cast<std::size_t>(i)];
    const double expected = sigma * estimate.factors[0].ratio[stratum] *
                            std::pow(values()[i], estimate.factors[1].delta[stratum]) *
                            std::exp(estimate.factors[2].delta[0] * data.columns["dbh"][i]);
    CHECK(1.7 / std::sqrt(scale.weight[i]) == Approx(expected).epsilon(1e-13));
    // d log g / d log ratio is 1 in the second stratum, that of an exponent log v in its own.
    CHECK(scale.log_derivative(i, 0) == static_cast<double>(stratum));
    CHECK(scale.log_derivative(i, 1 + stratum) == Approx(std::log(values()[i])).epsilon(1e-13));
    CHECK(scale.log_derivative(i, 2 - stratum) == 0.0);
  }
  CHECK(estimate.factors[0].ratio[0] == 1.0);
}

TEST_CASE("internal parameters are of order one for a step of the variance at few observations") {
  const VarianceModel model = model_of("constant-plus-power");
  for (const double delta : {170.0, -120.0}) {
    INFO(delta);
    // A constant as large as the power of the largest or smallest value.
    const double at = delta > 0.0 ? values().maxCoeff() : values().minCoeff();
    VarianceEstimate estimate = model.estimate(model.start());
    estimate.factors[0].delta[0] = delta;
    estimate.factors[0].constant[0] = std::pow(at, delta);
    const VectorXd parameters = model.parameters(estimate);
    // tan^2 is the constant over the mean of the powers of the ends, of which the other is 0.
    CHECK(parameters[1] == Approx(std::atan(std::sqrt(2.0))).epsilon(1e-12));
    CHECK(model.estimate(parameters).constant() == Approx(estimate.constant()).epsilon(1e-10));
    // g there is twice that elsewhere, and its slope by the angle is of order one.
    const ResidualScale scale = model.scale(values(), parameters, true);
    CHECK(scale.weight.maxCoeff() / scale.weight.minCoeff() == Approx(4.0).epsilon(1e-10));
    CHECK(scale.log_derivative.col(1).abs().maxCoeff() > 0.1);
  }
}
