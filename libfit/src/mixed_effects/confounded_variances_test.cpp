// SPDX-License-Identifier: MIT
#include "mixed_effects/confounded_variances.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/intervals.hpp"
#include "silvafit/fit/model_texts.hpp"
#include "silvafit/fit/observed_information.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Contains;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Names = std::vector<std::string>;

namespace {

/// The layout of the trees of a table.
struct Layout {
  int stands = 8;
  int plots = 1;  ///< per stand
  int trees = 5;  ///< per plot
  double first_x = 1.0;
  int treatments = 2;  ///< values of t, which is constant in a plot
};

/// y = 10 + 2 x + a plot's effect + an error.
data::Table lines(const Layout& layout, double spread = 1.5) {
  Random random(29);
  data::Table table;
  data::TextColumn stand;
  data::TextColumn plot;
  std::vector<double> x;
  std::vector<double> t;
  std::vector<double> w;
  std::vector<double> y;
  for (int i = 0; i < layout.stands * layout.plots; ++i) {
    const double effect = random.normal(0.0, spread);
    for (int k = 0; k < layout.trees; ++k) {
      stand.append("s" + std::to_string(i / layout.plots));
      plot.append("p" + std::to_string(i));
      x.push_back(layout.first_x + k + 0.1 * (i % 7));
      t.push_back(i % layout.treatments);
      w.push_back(4.0);
      y.push_back(10.0 + effect + 2.0 * x.back() + random.normal());
    }
  }
  table.set("stand", stand);
  table.set("plot", plot);
  table.set("x", x);
  table.set("t", t);
  table.set("w", w);
  table.set("y", y);
  return table;
}

ModelSpecification specified(const data::Table& table,
                             const char* random,
                             const std::vector<std::string>& sub_models = {},
                             Covariance covariance = Covariance::kGeneral) {
  ModelSpecification model = specify_model("y ~ a + b*x", sub_models, table);
  if (*random != '\0') add_random_effects(model, random, table);
  for (RandomEffects& term : model.random) term.covariance = covariance;
  return model;
}

/// At b = 0, sigma = 1 and covariances that are multiples of the identity.
ConfoundedVariances at(const data::Table& table,
                       const ModelSpecification& specification,
                       double of_last,
                       double of_first = 0.0,
                       bool is_restricted = false) {
  const NonlinearModel model(specification, table);
  const VarianceModel variance(specification.variance, VarianceData::of(model));
  VectorXd beta = VectorXd::Constant(model.coefficient_count(), 0.5);
  VariancePoint point{.coefficients = beta.replicate(1, model.group_count()),
                      .variance = variance.start(),
                      .is_restricted = is_restricted};
  for (std::size_t t = 0; t < model.term_count(); ++t) {
    const auto q = static_cast<Index>(specification.random[t].coefficients.size());
    const double variance_of_term = t + 1 == model.term_count() ? of_last : of_first;
    point.effects.emplace_back(variance_of_term * MatrixXd::Identity(q, q));
  }
  NonlinearModel::Workspace workspace;
  model.evaluate(point.coefficients, point.fitted, nullptr, workspace);
  point.residual_sd = variance.scale(point.fitted, point.variance, false).weight.rsqrt();
  return confounded_variances(model, variance, point);
}

FittedModel confounded_fit(const data::Table& table,
                           const ModelSpecification& model,
                           Method method = Method::kLindstromBates,
                           bool is_restricted = false) {
  FitModelOptions options;
  options.method = method;
  options.reml = is_restricted;
  return fit_model(model, table, options).fit;
}

}  // namespace

TEST_CASE("with one plot per stand only the sum of the two variances is identifiable") {
  // Z Z' of stands is that of plots: V = (psi_stand + psi_plot) Z Z' + sigma^2 I.
  const data::Table table = lines({.stands = 12});
  for (const Method method : {Method::kLindstromBates, Method::kLaplace, Method::kInteraction}) {
    INFO(word_of(method));
    const FittedModel fit = confounded_fit(table, specified(table, "a | stand/plot"), method);
    CHECK_FALSE(fit.convergence.converged());
    CHECK_THAT(fit.convergence.verdict(),
               Contains("sd(a | stand) and sd(a | plot) are not identifiable") &&
                   Contains("each group of stand has one of plot"));
    CHECK(fit.convergence.rank == 1);
    CHECK(!fit.convergence.has_boundary());
    const FittedModel simpler = confounded_fit(table, specified(table, "a | stand"), method);
    REQUIRE(simpler.convergence.converged());
    CHECK(fit.log_likelihood == Approx(simpler.log_likelihood).epsilon(1e-9));
    CHECK(fit.random.back().covariance(0, 0) + fit.random.front().covariance(0, 0) ==
          Approx(simpler.random.back().covariance(0, 0)).epsilon(1e-4));
    // The coefficients have the standard errors of the simpler model.
    CHECK(fit.standard_errors().isApprox(simpler.standard_errors(), 1e-4));
  }
  const ModelSpecification both = specified(table, "a + b | stand/plot");
  CHECK(at(table, both, 0.2, 0.3).directions == 3);
  // With several plots in one stand they are identifiable.
  const data::Table more = lines({.stands = 4, .plots = 2});
  CHECK(at(more, specified(more, "a | stand/plot"), 0.2, 0.3).names.empty());
}

TEST_CASE("confounded variance functions are not attributed to the groups") {
  const data::Table table = lines({.stands = 40, .trees = 1});
  ModelSpecification model = specified(table, "a | plot");
  // w is 4 in all rows: its power is a factor as sigma is.
  model.variance = parse_variance_function("power(x) * power(w)");
  const FittedModel fit = confounded_fit(table, model, Method::kLindstromBates);
  CHECK_FALSE(fit.convergence.converged());
  CHECK_THAT(fit.convergence.verdict(), Contains("sigma are not identifiable"));
  CHECK_THAT(fit.convergence.verdict(), !Contains("random effects by plot"));
}

TEST_CASE("with one tree per plot only the sum of both variances is identifiable") {
  const data::Table table = lines({.stands = 40, .trees = 1});
  const FittedModel pooled = confounded_fit(table, specified(table, ""), Method::kOrdinary);
  const auto n = static_cast<double>(table.rows());
  for (const Method method : {Method::kLindstromBates, Method::kLaplace}) {
    INFO(word_of(method));
    const FittedModel fit = confounded_fit(table, specified(table, "a | plot"), method);
    CHECK_FALSE(fit.convergence.converged());
    CHECK_THAT(fit.convergence.verdict(),
               Contains("sd(a) and sigma are not identifiable") &&
                   Contains("each group of plot has one observation"));
    CHECK(fit.convergence.rank == 1);
    // The maximum likelihood estimate of the variance of an observation is SSE / n for any split.
    CHECK(fit.random.back().covariance(0, 0) + fit.sigma * fit.sigma ==
          Approx(pooled.sigma * pooled.sigma * (n - 2.0) / n).epsilon(1e-6));
    CHECK(fit.log_likelihood == Approx(pooled.log_likelihood).epsilon(1e-9));
  }
}

TEST_CASE("with one more tree in one plot the variances are identifiable") {
  data::Table table = lines({.stands = 500, .trees = 1});
  const ModelSpecification model = specified(table, "a | plot");
  CHECK(at(table, model, 0.4).names == Names{"sd(a)", "sigma"});
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < table.rows(); ++i) rows.push_back(i);
  rows.push_back(0);
  table = table.select(rows);
  CHECK(at(table, model, 0.4).names.empty());
}

TEST_CASE("boundary covariances are not confounded, and do not hide confounding") {
  const data::Table several = lines({.stands = 6, .plots = 3}, 0.0);
  CHECK(at(several, specified(several, "a + b | stand/plot"), 0.0, 0.0).names.empty());
  const FittedModel none = confounded_fit(several, specified(several, "a | stand/plot"));
  CHECK(none.convergence.converged());
  CHECK(none.convergence.rank == 2);
  const data::Table single = lines({.trees = 1});
  CHECK(at(single, specified(single, "a | plot"), 0.0).names == Names{"sd(a)", "sigma"});
  const data::Table one = lines({});
  const ModelSpecification nested = specified(one, "a + b | stand/plot");
  CHECK_FALSE(at(one, nested, 0.0, 0.5).names.empty());
  CHECK_FALSE(at(one, nested, 0.5, 0.0).names.empty());
  // If the sum is zero, both parts are.
  CHECK(at(one, nested, 0.0, 0.0).names.empty());
}

TEST_CASE("with two treatments two variances are identifiable, but not three components") {
  // A plot's covariance is psi_aa + 2 t psi_ab + t^2 psi_bb: of t = 0 and t = 1 two numbers.
  const Names sub_model{"a ~ 1 + t"};
  const data::Table two = lines({});
  const ModelSpecification general = specified(two, "a + a:t | plot", sub_model);
  CHECK(at(two, general, 0.4).names == Names{"sd(a:t)", "cor(a, a:t)"});
  CHECK(at(two, specified(two, "a + a:t | plot", sub_model, Covariance::kDiagonal), 0.4)
            .names.empty());
  CHECK(at(two, specified(two, "a + a:t | plot", sub_model, Covariance::kIdentity), 0.4)
            .names.empty());
  const data::Table three = lines({.stands = 9, .treatments = 3});
  CHECK(at(three, specified(three, "a + a:t | plot", sub_model), 0.4).names.empty());
}

TEST_CASE("nearly equal columns are identifiable") {
  // Calendar years: a and b are correlated to 1 - 1e-6 in each plot.
  const data::Table years = lines({.trees = 8, .first_x = 2000.0});
  CHECK(at(years, specified(years, "a + b | plot"), 0.1).names.empty());
  CHECK(at(years, specified(years, "a + b | plot", {}, Covariance::kDiagonal), 0.1).names.empty());
}

TEST_CASE("components in the space of the coefficients are not identifiable by REML") {
  // Contrasts of one plot, or of two with separate coefficients, are free of the effects.
  const data::Table one = lines({.stands = 1, .trees = 12});
  CHECK(at(one, specified(one, "a | plot"), 0.4).names.empty());
  CHECK(at(one, specified(one, "a | plot"), 0.4, 0.0, true).names == Names{"sd(a)"});
  const data::Table two = lines({.stands = 2, .trees = 6});
  const ModelSpecification own = specified(two, "a | plot", {"a ~ 1 + t"});
  CHECK(at(two, own, 0.4).names.empty());
  CHECK(at(two, own, 0.4, 0.0, true).names == Names{"sd(a)"});
  const data::Table more = lines({.stands = 3});
  CHECK(at(more, specified(more, "a | plot"), 0.4, 0.0, true).names.empty());
  const FittedModel fit = confounded_fit(two, own, Method::kLindstromBates, true);
  CHECK_FALSE(fit.convergence.converged());
  CHECK_THAT(fit.convergence.verdict(), Contains("sd(a) is not identifiable"));
}

TEST_CASE("the variance between groups needs several of them, as in lme4") {
  const data::Table one = lines({.stands = 1, .trees = 12});
  for (const Method method : {Method::kLindstromBates, Method::kLaplace}) {
    CHECK_THROWS_WITH(confounded_fit(one, specified(one, "a | plot"), method),
                      Contains("all 12 rows are in the group 'p0'"));
  }
}

TEST_CASE("a variance function of a constant variable is confounded with sigma") {
  const data::Table table = lines({});
  ModelSpecification model = specified(table, "");
  for (const char* const constant : {"power(w)", "exponential(w)"}) {
    model.variance = parse_variance_function(constant);
    CHECK(at(table, model, 0.0).names == Names{"delta", "sigma"});
  }
  for (const char* const varying : {"power(x)",
                                    "stratum(t)",
                                    "stratum(t) * power(x)",
                                    "power(x | t)",
                                    "constant-plus-power(x)"}) {
    model.variance = parse_variance_function(varying);
    INFO(varying);
    CHECK(at(table, model, 0.0).names.empty());
  }
  // Stands of one treatment each: the ratios of stands include those of treatments.
  model.variance = parse_variance_function("stratum(t) * stratum(stand)");
  CHECK(at(table, model, 0.0).directions == 1);
  CHECK_FALSE(confounded_fit(table, model, Method::kGeneralized).convergence.converged());
}

TEST_CASE("with coefficients that are not identifiable no method converges") {
  data::Table table = lines({});
  std::vector<double> twice;
  for (const double t : table.numbers("t")) twice.push_back(2.0 * t);
  table.set("u", twice);
  const ModelSpecification model = specified(table, "a | plot", {"b ~ 1 + t + u"});
  const FittedModel fit = confounded_fit(table, model, Method::kLaplace);
  CHECK_FALSE(fit.convergence.converged());
  CHECK_THAT(fit.convergence.verdict(), Contains("b:t and b:u are not identifiable"));
  CHECK(fit.convergence.rank == 3);
  const VectorXd errors = fit.standard_errors();
  CHECK(errors.head(2).allFinite());
  CHECK(errors.tail(2).array().isNaN().all());
}

TEST_CASE("an earlier fit with confounded variances has no Wald limits of them") {
  const data::Table table = lines({.stands = 12});
  for (const Method method : {Method::kLindstromBates, Method::kLaplace}) {
    FittedModel fit = confounded_fit(table, specified(table, "a | stand/plot"), method);
    CHECK_THROWS_AS(confidence_intervals(fit, table), UsageError);
    fit.convergence.status = ConvergenceStatus::kConverged;  // as in earlier versions
    const Intervals intervals = confidence_intervals(fit, table);
    REQUIRE(intervals.parameters.size() == 5);
    for (const ParameterInterval& of : intervals.parameters) {
      INFO(of.name);
      const bool is_deviation = of.kind == ParameterKind::kDeviation;
      CHECK(std::isnan(of.lower) == is_deviation);
      CHECK(std::isnan(of.upper) == is_deviation);
      if (is_deviation)
        CHECK_THAT(of.note, Contains("not identifiable: sd(a | stand), sd(a | plot)"));
    }
    const MatrixXd covariance = observed_information(fit, table).covariance;
    CHECK(covariance.diagonal().segment(2, 2).array().isNaN().all());
    CHECK(std::isfinite(covariance(0, 0)));
    CHECK(std::isfinite(covariance(4, 4)));
  }
}

TEST_CASE("effects on equal columns have one variance between them") {
  // b*x and u*x: only var(b) + 2 cov(b, u) + var(u) is in the likelihood, which is that of b alone.
  const data::Table table = lines({.stands = 12});
  ModelSpecification model = specify_model("y ~ a + b*x + u*x", {}, table);
  add_random_effects(model, "a + b + u | stand", table);
  FitModelOptions options;
  options.fixed = {{"u", 0.0}};
  const FittedModel fit = fit_model(model, table, options).fit;
  CHECK_FALSE(fit.convergence.converged());
  CHECK_THAT(fit.convergence.verdict(),
             Contains("sd(b), sd(u) and cor(b, u) are not identifiable"));
  const FittedModel simpler = confounded_fit(table, specified(table, "a + b | stand"));
  CHECK(fit.log_likelihood == Approx(simpler.log_likelihood).epsilon(1e-9));
  // An offset makes columns nearly equal, which are identifiable still.
  const data::Table far = lines({.stands = 12, .first_x = 1e7});
  CHECK(at(far, specified(far, "a + b | stand"), 0.3).names.empty());
}

TEST_CASE("the correlation of effects that no group shares is not identifiable") {
  const data::Table table = lines({.stands = 12});
  ModelSpecification model = specified(table, "", {"a ~ 0 + (t == 0) + (t == 1)"});
  add_random_effects(model, "a:(t == 0) + a:(t == 1) | stand", table);
  const FittedModel fit = confounded_fit(table, model);
  CHECK_THAT(fit.convergence.verdict(), Contains("no group has both effects"));
  CHECK(fit.convergence.rank == 2);
}

TEST_CASE("a process with longer lags than the groups have is not identifiable") {
  // Of two rows only the correlation of lag 1 is seen, phi1 / (1 - phi2) of an AR(2) process.
  data::Table table = lines({.stands = 30, .trees = 2});
  std::vector<double> time;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    time.push_back(static_cast<double>(row % 2));
  }
  table.set("time", time);
  const auto fitted = [&](const char* correlation) {
    FitModelOptions options;
    options.method = Method::kGeneralized;
    return fit_model(specify_model(ModelTexts{.formula = "y ~ a + b*x", .correlation = correlation},
                                   table),
                     table,
                     options)
        .fit;
  };
  const FittedModel ar2 = fitted("arma(2, 0, time | stand)");
  CHECK_THAT(ar2.convergence.verdict(), Contains("phi1 and phi2 are not identifiable"));
  const FittedModel ar1 = fitted("ar1(time | stand)");
  REQUIRE(ar1.convergence.converged());
  CHECK(ar2.log_likelihood == Approx(ar1.log_likelihood).epsilon(1e-9));
}

TEST_CASE("a stratum whose observations the random effects fit exactly has no Wald interval") {
  // A precise height and two rough ones in each plot: the likelihood rises until the plot's effect
  // is that of the precise one, whose residual variance is 0. Two precise ones differ.
  const auto fitted = [](int precise,
                         const char* effects = "a | plot",
                         const char* variance = "stratum(device)") {
    Random random(3);
    data::Table table;
    data::TextColumn plot;
    data::TextColumn device;
    data::TextColumn stand;
    data::TextColumn year;
    std::vector<double> x;
    std::vector<double> y;
    for (int i = 0; i < 20; ++i) {
      const double effect = random.normal(0.0, 2.0);
      for (int k = 0; k < 2 + precise; ++k) {
        plot.append("p" + std::to_string(i));
        stand.append("s" + std::to_string(i / 5));
        year.append("y" + std::to_string((i + k) % 4));
        device.append(k < 2 ? "tape" : "laser");
        x.push_back(10.0 + 7.0 * k + i);
        y.push_back(5.0 + 0.5 * x.back() + effect + random.normal(0.0, k < 2 ? 1.5 : 0.05));
      }
    }
    table.set("plot", plot);
    table.set("device", device);
    table.set("stand", stand);
    table.set("year", year);
    table.set("x", x);
    table.set("y", y);
    return std::pair(
        fit_model(specify_model(
                      ModelTexts{.formula = "y ~ a + b*x", .random = effects, .variance = variance},
                      table),
                  table)
            .fit,
        table);
  };
  const auto [exact, one] = fitted(1);
  REQUIRE(exact.convergence.converged());
  CHECK_THAT(exact.convergence.verdict(),
             Contains("The residual standard deviation of laser is 0"));
  const Intervals wald = confidence_intervals(exact, one);
  for (const ParameterInterval& interval : wald.parameters) {
    CHECK(std::isnan(interval.lower) == (interval.name == "ratio (laser)"));
  }
  // Neither another grouping nor a power beside the ratio determines it.
  for (const char* const effects : {"a | plot", "a | stand/plot", "(a | plot) + (a | year)"}) {
    for (const char* const variance : {"stratum(device)", "power(x | device) * stratum(device)"}) {
      CAPTURE(effects, variance);
      const auto [fit, table] = fitted(1, effects, variance);
      REQUIRE(fit.convergence.converged());
      CHECK_THAT(fit.convergence.verdict(),
                 Contains("The residual standard deviation of laser is 0"));
      for (const ParameterInterval& interval : confidence_intervals(fit, table).parameters) {
        if (interval.name.ends_with("(laser)")) CHECK(std::isnan(interval.lower));
      }
    }
  }
  const auto [inside, two] = fitted(2);
  REQUIRE(inside.convergence.converged());
  CHECK_FALSE(inside.convergence.has_boundary());
}
