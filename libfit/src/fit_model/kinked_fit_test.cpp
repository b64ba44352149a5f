// SPDX-License-Identifier: MIT
// Fits of formulas with kinks, which data often put exactly at an observation. Each table has 40
// observations of a plateau from x = 11 on, in 8 groups in turn. bench/r/reference_kinks.R drew
// them and made the expected values, maxima of the profile over m of lm() and lmer(REML = FALSE).
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit::fit;
using Catch::Matchers::Contains;
using silvafit::data::Table;

namespace {

struct Observations {
  std::array<double, 40> x;
  std::array<double, 40> y;
};

constexpr Observations kAtObservation{
    .x = {20.0, 8.0, 2.0,  1.0, 5.0,  16.0, 7.0,  19.0, 3.0,  9.0,  3.0,  5.0, 15.0, 2.0,
          9.0,  2.0, 11.0, 0.0, 20.0, 6.0,  13.0, 6.0,  20.0, 18.0, 20.0, 1.0, 13.0, 10.0,
          19.0, 7.0, 14.0, 5.0, 4.0,  4.0,  8.0,  17.0, 10.0, 16.0, 17.0, 9.0},
    .y = {8.92,  7.353, 4.653, 2.806, 6.136, 8.592, 6.876, 8.796, 4.008, 7.362,
          4.065, 5.859, 8.555, 3.961, 7.29,  3.719, 8.999, 2.447, 8.429, 6.157,
          9.109, 5.65,  8.357, 7.844, 8.304, 3.299, 9.175, 8.296, 8.55,  6.966,
          8.369, 5.496, 5.184, 5.854, 7.362, 8.741, 7.216, 8.659, 8.583, 7.05}};

constexpr Observations kWithLowerMinimum{
    .x = {17.93, 16.19, 15.16, 16.11, 13.35, 10.27, 3.56,  11.26, 5.38,  14.38,
          3.86,  18.49, 1.01,  19.34, 1.85,  18.07, 3.74,  4.05,  5.77,  15.97,
          9.5,   15.42, 19.85, 16.22, 12.68, 16.92, 10.03, 13.26, 10.23, 10.49,
          6.94,  16.18, 4.28,  8.46,  7.55,  15.69, 7.29,  14.63, 7.61,  14.3},
    .y = {7.607, 8.794, 9.318, 8.177, 8.809, 8.253, 5.203, 8.213, 6.249, 7.73,
          4.711, 8.425, 3.765, 8.794, 3.885, 7.913, 5.024, 4.223, 6.381, 9.012,
          8.17,  8.56,  8.287, 8.729, 8.823, 8.806, 7.57,  9.272, 7.494, 8.797,
          6.961, 8.652, 4.363, 8.015, 7.119, 8.411, 7.01,  9.267, 7.058, 8.517}};

constexpr Observations kGroupsWithHigherMaximum{
    .x = {8.0,  16.0, 3.0,  3.0,  11.0, 11.0, 20.0, 8.0,  16.0, 17.0, 15.0, 4.0,  18.0, 3.0,
          18.0, 3.0,  20.0, 9.0,  15.0, 16.0, 1.0,  2.0,  6.0,  14.0, 11.0, 10.0, 6.0,  15.0,
          11.0, 17.0, 13.0, 11.0, 9.0,  5.0,  17.0, 18.0, 5.0,  10.0, 19.0, 10.0},
    .y = {7.008, 8.614, 3.536, 3.964, 7.691, 8.634, 7.481, 7.365, 9.305, 8.482,
          8.496, 4.261, 7.606, 4.512, 9.436, 5.063, 8.556, 8.175, 8.956, 8.584,
          3.703, 3.253, 6.397, 9.78,  9.239, 7.524, 5.791, 7.222, 7.269, 8.766,
          9.699, 9.234, 8.426, 5.313, 8.545, 7.659, 4.334, 8.302, 8.896, 8.545}};

constexpr Observations kGroupsAtObservation{
    .x = {6.36,  12.27, 11.3, 13.79, 12.41, 2.65, 15.72, 19.79, 3.43,  8.53,
          16.34, 19.59, 7.34, 5.05,  18.74, 6.08, 13.03, 18.41, 13.8,  1.74,
          14.81, 14.84, 9.65, 11.5,  1.75,  17.5, 14.46, 5.53,  0.47,  17.76,
          16.42, 14.43, 4.66, 19.02, 8.25,  3.75, 12.39, 5.25,  16.79, 0.34},
    .y = {6.141, 8.447, 8.885, 7.624, 7.443, 3.472, 9.023, 8.629, 5.187, 6.591,
          7.589, 7.487, 5.528, 4.799, 7.912, 5.765, 7.703, 7.864, 8.775, 3.817,
          7.735, 8.387, 7.329, 8.157, 3.514, 8.222, 8.355, 5.687, 2.967, 8.093,
          8.918, 8.737, 5.015, 8.424, 6.585, 3.966, 7.726, 4.27,  8.347, 2.519}};

Table table_of(const Observations& observations) {
  constexpr std::size_t kGroups = 8;
  Table table(observations.x.size());
  table.set("x", {observations.x.begin(), observations.x.end()});
  table.set("y", {observations.y.begin(), observations.y.end()});
  std::vector<double> groups;
  for (std::size_t i = 0; i < observations.x.size(); ++i) {
    groups.push_back(static_cast<double>(i % kGroups));
  }
  table.set("g", groups);
  return table;
}

FittedModel fitted(const Observations& observations,
                   const std::string& formula,
                   std::optional<Method> method = std::nullopt) {
  const Table table = table_of(observations);
  ModelSpecification specification = specify_model(formula, {}, table);
  if (method) specification.random = parse_random_effects("a | g");
  return fit_model(specification, table, {.method = method}).fit;
}

double coefficient(const FittedModel& fit, const std::string& name) {
  const auto place = std::ranges::find(fit.coefficient_names, name);
  return fit.estimate[place - fit.coefficient_names.begin()];
}

}  // namespace

TEST_CASE("a least-squares minimum at an observation's kink is found in any form of the formula") {
  for (const char* formula : {"y ~ a + b*min(x, m)", "y ~ ifelse(x < m, a + b*x, a + b*m)"}) {
    const FittedModel fit = fitted(kAtObservation, formula);
    CAPTURE(formula);
    CHECK(fit.convergence.status == ConvergenceStatus::kConverged);
    CHECK(fit.convergence.has(Evidence::Kind::kKink, "m"));
    CHECK_THAT(fit.convergence.verdict(), Contains("at a kink of the formula in m"));
    CHECK(coefficient(fit, "m") == Approx(11.0).epsilon(1e-12));
    // The likelihood is flat to 1e-10 where the slope along the kink is that of the last digits.
    CHECK(fit.log_likelihood == Approx(-20.177841418).epsilon(0.0).margin(1e-8));
  }
  // The kink is in a combination of coefficients.
  const FittedModel plateau = fitted(kAtObservation, "y ~ min(a + b*x, c)");
  CHECK(plateau.convergence.status == ConvergenceStatus::kConverged);
  CHECK(plateau.log_likelihood == Approx(-20.177841418).epsilon(0.0).margin(1e-8));
}

TEST_CASE("of the minima between kinks the lowest is found") {
  const FittedModel fit = fitted(kWithLowerMinimum, "y ~ a + b*min(x, m)");
  CHECK(fit.convergence.status == ConvergenceStatus::kConverged);
  CHECK_FALSE(fit.convergence.has(Evidence::Kind::kKink, "m"));
  CHECK(coefficient(fit, "m") == Approx(10.73344943).epsilon(1e-6));
  CHECK(fit.log_likelihood == Approx(-25.886918894).epsilon(0.0).margin(1e-8));
}

TEST_CASE("of two breakpoints the best pair is found") {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    silvafit::Random random(seed, 0);
    constexpr Eigen::Index kRows = 40;
    Eigen::VectorXd x(kRows);
    Eigen::VectorXd y(kRows);
    for (Eigen::Index i = 0; i < kRows; ++i) {
      x[i] = random.uniform(0.0, 18.0);
      y[i] = 3.0 + 0.6 * x[i] - 0.5 * std::max(x[i] - 6.0, 0.0) - 0.6 * std::max(x[i] - 12.5, 0.0) +
             0.5 * random.normal();
    }
    // The best of a grid of pairs, each by a linear model.
    const auto squares = [&](double m, double n) {
      Eigen::MatrixXd columns(kRows, 4);
      columns << Eigen::VectorXd::Ones(kRows), x, (x.array() - m).max(0.0).matrix(),
          (x.array() - n).max(0.0).matrix();
      return (y - columns * columns.colPivHouseholderQr().solve(y)).squaredNorm();
    };
    double best = squares(6.0, 12.5);
    for (double m = 0.3; m < 17.5; m += 0.1) {
      for (double n = m + 0.3; n < 17.8; n += 0.1) best = std::min(best, squares(m, n));
    }
    Table table(kRows);
    table.set("x", {x.begin(), x.end()});
    table.set("y", {y.begin(), y.end()});
    const FittedModel fit =
        fit_model(specify_model("y ~ a + b*x + k*max(x - m, 0) + l*max(x - n, 0)", {}, table),
                  table)
            .fit;
    CAPTURE(seed);
    CHECK(fit.convergence.status == ConvergenceStatus::kConverged);
    CHECK(fit.sigma * fit.sigma * (kRows - 6.0) <= best * (1.0 + 1e-9));
  }
}

TEST_CASE("maxima of marginal likelihoods at and between kinks are found") {
  const Method method = GENERATE(Method::kInteraction, Method::kLaplace, Method::kQuadrature);
  const FittedModel at = fitted(kGroupsAtObservation, "y ~ a + b*min(x, m)", method);
  CHECK(at.convergence.status == ConvergenceStatus::kConverged);
  CHECK(at.convergence.has(Evidence::Kind::kKink, "m"));
  CHECK(coefficient(at, "m") == Approx(11.3).epsilon(1e-12));
  // lmer's own tolerance.
  CHECK(at.log_likelihood == Approx(-25.490851911).epsilon(0.0).margin(1e-6));
  const FittedModel between = fitted(kGroupsWithHigherMaximum, "y ~ a + b*min(x, m)", method);
  CHECK(coefficient(between, "m") == Approx(11.17354519).epsilon(1e-5));
  CHECK(between.log_likelihood == Approx(-36.761911145).epsilon(0.0).margin(1e-6));
}

TEST_CASE("a coefficient that changes the mean by steps only is named as such") {
  for (const auto method : {std::optional<Method>(), std::optional(Method::kLindstromBates)}) {
    const FittedModel fit = fitted(kAtObservation, "y ~ a + b*(x > m)", method);
    CHECK(fit.convergence.status == ConvergenceStatus::kNotIdentifiable);
    CHECK_THAT(fit.convergence.verdict(), Contains("the mean changes with m by steps only"));
  }
}

TEST_CASE("where the alternation does not settle at a kink, the message says so") {
  const FittedModel fit =
      fitted(kGroupsAtObservation, "y ~ a + b*min(x, m)", Method::kLindstromBates);
  CHECK_FALSE(fit.convergence.converged());
  CHECK_THAT(fit.convergence.verdict(), Contains("kink in m") && Contains("focei"));
  Table table = table_of(kAtObservation);
  std::vector<double> w(table.numbers("x").begin(), table.numbers("x").end());
  for (double& value : w) value += 1.0;  // a variance of 0 at x = 0 is refused
  table.set("w", w);
  const FittedModel weighted =
      fit_model(specify_model({.formula = "y ~ a + b*min(x, m)", .variance = "power(w)"}, table),
                table)
          .fit;
  CHECK_FALSE(weighted.convergence.converged());
  CHECK_THAT(weighted.convergence.verdict(), Contains("fix it at values near these"));
}
