// SPDX-License-Identifier: MIT
// Results do not depend on the units of the data or on the origin of a covariate.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/intervals.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Eigen::Index;

namespace {

/// Shares of standard errors, estimates and sums of squares, and units of the log-likelihood, to
/// which fits agree.
struct Precision {
  double errors = 0.0;
  double estimates = 0.0;
  double log_likelihood = 0.0;
};
// Differences of gradients give standard errors six digits, of which a covariate near 1e6 takes
// two.
constexpr Precision kFixedSlopes{.errors = 1e-4, .estimates = 1e-5, .log_likelihood = 1e-5};
// Random intercepts are then near 1e5 in each plot, and a mean of order ten is what they and the
// slopes leave of each other: twelve digits, of which gradients keep nine and their differences
// four.
constexpr Precision kRandomSlopes{.errors = 2e-3, .estimates = 1e-4, .log_likelihood = 1e-4};

const std::vector<std::string> kMixed{"lb", "foce", "focei", "laplace", "agq"};

/// How the data are written: x as factor * x + origin, the response in other units.
struct Scale {
  double origin = 0.0;
  double factor = 1.0;
  double response = 1.0;
};

/// Heights over diameters in plots along a line x, in m.
data::Table trees(const Scale& scale) {
  Random random(21);
  data::Table table;
  data::TextColumn plot;
  std::vector<double> x;
  std::vector<double> d;
  std::vector<double> h;
  for (int i = 0; i < 14; ++i) {
    const double limit = random.normal(0.0, 2.0);
    const double slope = random.normal(0.0, 0.08);
    for (int j = 0; j < 9; ++j) {
      const double place = random.uniform(-12.0, 12.0);
      d.push_back(random.uniform(6.0, 40.0));
      const double mean =
          (22.0 + limit + (0.1 + slope) * place) * (1.0 - std::exp(-0.07 * d.back()));
      h.push_back(scale.response * mean * (1.0 + random.normal(0.0, 0.06)));
      x.push_back(scale.factor * place + scale.origin);
      plot.append(std::to_string(i));
    }
  }
  table.set("x", x);
  table.set("d", d);
  table.set("h", h);
  table.set("plot", plot);
  return table;
}

struct Case {
  std::string formula{};
  std::vector<std::string> parameters{};
  std::string random{};
  std::string variance{};
  std::string slope{};  ///< the coefficient of x
  bool reml = false;
};

FittedModel fitted(const Case& of, const data::Table& table, const std::string& method) {
  ModelSpecification model = specify_model(of.formula, of.parameters, table);
  if (!of.random.empty()) add_random_effects(model, of.random, table);
  if (!of.variance.empty()) model.variance = parse_variance_function(of.variance);
  FitModelOptions options;
  options.method = value_of<Method>(method, "method");
  options.reml = of.reml;
  return fit_model(model, table, options).fit;
}

double error_of(const FittedModel& fit, Index j) { return std::sqrt(fit.covariance(j, j)); }

/// Checks estimates and standard errors, except those of constants at x = 0.
void check_coefficients(const FittedModel& fit,
                        const FittedModel& other,
                        const Scale& scale,
                        const Case& of,
                        const Precision& precision) {
  for (Index j = 0; j < fit.estimate.size(); ++j) {
    const std::string& name = fit.coefficient_names[static_cast<std::size_t>(j)];
    INFO(name);
    const bool is_slope = name == of.slope;
    const bool is_constant = name == "a";
    if (is_constant && scale.origin != 0.0) continue;
    const double unit =
        (is_slope ? 1.0 / scale.factor : 1.0) * (is_slope || is_constant ? scale.response : 1.0);
    CHECK(error_of(other, j) / unit == Approx(error_of(fit, j)).epsilon(precision.errors));
    CHECK(other.estimate[j] / unit ==
          Approx(fit.estimate[j]).epsilon(0.0).margin(1e-3 * error_of(fit, j)));
  }
}

/// Checks that two fits are equal except for the scale of the second one's data.
void check_same(const FittedModel& fit,
                const FittedModel& other,
                const Scale& scale,
                const Case& of,
                const Precision& precision) {
  INFO(fit.convergence.verdict() << " / " << other.convergence.verdict());
  REQUIRE(fit.convergence.converged());
  REQUIRE(other.convergence.converged());
  CHECK(other.convergence.boundary() == fit.convergence.boundary());
  CHECK(other.convergence.rank == fit.convergence.rank);
  const auto n = static_cast<double>(fit.observations);
  // The restricted likelihood is of contrasts whose scale is that of the covariates.
  if (!of.reml) {
    CHECK(other.log_likelihood + n * std::log(scale.response) ==
          Approx(fit.log_likelihood).epsilon(0.0).margin(precision.log_likelihood));
  }
  check_coefficients(fit, other, scale, of, precision);
  if (!fit.has_random_effects()) return;
  CHECK(other.r2_marginal == Approx(fit.r2_marginal).epsilon(precision.estimates));
  CHECK(other.r2_conditional == Approx(fit.r2_conditional).epsilon(precision.estimates));
}
const std::vector<Scale> kScales{{.origin = 1e6},
                                 {.factor = 1000.0},
                                 {.response = 1000.0},
                                 {.origin = 1e6, .response = 1000.0},
                                 {.origin = -1e6, .response = 0.01}};

void check_invariant(const Case& of,
                     const std::vector<std::string>& methods,
                     const Precision& precision) {
  for (const std::string& method : methods) {
    const FittedModel fit = fitted(of, trees({}), method);
    for (const Scale& scale : kScales) {
      INFO(of.formula << " " << of.random << " " << method << ": x * " << scale.factor << " + "
                      << scale.origin << ", y * " << scale.response);
      check_same(fit, fitted(of, trees(scale), method), scale, of, precision);
    }
  }
}

}  // namespace

TEST_CASE("the units of the data and the origin of a covariate do not matter") {
  const Case covariate{.formula = "h ~ a*(1 - exp(-b*d))",
                       .parameters = {"a ~ 1 + x"},
                       .random = "a | plot",
                       .slope = "a:x"};
  check_invariant(covariate, kMixed, kFixedSlopes);
  Case pooled = covariate;
  pooled.random.clear();
  check_invariant(pooled, {"ols", "gnls"}, kFixedSlopes);
  pooled.variance = "power";
  check_invariant(pooled, {"gnls"}, kFixedSlopes);
  Case power = covariate;
  power.variance = "power";
  check_invariant(power, {"lb", "laplace", "focei"}, kFixedSlopes);
  Case restricted = covariate;
  restricted.reml = true;
  check_invariant(restricted, {"lb"}, kFixedSlopes);
  restricted.variance = "constant-plus-power";
  check_invariant(restricted, {"lb"}, kFixedSlopes);
}

TEST_CASE("random slopes do not depend on the origin of their covariate") {
  const Case in_formula{
      .formula = "h ~ (a + s*x)*(1 - exp(-b*d))", .random = "a + s | plot", .slope = "s"};
  check_invariant(in_formula, kMixed, kRandomSlopes);
  const Case in_parameter{.formula = "h ~ a*(1 - exp(-b*d))",
                          .parameters = {"a ~ 1 + x"},
                          .random = "a + a:x | plot",
                          .slope = "a:x"};
  check_invariant(in_parameter, kMixed, kRandomSlopes);
  Case restricted = in_formula;
  restricted.reml = true;
  check_invariant(restricted, {"lb"}, kRandomSlopes);
}

TEST_CASE("intervals do not depend on the origin of a covariate") {
  const Case of{.formula = "h ~ (a + s*x)*(1 - exp(-b*d))", .random = "a + s | plot", .slope = "s"};
  const Scale scale{.origin = 1e6};
  for (const char* const method : {"lb", "laplace"}) {
    const FittedModel fit = fitted(of, trees({}), method);
    const FittedModel other = fitted(of, trees(scale), method);
    for (const IntervalMethod kind : {IntervalMethod::kWald, IntervalMethod::kProfile}) {
      const Intervals near = confidence_intervals(fit, trees({}), {.method = kind});
      const Intervals far = confidence_intervals(other, trees(scale), {.method = kind});
      REQUIRE(near.parameters.size() == far.parameters.size());
      for (std::size_t k = 0; k < near.parameters.size(); ++k) {
        const ParameterInterval& a = near.parameters[k];
        const ParameterInterval& b = far.parameters[k];
        INFO(method << " " << word_of(kind) << " " << a.name << " " << b.note);
        const bool is_of_origin = a.name == "a" || a.name == "sd(a)" || a.name == "cor(a, s)";
        if (is_of_origin) continue;
        const double margin = kRandomSlopes.errors * (a.upper - a.lower);
        CHECK(b.lower == Approx(a.lower).epsilon(0.0).margin(margin));
        CHECK(b.upper == Approx(a.upper).epsilon(0.0).margin(margin));
      }
    }
  }
}

TEST_CASE("standard errors do not depend on the origin of a column in an exponent") {
  // With yr - 1985 the curve is the same and only A differs, by the factor exp(-1985 k).
  Random random(7);
  data::Table table;
  data::TextColumn group;
  std::vector<double> year;
  std::vector<double> y;
  for (int g = 0; g < 5; ++g) {
    const double own = random.normal(0.0, 1.5);
    for (int i = 0; i < 13; ++i) {
      year.push_back(1985.0 + 2.0 * i);
      y.push_back(12.0 + own + 40.0 * std::exp(-0.09 * 2.0 * i) + random.normal(0.0, 1.5));
      group.append(std::to_string(g));
    }
  }
  table.set("yr", year);
  table.set("y", y);
  table.set("g", group);
  for (const Method method : {Method::kFirstOrder, Method::kInteraction, Method::kLaplace}) {
    for (const char* const random_effect : {"c | g", "A | g"}) {
      INFO(word_of(method) << " " << random_effect);
      const auto errors = [&](const std::string& x) {
        const ModelSpecification model = specify_model(
            {.formula = "y ~ c + A*exp(-k*" + x + ")", .random = random_effect}, table);
        const FittedModel fit = fit_model(model, table, {.method = method}).fit;
        REQUIRE(fit.convergence.converged());
        return fit.standard_errors();
      };
      const Eigen::VectorXd far = errors("yr");
      const Eigen::VectorXd near = errors("(yr - 1985)");
      CHECK(far[0] == Approx(near[0]).epsilon(2e-3));
      CHECK(far[2] == Approx(near[2]).epsilon(2e-3));
    }
  }
}
