// SPDX-License-Identifier: MIT
// Prediction intervals of means with many unknown arguments, linear and nonlinear.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "prediction/nonlinear_directions.hpp"
#include "silvafit/fit/prediction.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using silvafit::data::Table;
using namespace silvafit::fit;

namespace {

constexpr double kFreedom = 1e9;  // t is normal

/// A fit without random effects.
FittedModel model(const std::string& right, const std::vector<std::string>& coefficients) {
  FittedModel fit({.formula = silvafit::data::parse_formula("y ~ " + right)});
  for (const std::string& name : coefficients) {
    fit.specification.parameters.push_back(parse_parameter_model(name + " ~ 1"));
  }
  fit.coefficient_names = coefficients;
  const auto p = static_cast<Index>(coefficients.size());
  fit.estimate = VectorXd::Zero(p);
  fit.covariance = MatrixXd::Identity(p, p);
  fit.degrees_of_freedom = VectorXd::Constant(p, kFreedom);
  fit.sigma = 1.0;
  return fit;
}

std::vector<std::string> names(int count) {
  std::vector<std::string> result;
  result.reserve(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) result.push_back(fmt::format("b{}", k));
  return result;
}

/// "b0 + b1*x1 + b2*x2 ..."
std::string straight_line(int slopes) {
  std::string text = "b0";
  for (int k = 1; k <= slopes; ++k) text += fmt::format(" + b{}*x{}", k, k);
  return text;
}

/// Columns x1, x2 ... without a pattern.
Table columns(int count, std::size_t rows) {
  Table table;
  for (int k = 1; k <= count; ++k) {
    std::vector<double> values;
    for (std::size_t row = 0; row < rows; ++row) {
      values.push_back(std::sin(1.7 * k + 2.3 * static_cast<double>(row)));
    }
    table.set(fmt::format("x{}", k), std::move(values));
  }
  return table;
}

/// A covariance matrix with correlations.
MatrixXd correlated(Index size) {
  MatrixXd result = MatrixXd::Identity(size, size);
  for (Index i = 0; i < size; ++i) {
    for (Index j = 0; j < size; ++j) result(i, j) = std::pow(-0.4, std::abs(i - j)) * 0.01;
  }
  return result;
}

/// (rows) variances of straight_line().
VectorXd variances(const Table& table, const MatrixXd& covariance) {
  MatrixXd x = MatrixXd::Ones(static_cast<Index>(table.rows()), covariance.rows());
  for (Index k = 1; k < x.cols(); ++k) {
    const auto values = table.numbers(fmt::format("x{}", k));
    for (Index row = 0; row < x.rows(); ++row) x(row, k) = values[static_cast<std::size_t>(row)];
  }
  return (x * covariance).cwiseProduct(x).rowwise().sum();
}

/// P(f(u) + e < limit) for a standard normal u and e with a standard deviation, by the trapezoid
/// rule with steps of 1/200.
template <typename Function>
double probability_below(double limit, double deviation, const Function& f) {
  double below = 0.0;
  double total = 0.0;
  for (int k = -1600; k <= 1600; ++k) {
    const double u = k / 200.0;
    const double weight = std::exp(-0.5 * u * u);
    total += weight;
    below += weight * 0.5 * std::erfc((f(u) - limit) / deviation / std::sqrt(2.0));
  }
  return below / total;
}

NonlinearDirections directions(const FittedModel& fit, const Table& table, bool split) {
  const RowMean mean(fit.specification, table);
  const MatrixXd center = mean.arguments(fit.estimate, std::vector<Index>(table.rows(), 0));
  const MatrixXd root = fit.covariance.llt().matrixL();
  return nonlinear_directions(mean,
                              center,
                              mean.gradient(center),
                              std::vector<MatrixXd>(table.rows(), root),
                              VectorXd::Constant(center.rows(), 1e-9),
                              split)
      .front();
}

}  // namespace

TEST_CASE("directions in which the mean is linear need no points") {
  const Table table = columns(8, 1);
  FittedModel fit = model(straight_line(8), names(9));
  fit.covariance = correlated(9);
  const double deviation = std::sqrt(variances(table, fit.covariance)[0]);
  SECTION("all directions of a linear model") {
    const NonlinearDirections found = directions(fit, table, true);
    CHECK(found.root.cols() == 0);
    CHECK(found.linear == Approx(deviation).epsilon(1e-12));
  }
  SECTION("all but one if the residual standard deviation depends on the mean") {
    const NonlinearDirections found = directions(fit, table, false);
    REQUIRE(found.root.cols() == 1);
    CHECK(found.linear == Approx(0.0).margin(1e-12));
  }
  SECTION("all but that of a function of one sum") {
    fit.specification.formula = silvafit::data::parse_formula("y ~ exp(" + straight_line(8) + ")");
    const NonlinearDirections found = directions(fit, table, true);
    CHECK(found.root.cols() == 1);
    CHECK(found.linear == Approx(0.0).margin(1e-9));
  }
  SECTION("nonlinear directions need points") {
    fit.specification.formula =
        silvafit::data::parse_formula("y ~ " + straight_line(7) + " + b8^2");
    fit.covariance = MatrixXd::Identity(9, 9);
    const NonlinearDirections found = directions(fit, table, true);
    REQUIRE(found.root.cols() == 1);
    CHECK(std::abs(found.root(8, 0)) == Approx(1.0).epsilon(1e-9));
    CHECK(found.linear ==
          Approx(std::sqrt(variances(table, MatrixXd::Identity(8, 8))[0])).epsilon(1e-9));
  }
}

TEST_CASE("a mean that is nonlinear only if several arguments change together is recognized") {
  // At a = 1 and b = 0 the mean a b does not change with a, at a = b = c = 0 the product of three
  // with none.
  FittedModel two = model("a*b + 0*x1", {"a", "b"});
  two.estimate[0] = 1.0;
  CHECK(directions(two, columns(1, 1), true).root.cols() == 2);
  CHECK(directions(model("a*b*c + 0*x1", {"a", "b", "c"}), columns(1, 1), true).root.cols() == 3);
}

TEST_CASE("predicted intervals of a linear model with many slopes are those of t") {
  // A product of three points a slope would have 7e7 points a row.
  constexpr int kSlopes = 14;
  FittedModel fit = model(straight_line(kSlopes), names(kSlopes + 1));
  fit.covariance = correlated(kSlopes + 1);
  fit.degrees_of_freedom.setConstant(6.0);
  const Table table = columns(kSlopes, 5000);
  const Prediction prediction =
      predict(fit, table, Level::kPopulation, {.interval = 0.95, .threads = 2});
  const VectorXd variance = variances(table, fit.covariance);
  const boost::math::students_t_distribution<double> t(6.0);
  const VectorXd margin =
      boost::math::quantile(t, 0.975) * (variance.array() + 1.0).sqrt().matrix();
  // The quantile is searched for to 1e-10.
  CHECK((prediction.upper - prediction.value - margin).cwiseAbs().maxCoeff() < 1e-8);
  CHECK((prediction.value - prediction.lower - margin).cwiseAbs().maxCoeff() < 1e-8);
}

TEST_CASE(
    "predicted intervals of a function of one sum, or with linear terms beside it, are exact") {
  const Table table = columns(8, 3);
  FittedModel fit = model("exp(" + straight_line(8) + ")", names(9));
  fit.covariance = correlated(9);
  fit.sigma = GENERATE(0.02, 0.2, 1.0);
  const bool has_term = GENERATE(false, true);
  MatrixXd of_sum = fit.covariance;
  if (has_term) {  // exp(b0 + ... + b7 x7) + b8 x8
    fit.specification.formula =
        silvafit::data::parse_formula("y ~ exp(" + straight_line(7) + ") + b8*x8");
    fit.covariance.row(8).head(8).setZero();
    fit.covariance.col(8).head(8).setZero();
    of_sum = fit.covariance.topLeftCorner(8, 8);
  }
  const VectorXd variance = variances(table, of_sum);
  const Prediction prediction = predict(fit, table, Level::kPopulation, {.interval = 0.95});
  for (Index row = 0; row < 3; ++row) {
    const double x8 = table.numbers("x8")[static_cast<std::size_t>(row)];
    const double straight = has_term ? x8 * x8 * fit.covariance(8, 8) : 0.0;
    const double deviation = std::sqrt(fit.sigma * fit.sigma + straight);
    const auto f = [&](double u) { return std::exp(std::sqrt(variance[row]) * u); };
    INFO(fit.sigma << " " << has_term << " " << row);
    // As far as components have the variance of their neighborhood but not its skewness.
    CHECK(probability_below(prediction.lower[row], deviation, f) == Approx(0.025).epsilon(0.005));
    CHECK(1.0 - probability_below(prediction.upper[row], deviation, f) ==
          Approx(0.025).epsilon(0.005));
  }
}

TEST_CASE("many nonlinear directions have a bounded number of points") {
  // A sum of squares of standard normal variables is chi-squared.
  const int count = GENERATE(3, 5, 6, 12, 30);
  std::string sum = "0*x1";
  for (const std::string& name : names(count)) sum += " + " + name + "^2";
  const FittedModel fit = model(sum, names(count));
  CHECK(directions(fit, columns(1, 1), true).root.cols() == count);
  const Prediction prediction = predict(fit, columns(1, 20), Level::kPopulation, {.interval = 0.9});
  const boost::math::chi_squared_distribution<double> chi_squared(count);
  const auto f = [&](double u) {
    return boost::math::quantile(chi_squared, 0.5 * std::erfc(-u / std::sqrt(2.0)));
  };
  INFO(count << " " << prediction.lower[0] << " " << prediction.upper[0]);
  // The variance of 500 sums of squares is off by one part in 16 (a standard error); a tail of 5 %
  // then by less than one point, and by as much again with many variables, which 500 points have
  // correlations between.
  CHECK(probability_below(prediction.lower[0], 1.0, f) == Approx(0.05).margin(0.02));
  CHECK(1.0 - probability_below(prediction.upper[0], 1.0, f) == Approx(0.05).margin(0.02));
}
