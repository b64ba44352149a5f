// SPDX-License-Identifier: MIT
#include "linear_mixed_profile.hpp"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "silvafit/base/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace silvafit::fit;

namespace {

/// 23 observations in groups of 9, 1, 8 and 5; three coefficients, random effects on the first and
/// last.
LinearMixedModel example() {
  silvafit::Random random(11);
  LinearMixedModel model;
  model.group_begin = {0, 9, 10, 18, 23};
  model.random = {0, 2};
  model.design.resize(23, 3);
  model.working.resize(23);
  for (Index i = 0; i < 23; ++i) {
    model.design(i, 0) = 1.0;
    model.design(i, 1) = random.normal();
    model.design(i, 2) = random.uniform(0.0, 2.0);
    model.working[i] = random.normal(1.0 + model.design(i, 2), 1.5);
  }
  return model;
}

VectorXd fitted_values() { return VectorXd::LinSpaced(23, 0.5, 4.0); }

MatrixXd example_factor() {
  MatrixXd factor(2, 2);
  factor << 0.8, 0.0, -0.3, 0.5;
  return factor;
}

/// The same likelihood from the dense covariance matrix V = G^2 + Z D Z'.
double dense_minus_log_likelihood(const LinearMixedModel& model,
                                  const Eigen::ArrayXd& weight,
                                  const MatrixXd& factor) {
  const Index n = model.working.size();
  MatrixXd v = MatrixXd(weight.inverse().matrix().asDiagonal());
  for (std::size_t j = 0; j + 1 < model.group_begin.size(); ++j) {
    const Index begin = model.group_begin[j];
    const Index size = model.group_begin[j + 1] - begin;
    MatrixXd z(size, 2);
    z << model.design.col(0).segment(begin, size), model.design.col(2).segment(begin, size);
    v.block(begin, begin, size, size) += z * factor * factor.transpose() * z.transpose();
  }
  const Eigen::LLT<MatrixXd> decomposed(v);
  const MatrixXd x = decomposed.matrixL().solve(model.design);
  const VectorXd w = decomposed.matrixL().solve(model.working);
  const VectorXd beta = (x.transpose() * x).ldlt().solve(x.transpose() * w);
  const double sigma2 = (w - x * beta).squaredNorm() / static_cast<double>(n);
  return 0.5 * static_cast<double>(n) * (std::log(2.0 * std::numbers::pi * sigma2) + 1.0) +
         MatrixXd(decomposed.matrixL()).diagonal().array().log().sum();
}

double value_at(const LinearMixedModel& model,
                const VarianceModel& variance,
                const VectorXd& parameters,
                const MatrixXd& factor) {
  const ResidualScale scale = variance.scale(fitted_values(), parameters, false);
  return profile(model, GroupMoments(model, scale.weight), scale.sum_log, factor)
      .minus_log_likelihood;
}

}  // namespace

TEST_CASE("the profile likelihood is that of the dense covariance matrix") {
  const LinearMixedModel model = example();
  const VarianceModel variance(parse_variance_function("power"), {.response = fitted_values()});
  const VectorXd parameters = VectorXd::Constant(1, 0.7);
  const ResidualScale scale = variance.scale(fitted_values(), parameters, false);
  // Rounding of a 23 x 23 Cholesky factorisation.
  for (const double size : {1.0, 1e-3, 0.0}) {
    const MatrixXd factor = size * example_factor();
    CHECK(value_at(model, variance, parameters, factor) ==
          Approx(dense_minus_log_likelihood(model, scale.weight, factor)).epsilon(1e-12));
  }
}

TEST_CASE("its gradients equal differences of its values") {
  const LinearMixedModel model = example();
  for (const char* const function : {"exponential", "power", "constant-plus-power"}) {
    const VarianceModel variance(parse_variance_function(function), {.response = fitted_values()});
    const VectorXd parameters = VectorXd::Constant(variance.parameter_count(), 0.6);
    const MatrixXd factor = example_factor();
    const ResidualScale scale = variance.scale(fitted_values(), parameters, true);
    const GroupMoments moments(model, scale.weight);
    const LinearMixedProfile at = profile(model, moments, scale.sum_log, factor);

    // Central differences with step 1e-5 are good to about 1e-9 here.
    constexpr double kStep = 1e-5;
    for (const auto& [row, column] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{1, 1}}) {
      MatrixXd above = factor;
      MatrixXd below = factor;
      above(row, column) += kStep;
      below(row, column) -= kStep;
      const double difference = (value_at(model, variance, parameters, above) -
                                 value_at(model, variance, parameters, below)) /
                                (2.0 * kStep);
      CHECK(at.by_factor(row, column) == Approx(difference).epsilon(1e-7).margin(1e-8));
    }
    const VectorXd by_variance = variance_gradient(model, moments, scale, factor, at);
    for (Index k = 0; k < parameters.size(); ++k) {
      VectorXd above = parameters;
      VectorXd below = parameters;
      above[k] += kStep;
      below[k] -= kStep;
      const double difference =
          (value_at(model, variance, above, factor) - value_at(model, variance, below, factor)) /
          (2.0 * kStep);
      CHECK(by_variance[k] == Approx(difference).epsilon(1e-7).margin(1e-8));
    }
  }
}
