// SPDX-License-Identifier: MIT
// Equal curves with exchanged roles of their coefficients: start values and bounds choose.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Matchers::Contains;

namespace {

data::Table table_of(const std::vector<double>& x,
                     const std::vector<double>& y,
                     const data::TextColumn& group) {
  data::Table table;
  table.set("x", x);
  table.set("y", y);
  table.set("g", group);
  return table;
}

/// 15 groups on a logistic curve from 4 to 40 around 10, with few points near the upper end.
data::Table logistic_data() {
  Random random(21);
  std::vector<double> x;
  std::vector<double> y;
  data::TextColumn group;
  for (int g = 0; g < 15; ++g) {
    const double upper = 40.0 + 3.0 * random.normal();
    for (const double at : {0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0}) {
      x.push_back(at);
      y.push_back(4.0 + (upper - 4.0) / (1.0 + std::exp((11.0 - at) / 2.0)) + random.normal());
      group.append("g" + std::to_string(g));
    }
  }
  return table_of(x, y, group);
}

/// 12 groups of a fast and a slow decay; the fast one varies.
data::Table two_decays() {
  Random random(22);
  std::vector<double> x;
  std::vector<double> y;
  data::TextColumn group;
  for (int g = 0; g < 12; ++g) {
    const double fast = 3.0 + 0.5 * random.normal();
    for (const double at : {0.1, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0}) {
      x.push_back(at);
      y.push_back(fast * std::exp(-1.5 * at) + 1.3 * std::exp(-0.13 * at) + 0.08 * random.normal());
      group.append("g" + std::to_string(g));
    }
  }
  return table_of(x, y, group);
}

/// 10 groups of a one-compartment curve with the rates 1.5 and 0.15, whose clearance varies.
data::Table concentrations() {
  Random random(23);
  std::vector<double> x;
  std::vector<double> y;
  data::TextColumn group;
  for (int g = 0; g < 10; ++g) {
    const double size = 6.0 * std::exp(0.3 * random.normal());
    for (const double at : {0.5, 1.0, 2.0, 4.0, 8.0, 12.0, 24.0}) {
      const double mean = size * 1.5 / 1.35 * (std::exp(-0.15 * at) - std::exp(-1.5 * at));
      x.push_back(at);
      y.push_back(mean + 0.1 * random.normal());
      group.append("g" + std::to_string(g));
    }
  }
  return table_of(x, y, group);
}

FittedModel fitted_curve(const data::Table& table,
                         const std::string& formula,
                         const std::string& random,
                         const FitModelOptions& options) {
  return fit_model(specify_model({.formula = formula, .random = random}, table), table, options)
      .fit;
}

double estimate_of(const FittedModel& fit, const std::string& name) {
  return fit
      .estimate[std::ranges::find(fit.coefficient_names, name) - fit.coefficient_names.begin()];
}

constexpr const char* kFourLogistic = "y ~ A + (B - A)/(1 + exp((xm - x)/s))";
constexpr const char* kCompartment =
    "y ~ 100*exp(lka + lke - lcl)/(exp(lka) - exp(lke))*(exp(-exp(lke)*x) - exp(-exp(lka)*x))";
/// The same with the volume, which changes when the rates are exchanged.
constexpr const char* kVolume =
    "y ~ 100*exp(lka - lv)/(exp(lka) - exp(lke))*(exp(-exp(lke)*x) - exp(-exp(lka)*x))";
constexpr const char* kDecays = "y ~ a1*exp(-k1*x) + a2*exp(-k2*x)";

}  // namespace

TEST_CASE("start values give the asymptotes of a logistic curve their roles") {
  const data::Table table = logistic_data();
  for (const Method method : {Method::kLindstromBates, Method::kLaplace}) {
    const FittedModel free = fitted_curve(table, kFourLogistic, "B + xm | g", {.method = method});
    for (const double sign : {1.0, -1.0}) {
      // (A, B, s) and (B, A, -s) are the same curve.
      const std::map<std::string, double> start{{"A", sign > 0.0 ? 4.0 : 40.0},
                                                {"B", sign > 0.0 ? 40.0 : 4.0},
                                                {"xm", 11.0},
                                                {"s", sign * 2.0}};
      const FittedModel fit =
          fitted_curve(table, kFourLogistic, "B + xm | g", {.method = method, .start = start});
      CAPTURE(fit.convergence.verdict());
      REQUIRE(fit.convergence.converged());
      CHECK(sign * estimate_of(fit, "s") > 0.0);
      CHECK(sign * (estimate_of(fit, "B") - estimate_of(fit, "A")) > 0.0);
      CHECK(fit.log_likelihood > free.log_likelihood - 5.0);
    }
  }
}

TEST_CASE("optima within the bounds compete with fits at the bounds") {
  const data::Table table = two_decays();
  for (const Method method : {Method::kLindstromBates, Method::kLaplace}) {
    const FittedModel free = fitted_curve(table, kDecays, "a1 | g", {.method = method});
    // The decay that varies is the fast one.
    REQUIRE(estimate_of(free, "k1") > 1.0);
    // If it is the slow one, the bound can be on either rate.
    const FittedModel second = fitted_curve(
        table, kDecays, "a1 | g", {.method = method, .bounds = {{"k2", {.low = 0.5}}}});
    const FittedModel first = fitted_curve(
        table, kDecays, "a1 | g", {.method = method, .bounds = {{"k1", {.high = 0.5}}}});
    CAPTURE(first.convergence.verdict(), second.convergence.verdict());
    REQUIRE(first.convergence.converged());
    REQUIRE(second.convergence.converged());
    CHECK(estimate_of(second, "k2") > 1.0);
    CHECK(second.log_likelihood < free.log_likelihood);
    // Both searches end within 1e-5 standard errors of the same maximum.
    CHECK(second.log_likelihood == Approx(first.log_likelihood).margin(1e-6));
    CHECK_THAT(second.convergence.verdict(), Contains("Another optimum is higher"));
  }
}

TEST_CASE("exchanged terms are within bounds by least squares, too") {
  const data::Table table = two_decays();
  const ModelSpecification model = specify_model({.formula = kDecays}, table);
  const FittedModel free = fit_model(model, table).fit;
  for (const std::string name : {"k1", "k2"}) {
    const FittedModel fit = fit_model(model, table, {.bounds = {{name, {.low = 0.5}}}}).fit;
    REQUIRE(fit.convergence.converged());
    CHECK(estimate_of(fit, name) > 0.5);
    CHECK(fit.log_likelihood == Approx(free.log_likelihood).epsilon(1e-10));
  }
}

TEST_CASE("curves that are equal in all groups have the roles of the start or of the bounds") {
  // The rates can be exchanged without any change of the likelihood, since only the clearance or
  // the volume varies: each maximum is one of two.
  const data::Table table = concentrations();
  const auto check = [&](const char* curve, const std::string& random, Method method) {
    const FittedModel free = fitted_curve(table, curve, random + " | g", {.method = method});
    REQUIRE(free.convergence.converged());
    for (const bool is_absorption : {true, false}) {
      const std::map<std::string, double> start{
          {"lka", is_absorption ? 0.3 : -2.0}, {"lke", is_absorption ? -2.0 : 0.3}, {random, 2.0}};
      const FittedModel from =
          fitted_curve(table, curve, random + " | g", {.method = method, .start = start});
      // log(0.15) is -1.9, so that the other maximum is outside.
      const FittedModel bounded = fitted_curve(
          table,
          curve,
          random + " | g",
          {.method = method, .bounds = {{is_absorption ? "lka" : "lke", {.low = -1.0}}}});
      for (const FittedModel& fit : {from, bounded}) {
        CAPTURE(curve, word_of(method), is_absorption, fit.estimate.transpose());
        CHECK(fit.convergence.converged());
        CHECK((estimate_of(fit, "lka") > estimate_of(fit, "lke")) == is_absorption);
        // Two searches of one maximum.
        CHECK(fit.log_likelihood == Approx(free.log_likelihood).margin(1e-4));
        CHECK(std::max(estimate_of(fit, "lka"), estimate_of(fit, "lke")) ==
              Approx(std::max(estimate_of(free, "lka"), estimate_of(free, "lke"))).epsilon(1e-4));
      }
    }
  };
  for (const Method method : {Method::kLindstromBates,
                              Method::kFirstOrder,
                              Method::kInteraction,
                              Method::kLaplace,
                              Method::kQuadrature}) {
    check(kCompartment, "lcl", method);
    check(kVolume, "lv", method);
  }
}

TEST_CASE("effects change places with their coefficients") {
  // Both amplitudes vary, so that all exchanges leave the likelihood unchanged.
  const data::Table table = two_decays();
  const std::map<std::string, double> fast{{"a1", 3.0}, {"k1", 1.5}, {"a2", 1.3}, {"k2", 0.13}};
  const std::map<std::string, double> slow{{"a1", 1.3}, {"k1", 0.13}, {"a2", 3.0}, {"k2", 1.5}};
  const auto fitted_from = [&](const std::map<std::string, double>& start) {
    return fitted_curve(
        table, kDecays, "a1 + a2 | g", {.method = Method::kInteraction, .start = start});
  };
  const FittedModel first = fitted_from(fast);
  const FittedModel second = fitted_from(slow);
  REQUIRE(first.convergence.converged());
  REQUIRE(second.convergence.converged());
  CHECK(estimate_of(first, "k1") > estimate_of(first, "k2"));
  CHECK(estimate_of(second, "k1") < estimate_of(second, "k2"));
  CHECK(second.log_likelihood == Approx(first.log_likelihood).margin(1e-5));
  for (Eigen::Index k = 0; k < 2; ++k) {
    CHECK(second.random[0].sd()[1 - k] ==
          Approx(first.random[0].sd()[k]).epsilon(1e-3).margin(1e-6));
    // Of effects of about 1.
    CHECK((second.random[0].effects.row(1 - k) - first.random[0].effects.row(k))
              .cwiseAbs()
              .maxCoeff() < 1e-3);
  }
}

TEST_CASE("a bound of a coefficient with random effects is for its fixed effect") {
  const data::Table table = logistic_data();
  const FittedModel inside =
      fitted_curve(table,
                   kFourLogistic,
                   "B + xm | g",
                   {.method = Method::kLaplace, .bounds = {{"B", {.low = 20.0}}}});
  REQUIRE(inside.convergence.converged());
  CHECK(estimate_of(inside, "B") > 20.0);
  const FittedModel outside =
      fitted_curve(table,
                   kFourLogistic,
                   "B + xm | g",
                   {.method = Method::kLaplace, .bounds = {{"B", {.low = 90.0}}}});
  // The upper asymptote is 40, so that no curve inside the bound is as high as one at the bound.
  CHECK(outside.convergence.converged());
  CHECK(estimate_of(outside, "B") == 90.0);
  CHECK(outside.log_likelihood < inside.log_likelihood);
}

TEST_CASE("a maximum at the bound of a coefficient that varies is found") {
  // The upper asymptote is 40 and varies. With an upper bound of 30 the maximum is at the bound;
  // the only one inside is the curve with exchanged asymptotes, of which the lower one then varies.
  const data::Table table = logistic_data();
  const FittedModel free =
      fitted_curve(table, kFourLogistic, "B | g", {.method = Method::kLaplace});
  REQUIRE(estimate_of(free, "B") > 30.0);
  const FittedModel below =
      fitted_curve(table,
                   kFourLogistic,
                   "B | g",
                   {.method = Method::kLaplace, .bounds = {{"B", {.high = 30.0}}}});
  REQUIRE(below.convergence.converged());
  CHECK(estimate_of(below, "B") == 30.0);
  CHECK(std::isnan(below.standard_errors()[1]));
  const FittedModel held = fitted_curve(
      table, kFourLogistic, "B | g", {.method = Method::kLaplace, .fixed = {{"B", 30.0}}});
  CHECK(below.log_likelihood == Approx(held.log_likelihood).epsilon(1e-9));
  CHECK(below.random[0].covariance(0, 0) == Approx(held.random[0].covariance(0, 0)).epsilon(1e-4));
}

TEST_CASE("all coefficients of a model with random effects can be at bounds") {
  const data::Table table = logistic_data();
  // The response is below 50 and rises by 1.8 for a unit of x within groups.
  const std::map<std::string, Bounds> bounds{{"a", {.low = 60.0}}, {"b", {.high = 1.0}}};
  for (const Method method : {Method::kLindstromBates, Method::kLaplace}) {
    const FittedModel fit =
        fitted_curve(table, "y ~ a + b*x", "a | g", {.method = method, .bounds = bounds});
    INFO(fit.convergence.verdict());
    CHECK(fit.convergence.converged());
    CHECK(estimate_of(fit, "a") == 60.0);
    CHECK(estimate_of(fit, "b") == 1.0);
    // The effects have the mean square of the groups' distances, less the part of the residuals.
    CHECK(fit.random[0].sd()[0] > 30.0);
  }
}
