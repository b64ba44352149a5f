// SPDX-License-Identifier: MIT
// Likelihoods with ridges, several modes and steep variances, checked by theory for any data.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "reference.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/fitted_model.hpp"

using namespace silvafit;

namespace {

data::Table rows_of_set(const std::string& set) {
  const data::Table table = data::read_csv_table(
      test::source_file("tests/reference/data/hard_likelihoods.csv"), {.text_columns = {"plot"}});
  return data::rows_where("set == \"" + set + "\"", table);
}

/// A column times a factor.
void scale(const std::string& name, double factor, data::Table& table) {
  std::vector<double> values(table.numbers(name).begin(), table.numbers(name).end());
  for (double& value : values) value *= factor;
  table.set(name, values);
}

fit::FitResult fitted_by(const data::Table& table,
                         const std::string& formula,
                         const std::string& random,
                         const std::string& variance,
                         fit::Method method) {
  fit::ModelSpecification model = fit::specify_model(formula, {}, table);
  fit::add_random_effects(model, random, table);
  model.variance = fit::parse_variance_function(variance);
  return fit::fit_model(model, table, {.method = method});
}

constexpr const char* kLogisticOfX = "y ~ a/(1 + c*exp(-b*x))";

}  // namespace

TEST_CASE("standard errors do not depend on the units of the data") {
  const data::Table table = rows_of_set("rates");
  for (const fit::Method method :
       {fit::Method::kLaplace, fit::Method::kQuadrature, fit::Method::kFirstOrder}) {
    const fit::FittedModel plain = fitted_by(table, kLogisticOfX, "b | plot", "none", method).fit;
    REQUIRE(plain.convergence.converged());
    for (const auto& [x_unit, y_unit] : {std::pair{1e-3, 1.0}, {1e-5, 1e4}, {1.0, 100.0}}) {
      data::Table other = table;
      scale("x", x_unit, other);
      scale("y", y_unit, other);
      const fit::FittedModel fit = fitted_by(other, kLogisticOfX, "b | plot", "none", method).fit;
      INFO(word_of(method) << ", x times " << x_unit << ", y times " << y_unit);
      REQUIRE(fit.convergence.converged());
      const Eigen::Vector3d unit(y_unit, 1.0, 1.0 / x_unit);  // of a, c and b
      for (Eigen::Index j = 0; j < 3; ++j) {
        // Both stop within 1e-5 standard errors of the maximum; the curvature is from differences.
        CHECK(std::abs(fit.estimate[j] / unit[j] - plain.estimate[j]) <
              1e-3 * plain.standard_errors()[j]);
        CHECK(fit.standard_errors()[j] / unit[j] ==
              Approx(plain.standard_errors()[j]).epsilon(1e-4));
      }
    }
  }
}

TEST_CASE("one more random effect does not lower the likelihood, and rows have no order") {
  const data::Table table = rows_of_set("powers");
  std::vector<std::size_t> order(table.rows());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::reverse(order);
  const data::Table reversed = table.select(order);
  for (const fit::Method method :
       {fit::Method::kLaplace, fit::Method::kQuadrature, fit::Method::kInteraction}) {
    INFO(word_of(method));
    const auto likelihood = [&](const data::Table& rows, const char* random) {
      const fit::FittedModel fit = fitted_by(rows, "y ~ a*x^b", random, "power", method).fit;
      CHECK(fit.convergence.converged());
      return fit.log_likelihood;
    };
    const double both = likelihood(table, "a + b | plot");
    // These are not exact likelihoods, of which alone it is certain; the gain here is 0.5.
    CHECK(both > likelihood(table, "a | plot"));
    // Two searches end within 1e-5 standard errors of the maximum, so much lower.
    CHECK(likelihood(reversed, "a + b | plot") == Approx(both).margin(1e-6).epsilon(0.0));
  }
}

TEST_CASE("a constant that outgrows a steep power is not taken for a constant variance") {
  const data::Table table = rows_of_set("steep");
  for (const fit::Method method : {fit::Method::kLindstromBates, fit::Method::kLaplace}) {
    const fit::FitResult result =
        fitted_by(table, kLogisticOfX, "b | plot", "constant-plus-power", method);
    const fit::FittedModel& fit = result.fit;
    INFO(word_of(method) << ": " << fit.convergence.verdict());
    // The reported estimates are those of the likelihood.
    const Eigen::VectorXd fitted_values = result.fitted_conditional;
    const Eigen::VectorXd by_row = fit.residual_sd(fitted_values, table.select(result.rows));
    for (Eigen::Index i = 0; i < by_row.size(); ++i) {
      CHECK(by_row[i] == Approx(result.residual_sd[i]).epsilon(1e-9));
    }
    const bool is_constant = by_row.maxCoeff() < (1.0 + 1e-6) * by_row.minCoeff();
    const auto says = [&](const char* text) {
      return fit.convergence.verdict().find(text) != std::string::npos;
    };
    CHECK(says("the variance is constant") == is_constant);
    // Else it is that of a few observations, or lb says that it is far from the likelihood there.
    // A fixed point near Laplace's maximum (-96.3), at which more observations count, is sound.
    const bool is_sound =
        method == fit::Method::kLindstromBates && fit.log_likelihood > -98.0 && !is_constant;
    CHECK((says("observations only") || says("not reliable here") || is_sound) != is_constant);
  }
  // Laplace's maximum is far above that of a constant variance (-119.2).
  const fit::FittedModel steep =
      fitted_by(table, kLogisticOfX, "b | plot", "constant-plus-power", fit::Method::kLaplace).fit;
  CHECK(steep.log_likelihood > -97.0);
}
