// SPDX-License-Identifier: MIT
#include "least_squares/periodic_coefficients.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"

using namespace silvafit;
using namespace silvafit::fit;

namespace {

/// y = 12 + 3 cos(w t + 0.7) + noise of sd 1.
data::Table wave(const std::vector<double>& times, double frequency, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> y;
  for (const double t : times)
    y.push_back(12.0 + 3.0 * std::cos(frequency * t + 0.7) + random.normal());
  data::Table table;
  table.set("t", times);
  table.set("y", y);
  return table;
}

std::vector<double> regular(std::size_t count, double spacing) {
  std::vector<double> result;
  for (std::size_t i = 0; i < count; ++i) result.push_back(spacing * static_cast<double>(i));
  return result;
}

std::vector<double> irregular(std::size_t count, double range) {
  Random random(17);
  std::vector<double> result;
  for (std::size_t i = 0; i < count; ++i) result.push_back(random.uniform(0.0, range));
  return result;
}

NonlinearModel bound(const std::string& formula, const data::Table& table) {
  return {specify_model(formula, {}, table), table};
}

const std::string kWave = "y ~ A + B*cos(w*t) + C*sin(w*t)";
/// Place of the frequency among the coefficients: A, B, w, C, as the formula names them.
constexpr Eigen::Index kFrequency = 2;

/// Standard deviation of the least-squares estimate of a frequency, for amplitude 3 and sd 1.
/// Source: Rife and Boorstyn 1974, IEEE Transactions on Information Theory 20, 591-598: the bound
/// var(w) = sigma^2 / (amplitude^2/2 * sum (t - mean)^2).
double frequency_error(const std::vector<double>& times) {
  double mean = 0.0;
  for (const double t : times) mean += t / static_cast<double>(times.size());
  double sum = 0.0;
  for (const double t : times) sum += (t - mean) * (t - mean);
  return 1.0 / std::sqrt(0.5 * 9.0 * sum);
}

}  // namespace

TEST_CASE("identifiable frequencies are those up to Nyquist's") {
  const data::Table table = wave(regular(101, 0.1), 6.0, 1);
  const auto found = periodic_coefficients(bound(kWave, table));
  REQUIRE(found.size() == 1);
  CHECK(found[0].coefficient == kFrequency);
  CHECK_FALSE(found[0].is_period);
  const double nyquist = std::numbers::pi / 0.1;
  CHECK(found[0].value(static_cast<double>(found[0].count)) == Approx(nyquist));
  CHECK(found[0].contains(-0.99 * nyquist));
  CHECK_FALSE(found[0].contains(1.01 * nyquist));
  CHECK(found[0].step == Approx(2.0 * std::numbers::pi / 10.0 / 4.0));

  const auto period = periodic_coefficients(bound("y ~ A + B*sin(2*pi*(t - s)/P)", table));
  REQUIRE(period.size() == 1);
  CHECK(period[0].is_period);
  CHECK(period[0].value(static_cast<double>(period[0].count)) == Approx(0.2));
  CHECK(period[0].contains(0.3));
  CHECK_FALSE(period[0].contains(0.1));

  // A phase is not a frequency, nor is a parameter in a nonlinear argument.
  CHECK(periodic_coefficients(bound("y ~ A*sin(s + t)", table)).empty());
  CHECK(periodic_coefficients(bound("y ~ A*exp(-k*t)", table)).empty());
  CHECK(periodic_coefficients(bound("y ~ A*sin(exp(k*t))", table)).empty());
}

TEST_CASE("a frequency is found without a start value") {
  // From one wave over the data to one of three observations.
  const std::vector<double> times = regular(101, 0.1);
  for (const double frequency : {0.9, 3.0, 6.2, 13.0, 21.0, 29.0}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      INFO("w = " << frequency << ", seed " << seed);
      const data::Table table = wave(times, frequency, seed);
      const FittedModel fit = fit_model(specify_model(kWave, {}, table), table).fit;
      REQUIRE(fit.convergence.converged());
      CHECK(fit.estimate[kFrequency] == Approx(frequency).margin(5.0 * frequency_error(times)));
    }
  }
}

TEST_CASE("a frequency is found in observations at irregular times, or as a period") {
  const std::vector<double> times = irregular(60, 20.0);
  for (const double frequency : {0.5, 2.0, 7.0}) {
    INFO("w = " << frequency);
    const data::Table table = wave(times, frequency, 4);
    const FittedModel fit = fit_model(specify_model(kWave, {}, table), table).fit;
    REQUIRE(fit.convergence.converged());
    CHECK(fit.estimate[kFrequency] == Approx(frequency).margin(5.0 * frequency_error(times)));
    const FittedModel period =
        fit_model(specify_model("y ~ A + B*cos(2*pi*t/P) + C*sin(2*pi*t/P)", {}, table), table).fit;
    REQUIRE(period.convergence.converged());
    CHECK(period.log_likelihood == Approx(fit.log_likelihood).epsilon(1e-9));
    CHECK(std::abs(period.estimate[kFrequency]) ==
          Approx(2.0 * std::numbers::pi / fit.estimate[kFrequency]).epsilon(1e-6));
  }
}

TEST_CASE("with a given phase a negative frequency differs from a positive one") {
  const std::vector<double> times = regular(101, 0.1);
  const data::Table table = wave(times, 6.2, 1);
  // 12 + 3 cos(6.2 t + 0.7) is 12 + 3 cos(-6.2 t - 0.7).
  const FittedModel fit =
      fit_model(specify_model("y ~ A + B*cos(w*t - 0.7)", {}, table), table).fit;
  REQUIRE(fit.convergence.converged());
  CHECK(fit.estimate[kFrequency] == Approx(-6.2).margin(5.0 * frequency_error(times)));
}

TEST_CASE("a frequency is found in the residuals of a covariate's effect") {
  const std::vector<double> times = regular(101, 0.1);
  for (const std::uint64_t seed : {1, 2, 3}) {
    INFO("seed " << seed);
    data::Table table = wave(times, 6.2, seed);
    // A stronger and slower wave, which a fit without the covariate takes for the frequency.
    std::vector<double> level;
    std::vector<double> y(table.numbers("y").begin(), table.numbers("y").end());
    for (std::size_t i = 0; i < times.size(); ++i) {
      level.push_back(std::sin(1.3 * times[i]));
      y[i] += 30.0 * level.back();
    }
    table.set("y", y);
    table.set("level", level);
    const ModelSpecification specification = specify_model(kWave, {"A ~ 1 + level"}, table);
    const FittedModel fit = fit_model(specification, table).fit;
    REQUIRE(fit.convergence.converged());
    const auto place =
        std::ranges::find(fit.coefficient_names, "w") - fit.coefficient_names.begin();
    CHECK(fit.estimate[place] == Approx(6.2).margin(5.0 * frequency_error(times)));
  }
}

TEST_CASE("a given frequency is used as start for any Nyquist frequency") {
  const std::vector<double> times = regular(101, 0.1);
  const data::Table table = wave(times, 6.2, 1);
  const double alias = 6.2 + 2.0 * std::numbers::pi / 0.1;
  FitModelOptions options;
  options.start = {{"A", 12.0}, {"B", 2.0}, {"C", -2.0}, {"w", alias}};
  const FittedModel fit = fit_model(specify_model(kWave, {}, table), table, options).fit;
  REQUIRE(fit.convergence.converged());
  CHECK(fit.estimate[kFrequency] == Approx(alias).margin(5.0 * frequency_error(times)));
}

TEST_CASE("a phase shifts the argument of a cosine equally everywhere") {
  const data::Table table = wave(regular(21, 1.0), 0.8, 1);
  const Eigen::VectorXd at = Eigen::Vector4d(12.0, 3.0, 5.0, 8.0);
  const auto of_period = phase_coefficients(bound("y ~ A + B*cos(2*pi*(t - u)/P)", table), at);
  REQUIRE(of_period.size() == 1);
  CHECK(of_period[0].coefficient == 2);
  CHECK(of_period[0].period == Approx(8.0));
  // The argument is zero at t = u, which is between 0 and 20.
  CHECK(of_period[0].lowest_shift == Approx(-5.0));
  CHECK(of_period[0].highest_shift == Approx(15.0));
  const auto of_angle = phase_coefficients(bound("y ~ A + B*sin(t/P - f)", table),
                                           Eigen::Vector4d(12.0, 3.0, 4.0, 0.7));
  REQUIRE(of_angle.size() == 1);
  CHECK(of_angle[0].coefficient == 3);
  CHECK(of_angle[0].period == Approx(2.0 * std::numbers::pi));
  CHECK(phase_coefficients(bound(kWave, table), at).empty());
}
