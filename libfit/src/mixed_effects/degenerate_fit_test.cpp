// SPDX-License-Identifier: MIT
#include "mixed_effects/degenerate_fit.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "mixed_effects/mixed_effects_evidence.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Contains;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Growth curves of plots, with residuals of a given size.
data::Table curves(double residual, int trees = 8) {
  Random random(3);
  data::Table table;
  data::TextColumn plot;
  std::vector<double> d;
  std::vector<double> h;
  std::vector<double> z;
  for (int i = 0; i < 10; ++i) {
    const double limit = 23.0 + random.normal(0.0, 2.3);
    for (int j = 0; j < trees; ++j) {
      d.push_back(random.uniform(5.0, 40.0));
      z.push_back(random.uniform(-1.0, 1.0));
      h.push_back(limit * (1.0 - std::exp(-0.06 * d.back())) + random.normal(0.0, residual));
      plot.append(std::to_string(i));
    }
  }
  std::vector<double> twice;
  for (const double value : z) twice.push_back(2.0 * value);
  table.set("d", d);
  table.set("h", h);
  table.set("z", z);
  table.set("twice", twice);
  table.set("plot", plot);
  return table;
}

Convergence fitted(const data::Table& table,
                   const std::string& method,
                   const std::vector<std::string>& parameters = {},
                   const char* random = "a | plot") {
  ModelSpecification model = specify_model("h ~ a*(1 - exp(-b*d))", parameters, table);
  add_random_effects(model, random, table);
  FitModelOptions options;
  options.method = value_of<Method>(method, "method");
  return fit_model(model, table, options).fit.convergence;
}

std::string text_of(const Degeneracy& found) {
  return found.reason ? verdict_of({*found.reason}) : "";
}

/// The degeneracy of a fit of "h ~ ..." with the given estimate and standard deviation of `a`.
std::string at(const char* formula, const VectorXd& estimate, double deviation) {
  const data::Table table = curves(0.5);
  ModelSpecification specification = specify_model(formula, {}, table);
  add_random_effects(specification, "a | plot", table);
  const NonlinearModel model(specification, table);
  MixedEffectsFit fit;
  fit.estimate = estimate;
  fit.random = {{.names = {"a"}, .covariance = MatrixXd::Constant(1, 1, deviation * deviation)}};
  fit.residual_sd = VectorXd::Constant(model.observations(), 0.5);
  return text_of(degeneracy(model, frame_at(model, estimate), fit));
}

}  // namespace

TEST_CASE("a model that fits all observations exactly has no maximum of the likelihood") {
  for (const char* const method : {"lb", "laplace", "focei", "agq"}) {
    for (const char* const random : {"a | plot", "a + b | plot"}) {
      INFO(method << ", " << random);
      const Convergence exact = fitted(curves(0.0), method, {}, random);
      CHECK(exact.status == ConvergenceStatus::kNoMaximum);
      CHECK_THAT(exact.verdict(), Contains("perfect fit"));
    }
    CHECK(fitted(curves(0.01), method).converged());
  }
}

TEST_CASE("an unbounded variance component is named") {
  const VectorXd estimate = Eigen::Vector2d(3.0, 0.06);
  const char* const exponential = "h ~ exp(a)*(1 - exp(-b*d))";
  CHECK(at(exponential, estimate, 0.1).empty());
  CHECK_THAT(at(exponential, estimate, 8.6e4), Contains("sd(a) grows without bound"));
  CHECK_THAT(at("h ~ a*(1 - exp(-b*d))", estimate, 5e8), Contains("a million times the spread"));
  // With a standard deviation of 1e6 the curve is at one asymptote or at the other.
  const char* const bounded = "h ~ 20*b/(b + exp(a))";
  CHECK_THAT(at(bounded, estimate, 1e6), Contains("no longer depends on the random effect"));
  CHECK(at(bounded, estimate, 1.0).empty());
}

TEST_CASE("groups with no more observations than random effects are named if no residual is left") {
  const auto reason_of = [](int trees, const char* random, Index effects, double residual) {
    const data::Table table = curves(0.5, trees);
    ModelSpecification specification = specify_model("h ~ a*(1 - exp(-b*d))", {}, table);
    add_random_effects(specification, random, table);
    const NonlinearModel model(specification, table);
    MixedEffectsFit fit;
    fit.estimate = Eigen::Vector2d(23.0, 0.06);
    const MatrixXd covariance = Eigen::Vector2d(4.0, 1e-4).head(effects).asDiagonal();
    const std::vector<std::string> names{"a", "b"};
    fit.random = {{.names = {names.begin(), names.begin() + effects}, .covariance = covariance}};
    fit.residual_sd = VectorXd::Constant(model.observations(), residual);
    return text_of(degeneracy(model, frame_at(model, fit.estimate), fit));
  };
  const auto is_named = Contains("no group of plot has more observations than random effects");
  CHECK_THAT(reason_of(1, "a | plot", 1, 1e-4), is_named);
  CHECK_THAT(reason_of(2, "a + b | plot", 2, 1e-3), is_named);
  CHECK_THAT(reason_of(3, "a + b | plot", 2, 1e-3), !is_named);
  // A residual of the size of measurement errors is a residual.
  CHECK(reason_of(2, "a + b | plot", 2, 0.5).empty());
}

TEST_CASE("one observation per group is named by every method, besides other findings") {
  // Five observations for seven parameters.
  data::Table table;
  data::TextColumn plot;
  for (const char* const label : {"0", "1", "3", "5", "6"}) plot.append(label);
  table.set("plot", plot);
  table.set("d", std::vector<double>{17.9, 34.1, 24.7, 10.5, 40.2});
  table.set("h", std::vector<double>{17.2, 19.2, 19.0, 17.7, 18.9});
  table.set("z", std::vector<double>{-1.1, -0.4, 0.5, 0.9, -0.2});
  for (const char* const method : {"lb", "laplace", "focei", "agq"}) {
    INFO(method);
    const Convergence convergence = fitted(table, method, {"b ~ 1 + z"}, "a + b | plot");
    CHECK_FALSE(convergence.converged());
    CHECK_THAT(convergence.verdict(),
               Contains("no group of plot has more observations than random effects"));
  }
}

TEST_CASE("a search has diverged if the mean no longer depends on a coefficient") {
  const data::Table table = curves(0.5);
  ModelSpecification specification = specify_model("h ~ a/(1 + exp((b - log(d))/c))", {}, table);
  add_random_effects(specification, "a | plot", table);
  const NonlinearModel model(specification, table);
  MixedEffectsFit fit;
  fit.estimate = Eigen::Vector3d(24.0, 2.4, 0.7);
  CHECK_FALSE(has_diverged(model, fit));
  // The mean is a/(1 + exp(-5)) for any d.
  fit.estimate = Eigen::Vector3d(24.0, 1e15, -2e14);
  CHECK(has_diverged(model, fit));
  // These are not identifiable anywhere.
  ModelSpecification sum = specify_model("h ~ a + b + 0*d", {}, table);
  add_random_effects(sum, "a | plot", table);
  fit.estimate = Eigen::Vector2d(10.0, 5.0);
  CHECK_FALSE(has_diverged(NonlinearModel(sum, table), fit));
}

TEST_CASE("collinear covariates are named by every method") {
  for (const char* const method : {"lb", "laplace", "focei", "agq"}) {
    INFO(method);
    const Convergence convergence = fitted(curves(0.5), method, {"a ~ 1 + z + twice"});
    CHECK_FALSE(convergence.converged());
    CHECK_THAT(convergence.verdict(), Contains("not identifiable") && Contains("a:twice"));
  }
}

TEST_CASE("a stratum that the curve can pass through has no highest likelihood") {
  // The log-likelihood of a line through the only observation of B, whose standard deviation is s,
  // and of standard deviation 1 for the others is a constant - log(s).
  data::Table table;
  const std::vector<double> x{1, 2, 3, 4, 5, 6, 7, 8};
  const std::vector<double> y{1.1, 1.8, 3.3, 3.9, 5.2, 5.8, 7.3, 9.5};
  data::TextColumn stratum;
  for (int i = 0; i < 8; ++i) stratum.append(i == 7 ? "B" : "A");
  table.set("x", x);
  table.set("y", y);
  table.set("s", stratum);
  ModelSpecification model = specify_model("y ~ a + b*x", {}, table);
  model.variance = parse_variance_function("stratum(s)");
  FitModelOptions options;
  options.method = Method::kGeneralized;
  const FittedModel fit = fit_model(model, table, options).fit;
  const auto through_b = [&](double sd) {
    double sum = -0.5 * 8.0 * std::log(kTwoPi) - std::log(sd);
    for (std::size_t i = 0; i < 7; ++i) {
      const double residual = y[i] - (fit.estimate[0] + (9.5 - fit.estimate[0]) / 8.0 * x[i]);
      sum -= 0.5 * residual * residual;
    }
    return sum;
  };
  CHECK(through_b(1e-12) > fit.log_likelihood);
  CHECK_THAT(fit.convergence.verdict(), Contains("all observations of B"));
  options.reml = true;
  CHECK_THAT(fit_model(model, table, options).fit.convergence.verdict(),
             !Contains("all observations of B"));
}

TEST_CASE("a stratum that curve and random effects together pass through has no likelihood") {
  // B has a row in each of five plots and a second one in the first: six rows, on which the effects
  // have rank 5, and with a slope 6. With residuals of the size s there, the log-likelihood is
  // constant - log s. Without the second row it has a limit.
  const auto verdict = [](bool has_second) {
    Random random(12);
    data::Table table;
    data::TextColumn plot;
    data::TextColumn stand;
    data::TextColumn stratum;
    std::vector<double> x;
    std::vector<double> y;
    for (int p = 0; p < 10; ++p) {
      const double effect = random.normal(0.0, 1.5);
      for (int i = 0; i < 5; ++i) {
        const bool is_second = p == 0 && i == 1;
        x.push_back(random.uniform(5.0, 40.0));
        y.push_back(5.0 + 0.5 * x.back() + effect + random.normal());
        plot.append("p" + std::to_string(p));
        stand.append("s" + std::to_string(p / 4));
        stratum.append((i == 0 && p < 5) || (is_second && has_second) ? "B" : "A");
      }
    }
    table.set("x", x);
    table.set("y", y);
    table.set("plot", plot);
    table.set("stand", stand);
    table.set("s", stratum);
    std::string result;
    for (const char* const effects : {"a | plot", "a | stand/plot"}) {
      const ModelSpecification model = specify_model(
          {.formula = "y ~ a + b*x", .random = effects, .variance = "stratum(s)"}, table);
      const Convergence convergence = fit_model(model, table).fit.convergence;
      result += convergence.verdict();
      CHECK_THAT(convergence.verdict(), !Contains("taken as parameters"));
    }
    return result;
  };
  const auto count = [](const std::string& text) {
    std::size_t found = 0;
    for (std::size_t at = text.find("all observations of B"); at != std::string::npos;
         at = text.find("all observations of B", at + 1))
      ++found;
    return found;
  };
  CHECK(count(verdict(true)) == 2);
  CHECK(count(verdict(false)) == 0);
}

TEST_CASE("responses that are equal in each group are fitted perfectly, by every method") {
  // The group means fit all of them; in one group only, its own standard deviation goes to 0.
  Random random(5);
  data::Table table;
  data::TextColumn group;
  std::vector<double> x;
  std::vector<double> equal;
  std::vector<double> last_equal;
  for (int g = 1; g <= 8; ++g) {
    const double mean = 10.0 + random.normal(0.0, 2.0);
    for (int i = 0; i < 5; ++i) {
      x.push_back(i);
      equal.push_back(mean);
      last_equal.push_back(g == 8 ? mean : mean + random.normal(0.0, 1.0));
      group.append("G" + std::to_string(g));
    }
  }
  table.set("x", x);
  table.set("equal", equal);
  table.set("last", last_equal);
  table.set("g", group);
  for (const Method method : {Method::kLindstromBates, Method::kInteraction}) {
    INFO(word_of(method));
    const auto verdict = [&](const std::string& formula, const std::string& variance) {
      const ModelSpecification model =
          specify_model({.formula = formula, .random = "a | g", .variance = variance}, table);
      const FittedModel fit = fit_model(model, table, {.method = method}).fit;
      CHECK_FALSE(fit.convergence.converged());
      return fit.convergence.verdict();
    };
    CHECK_THAT(verdict("equal ~ a + b*x", ""), Contains("perfect fit"));
    CHECK_THAT(verdict("last ~ a + b*x", "stratum(g)"), Contains("all observations of G8 exactly"));
  }
}

TEST_CASE("a constant of the variance that only exact zeros determine has no maximum") {
  // At x = 0 response and curve are 0, and the standard deviation is sigma times the constant: the
  // log-likelihood is that of the other rows less ten times the logarithm of the constant.
  Random random(9);
  data::Table table;
  data::TextColumn group;
  std::vector<double> x;
  std::vector<double> y;
  for (int g = 0; g < 10; ++g) {
    for (const double value : {0.0, 1.0, 2.0, 4.0, 8.0, 16.0}) {
      x.push_back(value);
      y.push_back((12.0 + g * 0.2) * value / (3.0 + value) * (1.0 + random.normal(0.0, 0.08)));
      group.append(std::to_string(g));
    }
  }
  table.set("x", x);
  table.set("y", y);
  table.set("g", group);
  for (const std::string variance : {"constant-plus-power", "constant-plus-power(x)"}) {
    for (const std::string random_effect : {"", "V | g"}) {
      const ModelSpecification model = specify_model(
          {.formula = "y ~ V*x/(K + x)", .random = random_effect, .variance = variance}, table);
      const FittedModel fit = fit_model(model, table).fit;
      INFO(variance << " " << random_effect << ": " << fit.convergence.verdict());
      CHECK(fit.convergence.status == ConvergenceStatus::kNoMaximum);
      CHECK_THAT(fit.convergence.verdict(),
                 Contains("for 10 of the observations only the constant"));
    }
  }
}
