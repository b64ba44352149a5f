// SPDX-License-Identifier: MIT
#include "silvafit/fit/residuals.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "reference.hpp"
#include "silvafit/data/csv.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

data::Table stands() {
  return data::read_csv_table(test::source_file("tests/reference/data/stands.csv"));
}

/// A straight line with random effects of stands and of plots, so that Z is the design itself.
FittedModel line_fit(const data::Table& table, const char* random) {
  ModelSpecification model = specify_model("h ~ a + b*dbh", {}, table);
  add_random_effects(model, random, table);
  model.variance = parse_variance_function("power(dbh)");
  return fit_model(model, table).fit;
}

}  // namespace

TEST_CASE("marginal residuals are decorrelated by the Cholesky factor of Z Psi Z' + R") {
  const data::Table table = stands();
  for (const std::string random : {"a + b | plot", "b | stand; a | plot"}) {
    const FittedModel fit = line_fit(table, random.c_str());
    REQUIRE(fit.convergence.converged());
    const Residuals all = residuals(fit, table);
    const bool is_nested = fit.random.size() > 1;
    const data::TextColumn clusters = table.labels(is_nested ? "stand" : "plot");
    const data::TextColumn plots = table.labels("plot");
    for (const std::string cluster : {is_nested ? "S3" : "S3P2"}) {
      std::vector<std::size_t> rows;
      for (std::size_t row = 0; row < table.rows(); ++row) {
        if (clusters[row] == cluster) rows.push_back(row);
      }
      const auto n = static_cast<Index>(rows.size());
      MatrixXd design(n, 2);
      VectorXd errors(n);
      for (Index i = 0; i < n; ++i) {
        const std::size_t row = rows[static_cast<std::size_t>(i)];
        design.row(i) << 1.0, table.numbers("dbh")[row];
        errors[i] = table.numbers("h")[row] - design.row(i) * fit.estimate;
      }
      MatrixXd covariance(n, n);
      for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) {
          const std::size_t row = rows[static_cast<std::size_t>(i)];
          const std::size_t other = rows[static_cast<std::size_t>(j)];
          double value =
              is_nested ? design(i, 1) * fit.random.front().covariance(0, 0) * design(j, 1) : 0.0;
          if (plots[row] == plots[other]) {
            value += is_nested
                         ? fit.random.back().covariance(0, 0)
                         : design.row(i) * fit.random.back().covariance * design.row(j).transpose();
          }
          if (i == j) {
            value += std::pow(fit.sigma * std::pow(design(i, 1), fit.variance.delta()), 2);
          }
          covariance(i, j) = value;
        }
      }
      const VectorXd expected = covariance.llt().matrixL().solve(errors);
      for (Index i = 0; i < n; ++i) {
        const auto place = static_cast<Index>(rows[static_cast<std::size_t>(i)]);
        // The factor's condition is about 1e3.
        CHECK(all.marginal[place] == Approx(expected[i]).margin(1e-9));
      }
    }
  }
}

TEST_CASE("squares of marginal residuals are those of the linearized likelihood") {
  // At the maximum of the likelihood over sigma, sum e' V^-1 e = N.
  const data::Table table = stands();
  ModelSpecification model = specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {}, table);
  add_random_effects(model, "a + b | plot", table);
  model.variance = parse_variance_function("power");
  const FittedModel fit = fit_model(model, table).fit;
  const Residuals all = residuals(fit, table);
  CHECK(all.marginal.squaredNorm() == Approx(static_cast<double>(table.rows())).epsilon(1e-6));
}

TEST_CASE("residuals are in the order of the table, and unknown groups have b = 0") {
  const data::Table table = stands();
  const FittedModel fit = line_fit(table, "a | plot");
  std::vector<std::size_t> reversed;
  for (std::size_t row = table.rows(); row > 0; --row) reversed.push_back(row - 1);
  data::Table backwards = table.select(reversed);
  const Residuals forward = residuals(fit, table);
  const Residuals back = residuals(fit, backwards);
  CHECK(back.rows.front() == 0);
  CHECK(back.observed[0] == table.numbers("h")[table.rows() - 1]);
  CHECK(back.conditional.standardized.reverse().isApprox(forward.conditional.standardized, 1e-14));
  CHECK(back.group.front() == std::string(table.labels("plot")[table.rows() - 1]));
  data::TextColumn unknown;
  for (std::size_t row = 0; row < table.rows(); ++row) unknown.append("new");
  backwards.set("plot", unknown);
  const Residuals strange = residuals(fit, backwards);
  CHECK(strange.conditional.fitted == strange.population.fitted);
}

TEST_CASE("R2 of a linear random-intercept model follow from its variances") {
  const data::Table table = stands();
  ModelSpecification model = specify_model("h ~ a + b*dbh", {}, table);
  add_random_effects(model, "a | plot", table);
  const FittedModel fit = fit_model(model, table).fit;
  const auto dbh = table.numbers("dbh");
  const Eigen::Map<const Eigen::ArrayXd> x(dbh.data(), static_cast<Index>(dbh.size()));
  const double fixed = std::pow(fit.estimate[1], 2) * (x - x.mean()).square().sum() /
                       static_cast<double>(dbh.size() - 1);
  const double psi = fit.random.back().covariance(0, 0);
  const double total = fixed + psi + fit.sigma * fit.sigma;
  CHECK(fit.r2_marginal == Approx(fixed / total).epsilon(1e-12));
  CHECK(fit.r2_conditional == Approx((fixed + psi) / total).epsilon(1e-12));
  const FittedModel plain = fit_model(specify_model("h ~ a + b*dbh", {}, table), table).fit;
  CHECK(std::isnan(plain.r2_marginal));
}
