// SPDX-License-Identifier: MIT
#include "silvafit/fit/least_squares.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "silvafit/base/constants.hpp"

using namespace silvafit::fit;
using Catch::Matchers::Contains;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using silvafit::kInfinity;
using silvafit::data::Table;

namespace {

std::vector<double> column(std::size_t rows, const std::function<double(double)>& value) {
  std::vector<double> result(rows);
  for (std::size_t i = 0; i < rows; ++i) result[i] = value(static_cast<double>(i));
  return result;
}

/// Noise without a random number generator: irregular, bounded by one, mean near zero.
double wobble(double i) { return std::sin(12.9898 * i) + 0.5 * std::cos(78.233 * i + 1.0); }

/// Trees of 5 to 50 cm, heights on Meyer's curve plus noise of a given size.
Table trees(double noise, std::size_t rows = 120) {
  Table table(rows);
  const auto dbh = [rows](double i) { return 5.0 + 45.0 * i / static_cast<double>(rows); };
  table.set("dbh", column(rows, dbh));
  table.set("C", column(rows, [](double i) { return std::fmod(i, 5.0) / 4.0; }));
  table.set("zero", column(rows, [](double) { return 0.0; }));
  table.set("h", column(rows, [&](double i) {
              return 1.3 + 30.0 * (1.0 - std::exp(-0.04 * dbh(i))) + noise * wobble(i);
            }));
  return table;
}

void rescale(Table& table, const std::string& name, double factor) {
  std::vector<double> values(table.numbers(name).begin(), table.numbers(name).end());
  for (double& value : values) value *= factor;
  table.set(name, values);
}

LeastSquaresFit fitted(const std::string& formula,
                       const Table& table,
                       const std::vector<std::string>& sub_models = {},
                       const LeastSquaresOptions& options = {}) {
  return fit_least_squares(NonlinearModel(specify_model(formula, sub_models, table), table),
                           options);
}

const std::string kMeyer = "h ~ 1.3 + a*(1 - exp(-b*dbh))";

}  // namespace

TEST_CASE("a start at which the terms cancel each other is none") {
  // The plateau a - b^2/(4c) of large b and c is any number plus a larger one, which loses the
  // response: no residual is left. R 4: nls() of the same formula from (3, 1, -0.05).
  Table table(30);
  table.set("x",
            {9.0, 10.0, 15.0, 19.0, 0.0, 2.0,  16.0, 18.0, 4.0,  6.0,  17.0, 8.0, 5.0,  16.0, 5.0,
             8.0, 12.0, 10.0, 1.0,  0.0, 17.0, 15.0, 16.0, 10.0, 16.0, 6.0,  9.0, 15.0, 2.0,  6.0});
  table.set("y", {10.793, 10.955, 10.696, 11.356, 3.535,  5.837,  10.509, 11.439, 7.459, 9.875,
                  10.357, 10.954, 8.608,  10.251, 8.431,  10.437, 11.164, 10.345, 3.724, 3.12,
                  10.72,  11.141, 11.456, 9.945,  11.153, 10.082, 10.557, 10.514, 6.096, 9.499});
  const LeastSquaresFit fit =
      fitted("y ~ ifelse(x < -b/(2*c), a + b*x + c*x^2, a - b^2/(4*c))", table);
  REQUIRE(fit.convergence.converged());
  CHECK(fit.log_likelihood == Approx(-16.446874838).margin(1e-6));
  CHECK(fit.estimate[0] == Approx(1.5242724564).epsilon(1e-5));
  CHECK(fit.estimate[1] == Approx(-0.07467037473).epsilon(1e-5));
}

TEST_CASE("a linear model has the closed-form solution") {
  const Table table = trees(1.0);
  const LeastSquaresFit fit = fitted("h ~ a + b*dbh + c*dbh^2", table);

  const Index n = 120;
  const auto dbh = Eigen::Map<const VectorXd>(table.numbers("dbh").data(), n);
  const auto h = Eigen::Map<const VectorXd>(table.numbers("h").data(), n);
  MatrixXd design(n, 3);
  design << VectorXd::Ones(n), dbh, dbh.cwiseAbs2();
  const VectorXd beta = design.householderQr().solve(h);
  const double sum_of_squares = (h - design * beta).squaredNorm();
  const MatrixXd inverse = (design.transpose() * design).inverse();

  // The design's condition number is 1e4, its cross product's 1e8.
  CHECK(fit.convergence.converged());
  for (Index j = 0; j < 3; ++j) {
    CHECK(fit.estimate[j] == Approx(beta[j]).epsilon(1e-11));
    CHECK(fit.standard_errors()[j] ==
          Approx(std::sqrt(sum_of_squares / 117.0 * inverse(j, j))).epsilon(1e-8));
  }
  CHECK(fit.sum_of_squares == Approx(sum_of_squares).epsilon(1e-13));
  CHECK(fit.residual_degrees_of_freedom() == 117.0);
  CHECK(fit.sigma == Approx(std::sqrt(sum_of_squares / 117.0)).epsilon(1e-13));
  // The normal density's logarithm, summed over the observations.
  const double variance = sum_of_squares / 120.0;
  const double log_likelihood = -0.5 * ((h - design * beta).array().square() / variance +
                                        std::log(2.0 * std::numbers::pi * variance))
                                           .sum();
  CHECK(fit.log_likelihood == Approx(log_likelihood).epsilon(1e-13));
  CHECK(fit.parameter_count == 4);
  CHECK(fit.aic() == Approx(-2.0 * log_likelihood + 8.0).epsilon(1e-13));
}

TEST_CASE("the residuals are orthogonal to the slopes at a solution") {
  const Table table = trees(1.0);
  const NonlinearModel model(specify_model(kMeyer, {}, table), table);
  const LeastSquaresFit fit = fit_least_squares(model);
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  MatrixXd jacobian;
  model.evaluate(fit.estimate, mean, &jacobian, workspace);
  const VectorXd residuals = model.response() - mean;
  for (Index j = 0; j < 2; ++j) {
    const double cosine =
        jacobian.col(j).dot(residuals) / (jacobian.col(j).norm() * residuals.norm());
    CHECK(std::abs(cosine) < 1e-13);
  }
  CHECK(fit.convergence.newton_decrement < 1e-20);
  CHECK(fit.convergence.rank == 2);
}

TEST_CASE("a fit to exact data has their coefficients, and a message on the exact fit") {
  const LeastSquaresFit fit = fitted(kMeyer, trees(0.0));
  CHECK(fit.estimate[0] == Approx(30.0).epsilon(1e-12));
  CHECK(fit.estimate[1] == Approx(0.04).epsilon(1e-12));
  CHECK(fit.convergence.converged());
  CHECK(fit.log_likelihood == kInfinity);
  CHECK_THAT(fit.convergence.verdict(), Contains("Perfect fit"));
}

TEST_CASE("the order of the rows does not matter") {
  const Table table = trees(1.0, 500);
  std::vector<std::size_t> order(500);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i * 123 % 500;  // 123 and 500 coprime
  const std::string richards = "h ~ 1.3 + a*(1 - exp(-b*dbh))^c";
  const LeastSquaresFit one = fitted(richards, table);
  const LeastSquaresFit other = fitted(richards, table.select(order));
  for (Index j = 0; j < 3; ++j) CHECK(one.estimate[j] == Approx(other.estimate[j]).epsilon(1e-11));
  CHECK(one.log_likelihood == Approx(other.log_likelihood).epsilon(1e-13));
}

TEST_CASE("many copies of the data have the estimates of one") {
  // Sums of squares are those of one copy times the number of copies; so many observations (24,000)
  // are fitted from a sample on, the single copy is not.
  constexpr std::size_t kCopies = 200;
  const Table once = trees(2.0);
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < kCopies * once.rows(); ++i) rows.push_back(i % once.rows());
  const Table copies = once.select(rows);
  struct Case {
    std::string formula{};
    std::vector<std::string> sub_models{};
  };
  for (const Case& model : {Case{"h ~ 1.3 + a*(1 - exp(-b*dbh))^c"},
                            Case{"h ~ 1.3 + a*exp(-b/(dbh + c))"},
                            Case{kMeyer, {"b ~ 1 + C"}},
                            Case{"h ~ a + b*dbh + c*dbh^2"}}) {
    const LeastSquaresFit one = fitted(model.formula, once, model.sub_models);
    const LeastSquaresFit all = fitted(model.formula, copies, model.sub_models);
    INFO(model.formula);
    REQUIRE(one.convergence.converged());
    CHECK(all.convergence.converged());
    for (Index j = 0; j < one.estimate.size(); ++j) {
      // Both are within 1e-5 standard errors of the optimum: what convergence means.
      CHECK(std::abs(all.estimate[j] - one.estimate[j]) < 2e-5 * one.standard_errors()[j]);
    }
    CHECK(all.sum_of_squares == Approx(kCopies * one.sum_of_squares).epsilon(1e-9));
  }
}

TEST_CASE("a change of unit only rescales the least-squares estimates") {
  struct Case {
    std::string formula;
    std::vector<double> powers;  ///< of the unit of dbh in a, b, c
  };
  const std::vector<Case> cases{{kMeyer, {0.0, -1.0}},
                                {"h ~ 1.3 + a*(1 - exp(-b*dbh))^c", {0.0, -1.0, 0.0}},
                                {"h ~ 1.3 + a/(1 + b*exp(-c*dbh))", {0.0, 0.0, -1.0}},
                                {"h ~ 1.3 + a*exp(-b/dbh)", {0.0, 1.0}},
                                {"h ~ 1.3 + a*exp(-b/(dbh + c))", {0.0, 1.0, 1.0}},
                                {"h ~ 1.3 + dbh^2/(a*dbh + b)^2", {0.0, 1.0}},
                                {"h ~ a + b*dbh + c*dbh^2", {0.0, -1.0, -2.0}}};
  const Table table = trees(1.0);
  for (const Case& model : cases) {
    const LeastSquaresFit centimeters = fitted(model.formula, table);
    for (const double factor : {1e-6, 1e6}) {
      Table other = table;
      rescale(other, "dbh", factor);
      const LeastSquaresFit fit = fitted(model.formula, other);
      INFO(model.formula << " times " << factor);
      CHECK(fit.convergence.converged());
      CHECK(fit.log_likelihood == Approx(centimeters.log_likelihood).margin(1e-8));
      for (Index j = 0; j < fit.estimate.size(); ++j) {
        const double scale = std::pow(factor, model.powers[static_cast<std::size_t>(j)]);
        CHECK(fit.estimate[j] / scale == Approx(centimeters.estimate[j]).epsilon(1e-8));
        CHECK(fit.standard_errors()[j] / scale ==
              Approx(centimeters.standard_errors()[j]).epsilon(1e-8));
      }
    }
  }
}

TEST_CASE("a unit of the response adds to the log-likelihood only") {
  Table table = trees(1.0);
  const LeastSquaresFit meters = fitted("h ~ a*(1 - exp(-b*dbh))", table);
  rescale(table, "h", 1e6);
  const LeastSquaresFit micrometers = fitted("h ~ a*(1 - exp(-b*dbh))", table);
  CHECK(micrometers.log_likelihood ==
        Approx(meters.log_likelihood - 120.0 * std::log(1e6)).margin(1e-8));
  CHECK(micrometers.estimate[0] == Approx(1e6 * meters.estimate[0]).epsilon(1e-10));
  CHECK(micrometers.estimate[1] == Approx(meters.estimate[1]).epsilon(1e-10));
}

TEST_CASE("of mirror images the one with positive coefficients is reported") {
  const LeastSquaresFit fit = fitted("h ~ 1.3 + dbh^2/(a*dbh + b)^2", trees(1.0));
  CHECK(fit.estimate.minCoeff() > 0.0);
}

TEST_CASE("repeated fits are the same to the last bit") {
  const Table table = trees(1.0);
  const std::string weibull = "h ~ 1.3 + a*(1 - exp(-b*dbh^c))";
  CHECK(fitted(weibull, table).estimate == fitted(weibull, table).estimate);
}

TEST_CASE("two codings of the same groups are the same model") {
  Table table = trees(1.0);
  table.set("left", column(120, [](double i) { return i < 60.0 ? 1.0 : 0.0; }));
  table.set("right", column(120, [](double i) { return i < 60.0 ? 0.0 : 1.0; }));
  const LeastSquaresFit contrast = fitted(kMeyer, table, {"b ~ 1 + right"});
  const LeastSquaresFit levels = fitted(kMeyer, table, {"b ~ 0 + left + right"});
  CHECK(levels.log_likelihood == Approx(contrast.log_likelihood).epsilon(1e-13));
  CHECK(levels.estimate[1] == Approx(contrast.estimate[1]).epsilon(1e-10));
  CHECK(levels.estimate[2] == Approx(contrast.estimate[1] + contrast.estimate[2]).epsilon(1e-10));
}

TEST_CASE("a covariate can only improve the fit, and has its true effect") {
  Table table = trees(0.0);
  table.set("h", column(120, [&](double i) {
              const auto row = static_cast<std::size_t>(i);
              const double rate = 0.04 - 0.01 * table.numbers("C")[row];
              return 1.3 + 30.0 * (1.0 - std::exp(-rate * table.numbers("dbh")[row])) +
                     1e-6 * wobble(i);
            }));
  const LeastSquaresFit without = fitted(kMeyer, table);
  const LeastSquaresFit with = fitted(kMeyer, table, {"b ~ 1 + C"});
  CHECK(with.coefficient_names == std::vector<std::string>{"a", "b", "b:C"});
  CHECK(with.log_likelihood > without.log_likelihood);
  CHECK(with.estimate[2] == Approx(-0.01).epsilon(1e-5));  // noise 1e-6
}

TEST_CASE("a complete start decides which of several minima is found") {
  Table table(60);
  table.set("x", column(60, [](double i) { return i / 10.0; }));
  table.set("y", column(60, [](double i) { return std::sin(3.0 * i / 10.0) + 0.1 * wobble(i); }));
  const auto frequency = [&](double start) {
    return fitted("y ~ sin(b*x)", table, {}, {.start = {{"b", start}}}).estimate[0];
  };
  CHECK(frequency(2.9) == Approx(3.0).epsilon(0.01));
  CHECK(frequency(20.0) > 10.0);
  CHECK(fitted("y ~ sin(b*x)", table).estimate[0] == Approx(3.0).epsilon(0.01));
}

TEST_CASE("too few observations give a convergence message") {
  const LeastSquaresFit fit = fitted("h ~ 1.3 + a*(1 - exp(-b*dbh))^c", trees(1.0, 2));
  CHECK_FALSE(fit.convergence.converged());
  CHECK_THAT(fit.convergence.verdict(),
             Contains("3 coefficients need") && Contains("there are 2."));
  CHECK(fit.estimate.array().isNaN().all());
}

TEST_CASE("with as many observations as coefficients there are no residuals") {
  const LeastSquaresFit fit = fitted("h ~ a + b*dbh", trees(1.0, 2));
  CHECK(fit.convergence.converged());
  CHECK_THAT(fit.convergence.verdict(), Contains("Perfect fit"));
  CHECK(std::isnan(fit.sigma));
}

TEST_CASE("a formula without coefficients cannot be fitted") {
  CHECK_THROWS_AS(fitted("h ~ 1.3 + dbh", trees(1.0)), silvafit::UsageError);
}

TEST_CASE("the place of a narrow peak is found anywhere in the data") {
  constexpr std::size_t kRows = 101;
  for (const double place : {112.0, 137.0, 188.5}) {
    Table table(kRows);
    table.set("x", column(kRows, [](double i) { return 100.0 + i; }));
    table.set("y", column(kRows, [&](double i) {
                const double z = (100.0 + i - place) / 2.0;
                return 5.0 * std::exp(-z * z) + 0.1 * wobble(i);
              }));
    const LeastSquaresFit fit = fit_least_squares(
        NonlinearModel(specify_model("y ~ A*exp(-((x - m)/2)^2)", {}, table), table));
    REQUIRE(fit.convergence.converged());
    // The standard error of the place is about 0.02.
    CHECK(fit.estimate[1] == Approx(place).margin(0.1));
  }
}

// Five distinct x and five coefficients: every minimum has the means of the rows of an x, so that
// all have the same sum of squares, that within these rows.
TEST_CASE("with a given phase, frequencies of both signs are different minima") {
  constexpr std::size_t kRows = 40;
  constexpr double kFrequency = 4.6;
  const auto x_of = [](double i) { return 0.8 + 0.4 * std::fmod(i, 5.0); };
  Table table(kRows);
  table.set("x", column(kRows, x_of));
  table.set("x2", column(kRows, [&](double i) { return x_of(i) * x_of(i); }));
  table.set("y", column(kRows, [&](double i) {
              const double x = x_of(i);
              return -4.3 + 5.6 * x + 1.3 * x * x -
                     0.14 * std::cos(kFrequency * x + std::numbers::pi / 4.0) + 0.001 * wobble(i);
            }));
  VectorXd within = VectorXd::Zero(5);
  VectorXd mean = VectorXd::Zero(5);
  for (std::size_t i = 0; i < kRows; ++i) {
    mean[static_cast<Index>(i % 5)] += table.numbers("y")[i] / (kRows / 5.0);
  }
  for (std::size_t i = 0; i < kRows; ++i) {
    const auto k = static_cast<Index>(i % 5);
    within[k] += std::pow(table.numbers("y")[i] - mean[k], 2);
  }
  const LeastSquaresFit fit = fitted(
      "y ~ A + B*cos(w*x + 0.7853981633974483)", table, {"A ~ 1 + x + x2"}, {.other_minima = true});
  CHECK(fit.sum_of_squares == Approx(within.sum()).epsilon(1e-6));
  std::vector<double> found{fit.estimate[4]};
  for (const VectorXd& other : fit.other_minima) found.push_back(other[4]);
  const auto near = [](double w) {
    return [w](double value) { return std::abs(value - w) < 0.05; };
  };
  CHECK(std::ranges::any_of(found, near(kFrequency)));
  // Higher ones have the values of lower ones.
  const double highest = std::numbers::pi / 0.4;
  CHECK(std::ranges::all_of(found, [&](double w) { return std::abs(w) <= highest; }));
  // The curve reaches all means if the third differences of the cosine are proportional to theirs.
  const auto mismatch = [&](double w) {
    VectorXd wave(5);
    for (Index k = 0; k < 5; ++k) {
      wave[k] = std::cos(w * x_of(static_cast<double>(k)) + std::numbers::pi / 4.0);
    }
    const auto difference = [](const VectorXd& of, Index k) {
      return of[k + 3] - 3.0 * of[k + 2] + 3.0 * of[k + 1] - of[k];
    };
    return difference(wave, 0) * difference(mean, 1) - difference(wave, 1) * difference(mean, 0);
  };
  constexpr double kStep = 0.01;
  std::size_t frequencies = 0;
  for (double w = -highest + kStep; w < highest - kStep; w += kStep) {
    const bool is_constant = std::abs(w) < 0.1;  // a wave without differences
    if (is_constant || mismatch(w) * mismatch(w + kStep) > 0.0) continue;
    INFO(w);
    ++frequencies;
    CHECK(std::ranges::any_of(found, near(w)));
  }
  CHECK(frequencies > 6);
}

TEST_CASE("a kink in a coefficient does not pass for linear") {
  // Both forms are a line of slope a; in the first, a is known up to its sign.
  const LeastSquaresFit kinked = fitted("h ~ abs(a)*dbh", trees(1.0));
  const LeastSquaresFit line = fitted("h ~ a*dbh", trees(1.0));
  CHECK(kinked.convergence.converged());
  CHECK(kinked.estimate[0] == Approx(line.estimate[0]).epsilon(1e-10));
}

TEST_CASE("a covariate without effect is near zero, not undetermined") {
  Table table = trees(1.0);
  table.set("none", column(120, [](double i) { return std::sin(3.3 * i); }));
  const LeastSquaresFit fit = fitted(kMeyer, table, {"b ~ 1 + none"});
  CHECK(fit.convergence.converged());
  CHECK_THAT(fit.convergence.verdict(), !Contains("determined"));
}

TEST_CASE("a constant response is fitted by a constant") {
  Table table = trees(0.0);
  table.set("h", column(120, [](double) { return 20.0; }));
  const LeastSquaresFit line = fitted("h ~ a + b*dbh", table);
  CHECK(line.estimate[0] == Approx(20.0).epsilon(1e-14));
  CHECK(line.estimate[1] == Approx(0.0).margin(1e-14));
  CHECK(line.log_likelihood == kInfinity);
  // Meyer's curve is constant only for an infinite rate.
  const LeastSquaresFit curve = fitted(kMeyer, table);
  CHECK_FALSE(curve.convergence.converged());
  CHECK_THAT(curve.convergence.verdict(), Contains("b goes to a limit"));
}

TEST_CASE("a covariate without variation is named") {
  const LeastSquaresFit fit = fitted(kMeyer, trees(1.0), {"b ~ 1 + zero"});
  const LeastSquaresFit without = fitted(kMeyer, trees(1.0));
  CHECK_FALSE(fit.convergence.converged());
  CHECK(fit.convergence.rank == 2);
  CHECK_THAT(fit.convergence.verdict(), Contains("b:zero"));
  CHECK(fit.log_likelihood == Approx(without.log_likelihood).epsilon(1e-13));
  CHECK(std::isnan(fit.standard_errors()[2]));
  // The others keep their standard errors, except for the used degree of freedom.
  CHECK(fit.standard_errors()[1] ==
        Approx(without.standard_errors()[1] * std::sqrt(118.0 / 117.0)).epsilon(1e-9));
}

TEST_CASE("coefficients that are not separately identifiable are named") {
  const LeastSquaresFit fit = fitted("h ~ 1.3 + a*d*(1 - exp(-b*dbh))", trees(1.0));
  CHECK_FALSE(fit.convergence.converged());
  CHECK(fit.convergence.rank == 2);
  CHECK_THAT(fit.convergence.verdict(), Contains("a and d are not identifiable"));
  CHECK(std::isfinite(fit.standard_errors()[2]));
  CHECK(std::isnan(fit.standard_errors()[0]));
}

TEST_CASE("coefficients that run to infinity are no solution") {
  // A power curve is the limit of Richards' curve for a to infinity and b to zero.
  Table table = trees(0.0);
  table.set("h", column(120, [&](double i) {
              return 2.0 * std::pow(table.numbers("dbh")[static_cast<std::size_t>(i)], 0.6) +
                     0.2 * wobble(i) + 1e-4 * i * i;
            }));
  const LeastSquaresFit power = fitted("h ~ a*dbh^b", table);
  const LeastSquaresFit fit = fitted("h ~ a*(1 - exp(-b*dbh))^c", table);
  CHECK_FALSE(fit.convergence.converged());
  CHECK(fit.log_likelihood == Approx(power.log_likelihood).margin(1e-3));
  CHECK_THAT(fit.convergence.verdict(), Contains("a and b go to a limit"));
}

TEST_CASE("a row where the formula is not defined is named") {
  Table table = trees(1.0);
  std::vector<double> dbh(table.numbers("dbh").begin(), table.numbers("dbh").end());
  dbh[17] = -3.0;
  table.set("dbh", dbh);
  std::vector<std::uint32_t> lines(120);
  std::iota(lines.begin(), lines.end(), 2U);
  table.set_origin("trees.csv", lines);
  CHECK_THROWS_AS(fitted("h ~ a + b*log(dbh)", table), silvafit::DomainError);
  CHECK_THROWS_WITH(fitted("h ~ a + b*log(dbh)", table), Contains("trees.csv:19"));
  CHECK_THROWS_WITH(fitted("h ~ 1.3 + a*dbh^b", table), Contains("trees.csv:19"));
  CHECK_THROWS_WITH(fitted(kMeyer, table, {"b ~ 1 + log(dbh)"}), Contains("trees.csv:19"));
}

TEST_CASE("sums of curves with many coefficients are fitted without starts") {
  // Least squares can be no worse than the truth that made the data.
  constexpr std::size_t kRows = 60;
  const auto check = [&](const char* formula, const std::function<double(double)>& truth) {
    INFO(formula);
    const auto x = [](double i) { return 0.25 * i; };
    Table table(kRows);
    table.set("x", column(kRows, x));
    table.set("y", column(kRows, [&](double i) { return truth(x(i)) + 0.1 * wobble(i + 0.5); }));
    double of_truth = 0.0;
    for (std::size_t i = 0; i < kRows; ++i) {
      of_truth += std::pow(table.numbers("y")[i] - truth(table.numbers("x")[i]), 2);
    }
    const LeastSquaresFit fit = fitted(formula, table);
    CHECK(fit.convergence.converged());
    CHECK(fit.sum_of_squares <= of_truth);
  };
  check("y ~ h*exp(-((x - m)/s)^2) + k*exp(-((x - n)/t)^2)", [](double x) {
    return 5.0 * std::exp(-std::pow((x - 4.0) / 1.2, 2)) +
           3.0 * std::exp(-std::pow((x - 10.0) / 1.8, 2));
  });
  check("y ~ a/(1 + exp((m - x)/s)) + b/(1 + exp((n - x)/t))", [](double x) {
    return 4.0 / (1.0 + std::exp((3.0 - x) / 0.5)) + 3.0 / (1.0 + std::exp((10.0 - x) / 0.7));
  });
}
