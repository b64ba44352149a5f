// SPDX-License-Identifier: MIT
// Likelihoods of linear models with several maxima.
#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

struct Rows {
  std::vector<int> group;
  std::vector<double> x;
  std::vector<double> y;

  data::Table table() const {
    data::TextColumn label;
    for (const int g : group) label.append(std::to_string(g));
    data::Table result;
    result.set("g", label);
    result.set("x", x);
    result.set("y", y);
    return result;
  }
};

/// Generalized least squares of y = a + b x with a covariance known up to a factor.
struct DenseFit {
  double log_likelihood;
  VectorXd standard_errors;  ///< with nlme's factor n / (n - 2)

  DenseFit(const Rows& rows, const MatrixXd& relative) {
    const auto n = static_cast<Index>(rows.x.size());
    const auto count = static_cast<double>(n);
    MatrixXd design(n, 2);
    design << VectorXd::Ones(n), VectorXd::Map(rows.x.data(), n);
    const Eigen::LLT<MatrixXd> factor(relative);
    const MatrixXd columns = factor.matrixL().solve(design);
    const VectorXd response = factor.matrixL().solve(VectorXd::Map(rows.y.data(), n));
    const Eigen::HouseholderQR<MatrixXd> decomposition(columns);
    const double squares =
        (response - columns * decomposition.solve(response).eval()).squaredNorm();
    log_likelihood = -0.5 * count * (std::log(2.0 * std::numbers::pi * squares / count) + 1.0) -
                     factor.matrixLLT().diagonal().array().log().sum();
    const MatrixXd covariance =
        (columns.transpose() * columns).llt().solve(MatrixXd::Identity(2, 2));
    standard_errors = (squares / (count - 2.0) * covariance.diagonal()).cwiseSqrt();
  }
};

/// Plots of a line that differ by hundreds of meters in height.
Rows lines_of_plots() {
  Rows rows;
  Random random(5);
  for (int g = 0; g < 5; ++g) {
    const double height = random.normal(0.0, 300.0);
    for (int k = 0; k < 8; ++k) {
      rows.group.push_back(g);
      rows.x.push_back(120.0 + 20.0 * (g + k));
      rows.y.push_back(10.0 + 0.5 * rows.x.back() + height + random.normal(0.0, 6.0));
    }
  }
  return rows;
}

/// The covariance of random intercepts and slopes with one standard deviation, relative to the
/// residual variance.
MatrixXd with_equal_deviations(const Rows& rows, double ratio) {
  const auto n = static_cast<Index>(rows.x.size());
  MatrixXd relative = MatrixXd::Identity(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const auto first = static_cast<std::size_t>(i);
      const auto second = static_cast<std::size_t>(j);
      if (rows.group[first] != rows.group[second]) continue;
      relative(i, j) += ratio * ratio * (1.0 + rows.x[first] * rows.x[second]);
    }
  }
  return relative;
}

/// Nine rows whose residuals shrink with x.
Rows shrinking_residuals(std::uint64_t seed) {
  Rows rows;
  Random random(seed);
  for (int k = 0; k < 9; ++k) {
    rows.group.push_back(k / 3);
    rows.x.push_back(random.uniform(-2.0, 2.0));
    rows.y.push_back(10.0 + 0.5 * rows.x.back() +
                     random.normal(0.0, 0.3 * std::exp(-rows.x.back())));
  }
  return rows;
}

/// Five groups of four such rows.
Rows groups_of_shrinking_residuals(std::uint64_t seed) {
  Rows rows;
  Random random(seed);
  for (int g = 0; g < 5; ++g) {
    const double effect = random.normal(0.0, 0.5);
    for (int k = 0; k < 4; ++k) {
      rows.group.push_back(g);
      rows.x.push_back(random.uniform(-2.0, 2.0));
      const double residual = random.normal(0.0, 0.5 * std::exp(-rows.x.back()));
      rows.y.push_back(10.0 + 0.5 * rows.x.back() + effect + residual);
    }
  }
  return rows;
}

MatrixXd exponential_variances(const Rows& rows, double delta) {
  return (2.0 * delta * VectorXd::Map(rows.x.data(), std::ssize(rows.x)).array())
      .exp()
      .matrix()
      .asDiagonal();
}

}  // namespace

TEST_CASE("a variance that columns of unlike size share is that of the column which varies") {
  // Slopes with a standard deviation of 1 explain most of the heights as well: a lower maximum.
  const Rows rows = lines_of_plots();
  const data::Table table = rows.table();
  const fit::FittedModel fit =
      fit::fit_model(fit::specify_model(fit::ModelTexts{.formula = "y ~ a + b*x",
                                                        .random = "a + b | g",
                                                        .covariance = {"identity"}},
                                        table),
                     table)
          .fit;
  REQUIRE(fit.convergence.converged());
  double highest = -1e300;
  // The second derivative by the logarithm of the ratio is at most about the number of random
  // effects, 10, so that a grid this fine misses less than 1e-4.
  constexpr double kStep = 0.005;
  for (double logarithm = -8.0; logarithm < 8.0; logarithm += kStep) {
    const MatrixXd relative = with_equal_deviations(rows, std::exp(logarithm));
    highest = std::max(highest, DenseFit(rows, relative).log_likelihood);
  }
  CHECK(fit.log_likelihood == Approx(highest).margin(1e-4));
  const double ratio = std::sqrt(fit.random[0].covariance(0, 0)) / fit.sigma;
  const DenseFit dense(rows, with_equal_deviations(rows, ratio));
  CHECK(fit.log_likelihood == Approx(dense.log_likelihood).margin(1e-6));
  CHECK(fit.standard_errors()[0] == Approx(dense.standard_errors[0]).epsilon(1e-6));
  CHECK(fit.standard_errors()[1] == Approx(dense.standard_errors[1]).epsilon(1e-6));
}

TEST_CASE("residuals that grow and residuals that shrink with a column are both tried") {
  // Samples whose likelihood has a lower maximum with residuals that grow.
  for (const std::uint64_t seed : {25, 68, 74, 91}) {
    const Rows rows = shrinking_residuals(seed);
    const data::Table table = rows.table();
    const fit::FittedModel fit =
        fit::fit_model(
            fit::specify_model(
                fit::ModelTexts{.formula = "y ~ a + b*x", .variance = "exponential(x)"}, table),
            table)
            .fit;
    double highest = -1e300;
    // The second derivative by delta is at most 2 sum (x - mean)^2 < 72, so that a grid this fine
    // misses less than 1e-5.
    constexpr double kStep = 0.001;
    for (double delta = -5.0; delta < 5.0; delta += kStep) {
      highest =
          std::max(highest, DenseFit(rows, exponential_variances(rows, delta)).log_likelihood);
    }
    CAPTURE(seed);
    CHECK(fit.convergence.converged());
    CHECK(fit.log_likelihood == Approx(highest).margin(1e-5));
  }
}

TEST_CASE("a maximum without random effects does not hide a higher one with them") {
  for (const std::uint64_t seed : {26, 108}) {
    const Rows rows = groups_of_shrinking_residuals(seed);
    const data::Table table = rows.table();
    const fit::FittedModel fit =
        fit::fit_model(fit::specify_model(fit::ModelTexts{.formula = "y ~ a + b*x",
                                                          .random = "a | g",
                                                          .variance = "exponential(x)"},
                                          table),
                       table)
            .fit;
    CAPTURE(seed);
    REQUIRE(fit.convergence.converged());
    const auto relative = [&](double delta, double ratio) {
      MatrixXd result = exponential_variances(rows, delta);
      for (Index i = 0; i < result.rows(); ++i) {
        for (Index j = 0; j < result.cols(); ++j) {
          const bool is_one_group =
              rows.group[static_cast<std::size_t>(i)] == rows.group[static_cast<std::size_t>(j)];
          if (is_one_group) result(i, j) += ratio * ratio;
        }
      }
      return result;
    };
    for (double delta = -4.0; delta < 4.0; delta += 0.05) {
      for (double logarithm = -6.0; logarithm < 5.0; logarithm += 0.25) {
        const DenseFit dense(rows, relative(delta, std::exp(logarithm)));
        if (dense.log_likelihood > fit.log_likelihood) FAIL_CHECK(delta << " " << logarithm);
      }
    }
    const double ratio = std::sqrt(fit.random[0].covariance(0, 0)) / fit.sigma;
    const DenseFit dense(rows, relative(fit.variance.delta(), ratio));
    CHECK(fit.log_likelihood == Approx(dense.log_likelihood).margin(1e-6));
  }
}

TEST_CASE("powers by stratum of large values reach their maximum") {
  // Many steps of the longest length lead there, since levels of the strata change with powers.
  constexpr int kStrata = 3;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    Rows rows;  // strata are the groups
    for (int i = 0; i < 55; ++i) {
      rows.group.push_back(i % kStrata);
      rows.x.push_back(1e4 * random.uniform(0.5, 10.0));
      rows.y.push_back(2.0 + 5e-5 * rows.x.back() + random.normal(0.0, 0.4));
    }
    const data::Table table = rows.table();
    const fit::FittedModel fit =
        fit::fit_model(
            fit::specify_model(
                fit::ModelTexts{.formula = "y ~ a + b*x", .variance = "power(x | g)"}, table),
            table)
            .fit;
    INFO(seed << ": " << fit.convergence.verdict());
    REQUIRE(fit.convergence.converged());
    const fit::VarianceFactorEstimate& powers = fit.variance.factors[0];
    const auto log_likelihood = [&](const VectorXd& change) {
      VectorXd variances(std::ssize(rows.x));
      for (std::size_t i = 0; i < rows.x.size(); ++i) {
        const auto place = std::ranges::find(powers.strata, std::to_string(rows.group[i]));
        const Index k = place - powers.strata.begin();
        variances[static_cast<Index>(i)] =
            std::exp(2.0 * (powers.delta[k] + change[k]) * std::log(rows.x[i]));
      }
      return DenseFit(rows, variances.asDiagonal()).log_likelihood;
    };
    CHECK(fit.log_likelihood == Approx(log_likelihood(VectorXd::Zero(kStrata))).margin(1e-6));
    for (const double step : {-0.01, 0.01}) {
      CHECK(log_likelihood(VectorXd::Constant(kStrata, step)) < fit.log_likelihood);
      for (Index k = 0; k < kStrata; ++k) {
        CHECK(log_likelihood(step * VectorXd::Unit(kStrata, k)) < fit.log_likelihood);
      }
    }
  }
}
