// SPDX-License-Identifier: MIT
// A linear plateau whose end varies: the density of its effect has a kink at each dose.
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
using namespace silvafit::fit;
using Catch::Matchers::Contains;

namespace {

constexpr int kGroups = 20;
const std::vector<double> kDoses{0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0, 210.0};
constexpr const char* kPlateau = "y ~ top + slope*min(x - xm, 0)";

struct Trials {
  std::vector<double> y{};  ///< by group, then by dose
  data::Table table{};
};

Trials trials(double residual_sd) {
  Random random(4);
  Trials result;
  std::vector<double> x;
  data::TextColumn group;
  for (int g = 0; g < kGroups; ++g) {
    const double end = 120.0 + 40.0 * random.normal();
    for (const double dose : kDoses) {
      x.push_back(dose);
      result.y.push_back(9.0 + 0.025 * std::min(dose - end, 0.0) + residual_sd * random.normal());
      group.append("g" + std::to_string(g));
    }
  }
  result.table.set("x", x);
  result.table.set("y", result.y);
  result.table.set("g", group);
  return result;
}

FittedModel plateau(const Trials& trials, const FitModelOptions& options) {
  const ModelSpecification model =
      specify_model({.formula = kPlateau, .random = "xm | g"}, trials.table);
  return fit_model(model, trials.table, options).fit;
}

/// The log-likelihood and the modes at the estimates of a fit, by the midpoint rule.
struct Summation {
  explicit Summation(const Trials& trials, const FittedModel& fit) {
    const auto value = [&](const char* name) {
      return fit
          .estimate[std::ranges::find(fit.coefficient_names, name) - fit.coefficient_names.begin()];
    };
    const double sd = fit.random.front().sd()[0];
    constexpr int kSteps = 20000;
    step = 16.0 * sd / kSteps;
    const auto normal = [](double z, double scale) {
      return -0.5 * z * z / (scale * scale) - std::log(scale * std::sqrt(2.0 * std::numbers::pi));
    };
    for (int g = 0; g < kGroups; ++g) {
      double sum = 0.0;
      double highest = -1e300;
      modes.push_back(0.0);
      for (int k = 0; k < kSteps; ++k) {
        const double b = -8.0 * sd + (k + 0.5) * step;
        double density = normal(b, sd);
        for (std::size_t d = 0; d < kDoses.size(); ++d) {
          const double mean =
              value("top") + value("slope") * std::min(kDoses[d] - value("xm") - b, 0.0);
          const std::size_t row = static_cast<std::size_t>(g) * kDoses.size() + d;
          density += normal(trials.y[row] - mean, fit.sigma);
        }
        if (density > highest) modes.back() = b;
        highest = std::max(highest, density);
        sum += std::exp(density) * step;
      }
      log_likelihood += std::log(sum);
    }
  }
  double step = 0.0;
  double log_likelihood = 0.0;
  std::vector<double> modes{};
};

}  // namespace

TEST_CASE("modes at kinks of a formula are found, and quadrature has the likelihood") {
  const Trials data = trials(0.5);
  const FittedModel fit = plateau(data, {.method = Method::kQuadrature, .quadrature_points = 31});
  CAPTURE(fit.convergence.verdict());
  REQUIRE(fit.convergence.converged());
  const Summation exact(data, fit);
  // Across a kink the error of Gauss and Hermite's rule falls with the square of the distance of
  // its nodes, which is a fifth of a standard deviation here.
  CHECK(fit.log_likelihood == Approx(exact.log_likelihood).margin(0.05));
  const double end =
      fit.estimate[std::ranges::find(fit.coefficient_names, "xm") - fit.coefficient_names.begin()];
  int at_kinks = 0;
  for (int g = 0; g < kGroups; ++g) {
    const double mode = fit.random.front().effects(0, g);
    CHECK(mode == Approx(exact.modes[static_cast<std::size_t>(g)]).margin(exact.step));
    at_kinks += static_cast<int>(std::ranges::any_of(
        kDoses, [&](double dose) { return std::abs(dose - end - mode) < 1e-5; }));
  }
  CHECK(at_kinks > 0);
}

TEST_CASE("a fit by another method tells the likelihood by quadrature at its estimates") {
  const Trials data = trials(0.2);
  const FittedModel fit = plateau(data, {.method = Method::kLaplace});
  CAPTURE(fit.convergence.verdict());
  CHECK_THAT(fit.convergence.verdict(), Contains("the formula has a kink in xm"));
  const auto found = std::ranges::find(fit.convergence.evidence, "agq", &Evidence::term);
  REQUIRE(found != fit.convergence.evidence.end());
  CHECK(found->value == Approx(Summation(data, fit).log_likelihood).margin(0.1));
}
