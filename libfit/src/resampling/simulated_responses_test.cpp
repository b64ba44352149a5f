// SPDX-License-Identifier: MIT
#include "silvafit/fit/simulated_responses.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"

using namespace silvafit;
using namespace silvafit::fit;

namespace {

/// Two plots whose rows alternate, so that the order of the model differs from that of the table;
/// one row has no response.
data::Table alternating_plots() {
  data::Table table;
  data::TextColumn plot;
  std::vector<double> y;
  for (int i = 0; i < 40; ++i) {
    plot.append(i % 2 == 0 ? "p" : "q");
    y.push_back((i % 2 == 0 ? -100.0 : 100.0) + std::sin(i));
  }
  y[7] = data::kMissing;
  table.set("plot", plot);
  table.set("y", y);
  return table;
}

/// The mean, standard deviation of the residuals and of the plots are known.
FittedModel known_fit(const data::Table& table) {
  ModelSpecification model = specify_model("y ~ mu", {}, table);
  add_random_effects(model, "mu | plot", table);
  FittedModel fit = fit_model(model, table).fit;
  fit.estimate << 5.0;
  fit.random.back().covariance << 9.0;
  fit.sigma = 0.5;
  return fit;
}

}  // namespace

TEST_CASE("simulated responses have the mean and the variances of the fit", "[simulation]") {
  const data::Table table = alternating_plots();
  const FittedModel fit = known_fit(table);
  constexpr std::size_t kReplicates = 4000;
  const SimulatedResponses drawn = simulate_responses(fit, table, kReplicates, 3);
  REQUIRE(drawn.rows.size() == 39);
  CHECK(drawn.rows[6] == 6);
  CHECK(drawn.rows[7] == 8);
  REQUIRE(drawn.values.cols() == kReplicates);
  const Eigen::VectorXd first = drawn.values.row(0);   // plot p
  const Eigen::VectorXd second = drawn.values.row(1);  // plot q
  const Eigen::VectorXd third = drawn.values.row(2);   // plot p
  const auto covariance = [](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return (a.array() - a.mean()).matrix().dot((b.array() - b.mean()).matrix()) /
           static_cast<double>(a.size() - 1);
  };
  // Four standard errors: of a mean of variance 9.25, and of covariances of about 9.25 sqrt(2/R).
  const double error = 4.0 * std::sqrt(9.25 / kReplicates);
  CHECK(first.mean() == Approx(5.0).margin(error));
  const double error_of_variance = 4.0 * 9.25 * std::sqrt(2.0 / kReplicates);
  CHECK(covariance(first, first) == Approx(9.25).margin(error_of_variance));
  CHECK(covariance(first, third) == Approx(9.0).margin(error_of_variance));
  CHECK(covariance(first, second) == Approx(0.0).margin(error_of_variance));
}

TEST_CASE("a simulated replicate depends only on the seed and its number", "[simulation]") {
  const data::Table table = alternating_plots();
  const FittedModel fit = known_fit(table);
  const SimulatedResponses few = simulate_responses(fit, table, 2, 8);
  const SimulatedResponses more = simulate_responses(fit, table, 5, 8);
  CHECK(few.values == more.values.leftCols(2));
  CHECK(few.values != simulate_responses(fit, table, 2, 9).values);
}

TEST_CASE("a fit that has not converged cannot be simulated", "[simulation]") {
  const data::Table table = alternating_plots();
  FittedModel fit = known_fit(table);
  fit.convergence.status = ConvergenceStatus::kDiverged;
  CHECK_THROWS_AS(simulate_responses(fit, table, 1), UsageError);
}
