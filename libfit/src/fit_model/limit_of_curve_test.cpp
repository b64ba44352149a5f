// SPDX-License-Identifier: MIT
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit;
using namespace silvafit::fit;

namespace {

/// 12 groups of 8 rows with x from 5 to 40, curves of a group's scale, and normal errors.
template <typename Curve>
data::Table grouped(std::uint64_t seed, double residual_sd, const Curve& curve) {
  Random random(seed);
  std::vector<double> x;
  std::vector<double> y;
  data::TextColumn group;
  for (int g = 0; g < 12; ++g) {
    const double scale = 1.0 + 0.1 * random.normal();
    for (int k = 0; k < 8; ++k) {
      x.push_back(5.0 + 35.0 * random.uniform());
      y.push_back(scale * curve(x.back()) + residual_sd * random.normal());
      group.append("g" + std::to_string(g));
    }
  }
  data::Table table;
  table.set("x", x);
  table.set("y", y);
  table.set("g", group);
  return table;
}

/// Five groups of three rows on a curve of inhibition by the substrate.
data::Table substrates() {
  data::Table table;
  data::TextColumn group;
  for (int i = 0; i < 15; ++i) group.append("g" + std::to_string(i / 3));
  table.set("g", group);
  table.set("x", {0.5, 2.0, 10.0, 0.5, 1.0, 10.0, 0.5, 2.0, 5.0, 2.0, 5.0, 10.0, 0.5, 1.0, 5.0});
  table.set("y",
            {1.3836,
             3.8569,
             6.2966,
             1.4491,
             2.5208,
             7.2329,
             0.8775,
             3.1597,
             4.6555,
             3.6969,
             5.896,
             6.6758,
             1.3126,
             1.7997,
             5.3763});
  return table;
}

FittedModel fitted_by_group(const data::Table& table,
                            const std::string& formula,
                            FitModelOptions options) {
  return fit_model(specify_model({.formula = formula, .random = "a | g"}, table), table, options)
      .fit;
}

constexpr const char* kRichards = "y ~ a*(1 - exp(-k*x))^p";

}  // namespace

TEST_CASE("data of a power curve give a Richards curve no maximum") {
  // The limit of large a and small k is b*x^p, so that both likelihoods have the same supremum.
  const data::Table table = grouped(11, 0.6, [](double x) { return 0.4 * std::pow(x, 1.02); });
  for (const Method method : {Method::kLaplace, Method::kInteraction, Method::kQuadrature}) {
    const FittedModel limit = fitted_by_group(table, "y ~ a*x^p", {.method = method});
    REQUIRE(limit.convergence.converged());
    const FittedModel fit = fitted_by_group(table, kRichards, {.method = method});
    CAPTURE(fit.convergence.verdict(), fit.log_likelihood, limit.log_likelihood);
    // Data that are curved by chance would have a maximum above the limit. A search ends somewhere
    // on the ridge, where a step of one standard error, half a unit of log-likelihood, changes a
    // tenth of that at most.
    REQUIRE(fit.log_likelihood < limit.log_likelihood + 1e-6);
    REQUIRE(fit.log_likelihood > limit.log_likelihood - 0.05);
    CHECK_FALSE(fit.convergence.converged());
    CHECK((fit.convergence.has(Evidence::Kind::kUnbounded, "k") ||
           fit.convergence.has(Evidence::Kind::kHardlyIdentifiable, "k")));
  }
}

TEST_CASE("a bound that leaves the way to a limit open gives no maximum either") {
  // Michaelis-Menten's curve of a straight line, whose slope has the same likelihood: V and K grow.
  const data::Table table = grouped(5, 0.3, [](double x) { return 0.5 * x + 0.001 * x * x; });
  const char* const curve = "y ~ a*x/(K + x)";
  const FittedModel line = fitted_by_group(table, "y ~ a*x", {.method = Method::kInteraction});
  const FittedModel open = fitted_by_group(
      table, curve, {.method = Method::kInteraction, .bounds = {{"K", {.low = 0.0}}}});
  CAPTURE(open.convergence.verdict(), open.log_likelihood, line.log_likelihood);
  CHECK(open.log_likelihood < line.log_likelihood + 1e-6);
  CHECK_FALSE(open.convergence.converged());
  // A bound on the way is where the likelihood is highest.
  const FittedModel closed = fitted_by_group(
      table,
      curve,
      {.method = Method::kInteraction, .bounds = {{"K", {.low = 0.0, .high = 1000.0}}}});
  CHECK(closed.convergence.boundary() == std::vector<std::string>{"K = 1000, its upper bound"});
}

TEST_CASE("data of stands at their asymptote give a Richards curve no maximum") {
  // At ages of 5 and more all heights are at the asymptote: the limit is a constant.
  const data::Table table = grouped(3, 0.5, [](double) { return 20.0; });
  const FittedModel fit = fitted_by_group(table, kRichards, {.method = Method::kLaplace});
  CAPTURE(fit.convergence.verdict());
  CHECK_FALSE(fit.convergence.converged());
}

TEST_CASE("the maximum of a nearly straight curve is found beyond infinity") {
  // a*x/(k + x) is s*x/(1 + q*x) with k = 1/q, so that a curve that bends upwards, q < 0, has
  // negative a and k. A search from positive ones must pass the straight line, which is at
  // infinity.
  int upwards = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const data::Table table = grouped(seed, 2.0, [](double x) { return 2.0 * x; });
    const FitModelOptions options{.method = Method::kInteraction};
    const FittedModel regular =
        fit_model(specify_model({.formula = "y ~ s*x/(1 + q*x)", .random = "s | g"}, table),
                  table,
                  options)
            .fit;
    REQUIRE(regular.convergence.converged());
    const double q = regular.estimate[1];
    const FittedModel fit = fitted_by_group(table, "y ~ a*x/(k + x)", options);
    CAPTURE(seed, q, fit.convergence.verdict(), fit.estimate.transpose());
    CHECK(fit.convergence.converged());
    CHECK(fit.log_likelihood == Approx(regular.log_likelihood).margin(1e-5));
    CHECK(fit.estimate[1] * q == Approx(1.0).epsilon(0.01));
    if (q < 0.0) ++upwards;
  }
  CHECK(upwards > 0);
}

TEST_CASE("a search that has gone to infinity comes back from the other side") {
  // x^2/I vanishes at I = infinity, which searches from some starts reach at -1e98. In r = 1/I that
  // is r = 0, and the maximum an ordinary one at r > 0.
  const data::Table table = substrates();
  for (const Method method : {Method::kInteraction, Method::kLaplace, Method::kQuadrature}) {
    const FitModelOptions options{.method = method};
    const FittedModel regular = fitted_by_group(table, "y ~ a*x/(K + x + r*x^2)", options);
    REQUIRE(regular.convergence.converged());
    REQUIRE(regular.estimate[2] > 0.0);
    const FittedModel fit = fitted_by_group(table, "y ~ a*x/(K + x + x^2/I)", options);
    CAPTURE(fit.convergence.verdict(), fit.estimate.transpose());
    CHECK(fit.convergence.converged());
    CHECK(fit.log_likelihood == Approx(regular.log_likelihood).margin(1e-5));
    CHECK(fit.estimate[2] * regular.estimate[2] == Approx(1.0).epsilon(0.01));
  }
}

TEST_CASE("data of the whole curve give a maximum with standard errors") {
  const data::Table table =
      grouped(5, 0.5, [](double x) { return 25.0 * std::pow(1.0 - std::exp(-0.1 * x), 1.5); });
  const FittedModel fit = fitted_by_group(table, kRichards, {.method = Method::kLaplace});
  CHECK(fit.convergence.converged());
  // The truth is within four standard errors in all but 1 of 16,000 samples.
  const Eigen::Array3d away =
      (fit.estimate - Eigen::Vector3d(25.0, 0.1, 1.5)).cwiseQuotient(fit.standard_errors());
  CHECK((away.abs() < 4.0).all());
}

TEST_CASE("standard errors on a ridge towards an exponential curve are not too small") {
  // For small c the exponent of a*exp(-b*exp(-c*x)) is a parabola in x with slope b*c and curvature
  // -b*c^2/2, so that c is -2 times the ratio of its coefficients, of which the slope is known
  // well.
  int compared = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6, 7, 8}) {
    const data::Table table = grouped(seed, 0.5, [](double x) { return 0.6 * std::exp(0.05 * x); });
    const FittedModel fit =
        fitted_by_group(table, "y ~ a*exp(-b*exp(-c*x))", {.method = Method::kLaplace});
    if (!fit.convergence.converged()) continue;
    const FittedModel parabola =
        fitted_by_group(table, "y ~ a*exp(s*x + q*x^2)", {.method = Method::kLaplace});
    REQUIRE(parabola.convergence.converged());
    if (std::abs(fit.estimate[2]) > 0.02) continue;
    ++compared;
    const double expected = 2.0 * parabola.standard_errors()[2] / std::abs(parabola.estimate[1]);
    CAPTURE(seed, fit.convergence.verdict(), fit.estimate[2]);
    // Terms of third order change it by some tenths.
    CHECK(fit.standard_errors()[2] > 0.5 * expected);
  }
  CHECK(compared > 2);
}
