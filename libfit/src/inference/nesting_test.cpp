// SPDX-License-Identifier: MIT
#include "silvafit/fit/nesting.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/comparison.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/fit/likelihood_ratio.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Contains;

namespace {

constexpr int kStands = 5;
constexpr int kPlotsOfStand = 4;  // a stand
constexpr int kTreesOfPlot = 6;

/// Lines whose intercept differs by stand and plot. In `plot` the labels begin anew in each stand,
/// in `place` they do not.
data::Table stand_lines(const std::string& stand_prefix = "s") {
  Random random(17);
  data::Table table;
  data::TextColumn stand;
  data::TextColumn plot;
  data::TextColumn place;
  std::vector<double> x;
  std::vector<double> z;
  std::vector<double> y;
  for (int i = 0; i < kStands; ++i) {
    const double of_stand = random.normal(0.0, 1.0);
    for (int j = 0; j < kPlotsOfStand; ++j) {
      const double of_plot = random.normal(0.0, 1.0);
      for (int k = 0; k < kTreesOfPlot; ++k) {
        stand.append(stand_prefix + std::to_string(i));
        plot.append(std::to_string(j));
        place.append(std::to_string(i * kPlotsOfStand + j));
        x.push_back(k + 1.0);
        z.push_back(random.normal());
        y.push_back(10.0 + of_stand + of_plot + 2.0 * x.back() + 0.2 * z.back() + random.normal());
      }
    }
  }
  table.set("stand", stand);
  table.set("plot", plot);
  table.set("place", place);
  table.set("x", x);
  table.set("z", z);
  table.set("y", y);
  return table;
}

struct Case {
  std::vector<std::string> sub_models{};
  const char* random = "";
  const char* variance = "none";
  std::map<std::string, double> fixed{};
  std::map<std::string, Bounds> bounds{};
};

FittedModel fitted_case(const data::Table& table, const Case& of) {
  ModelSpecification model = specify_model("y ~ a + b*x", of.sub_models, table);
  if (*of.random != '\0') add_random_effects(model, of.random, table);
  model.variance = parse_variance_function(of.variance);
  FitModelOptions options;
  options.fixed = of.fixed;
  options.bounds = of.bounds;
  const FittedModel fit = fit_model(model, table, options).fit;
  INFO(of.variance << ": " << fit.convergence.verdict());
  REQUIRE(fit.convergence.converged());
  // The content of a file must be sufficient.
  return from_json(to_json(fit), "fit.json");
}

}  // namespace

TEST_CASE("groupings are one where their groups are, not where their columns are") {
  const data::Table table = stand_lines();
  const FittedModel within = fitted_case(table, {.random = "a | stand/plot"});
  REQUIRE(within.random.back().labels.size() == std::size_t{kStands} * kPlotsOfStand);
  // Plot 1 of all stands together is not a group of the nested model.
  const FittedModel crossing = fitted_case(table, {.random = "a | plot"});
  REQUIRE(crossing.random.back().labels.size() == kPlotsOfStand);
  CHECK_FALSE(nesting(within, crossing).is_nested);
  CHECK_THAT(nesting(within, crossing).reason,
             Contains("plot within stand (20 groups)") && Contains("plot (4 groups)"));
  CHECK_THROWS_AS(likelihood_ratio_test(within, crossing), UsageError);
  // If each label is in one stand, the groups are the same with and without stands.
  const FittedModel distinguished = fitted_case(table, {.random = "a | stand/place"});
  const FittedModel alone = fitted_case(table, {.random = "a | place"});
  CHECK(distinguished.log_likelihood == Approx(within.log_likelihood).epsilon(1e-9));
  const Nesting how = nesting(distinguished, alone);
  CHECK(how.is_nested);
  CHECK(how.independent_effects == 1);
  CHECK(how.regular == 0);
  // The coarser grouping has the same labels in both.
  CHECK(nesting(within, fitted_case(table, {.random = "a | stand"})).is_nested);
  CHECK_FALSE(nesting(alone, distinguished).is_nested);
}

TEST_CASE("labels with slashes distinguish groups as others do") {
  const data::Table table = stand_lines("north/");
  const FittedModel distinguished = fitted_case(table, {.random = "a | stand/place"});
  CHECK(nesting(distinguished, fitted_case(table, {.random = "a | place"})).is_nested);
}

TEST_CASE("groups of the same column with other labels, or without, are not known to be the same") {
  const data::Table table = stand_lines();
  const FittedModel larger =
      fitted_case(table, {.sub_models = {"a ~ 1 + z"}, .random = "a | stand"});
  FittedModel smaller = fitted_case(table, {.random = "a | stand"});
  CHECK(nesting(larger, smaller).is_nested);
  smaller.random.back().labels.back() = "elsewhere";
  CHECK_THAT(nesting(larger, smaller).reason, Contains("the groups may differ"));
  smaller.random.back().labels.clear();
  CHECK_THAT(nesting(larger, smaller).reason, Contains("does not store its groups by stand"));
}

TEST_CASE("a column that is another one in the other fit makes no special case") {
  const data::Table table = stand_lines();
  data::Table other = table;
  std::vector<double> squares(table.numbers("x").begin(), table.numbers("x").end());
  for (double& value : squares) value *= value;
  other.set("x", squares);
  const FittedModel larger = fitted_case(table, {.random = "a | place"});
  CHECK(nesting(larger, fitted_case(table, {})).is_nested);
  const Nesting how = nesting(larger, fitted_case(other, {}));
  CHECK_FALSE(how.is_nested);
  CHECK(how.reason == "the column x differs between the fits: 1 to 36, and 1 to 6");
}

TEST_CASE("labels that may belong to two stands are not sufficient") {
  const data::Table table = stand_lines();
  FittedModel nested = fitted_case(table, {.random = "a | stand/place"});
  FittedModel alone = fitted_case(table, {.random = "a | place"});
  // "n/1/2" is plot 1/2 of stand n, or plot 2 of stand n/1.
  nested.random.front().labels = {"n", "n/1"};
  nested.random.back().labels = {"n/1/2", "n/3"};
  alone.random.back().labels = {"1/2", "3"};
  CHECK(nesting(nested, alone).is_nested);
  alone.random.back().labels = {"1/2", "2"};
  CHECK_FALSE(nesting(nested, alone).is_nested);
}

TEST_CASE("many nested groups are compared in time that grows as their number") {
  const data::Table table = stand_lines();
  FittedModel nested = fitted_case(table, {.random = "a | stand/place"});
  FittedModel alone = fitted_case(table, {.random = "a | place"});
  nested.random.front().labels.clear();
  nested.random.back().labels.clear();
  alone.random.back().labels.clear();
  constexpr int kManyStands = 25000;
  for (int plot = 0; plot < 4 * kManyStands; ++plot) {
    const std::string stand = std::to_string(plot / 4);
    if (plot % 4 == 0) nested.random.front().labels.push_back(stand);
    nested.random.back().labels.push_back(nested_label(stand, std::to_string(plot)));
    alone.random.back().labels.push_back(std::to_string(plot));
  }
  const auto start = std::chrono::steady_clock::now();
  CHECK(nesting(nested, alone).is_nested);
  nested.random.back().labels[1] = nested_label("0", "0");
  CHECK_FALSE(nesting(nested, alone).is_nested);
  nested.random.back().labels[1] = nested_label("elsewhere", "1");
  CHECK_FALSE(nesting(nested, alone).is_nested);
  // Tenths of a second; each plot against each stand would be 2.5e9 labels, minutes.
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(20));
}

TEST_CASE("a held coefficient is a special case of one that is estimated or held there") {
  const data::Table table = stand_lines();
  const FittedModel free = fitted_case(table, {});
  const FittedModel at_nine = fitted_case(table, {.fixed = {{"a", 9.0}}});
  const FittedModel at_nine_more =
      fitted_case(table, {.sub_models = {"b ~ 1 + z"}, .fixed = {{"a", 9.0}}});
  const FittedModel at_eight_more =
      fitted_case(table, {.sub_models = {"b ~ 1 + z", "a ~ 1 + z"}, .fixed = {{"a", 8.0}}});
  // y - 9 = b x and y = a + b x by their normal equations: the likelihood ratio is n
  // log(SSE0/SSE1).
  const std::size_t n = table.rows();
  const auto x = table.numbers("x");
  const auto y = table.numbers("y");
  double sx = 0.0;
  double sy = 0.0;
  double sxx = 0.0;
  double sxy = 0.0;
  double syy = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    sx += x[i];
    sy += y[i];
    sxx += x[i] * x[i];
    sxy += x[i] * y[i];
    syy += y[i] * y[i];
  }
  const auto count = static_cast<double>(n);
  const double held_sse = (syy - 18.0 * sy + 81.0 * count) - std::pow(sxy - 9.0 * sx, 2) / sxx;
  const double cxx = sxx - sx * sx / count;
  const double cxy = sxy - sx * sy / count;
  const double free_sse = syy - sy * sy / count - cxy * cxy / cxx;
  const NestedTest test = likelihood_ratio_test(free, at_nine);
  CHECK(test.degrees_of_freedom == 1);
  CHECK(test.statistic == Approx(count * std::log(held_sse / free_sse)).epsilon(1e-9));
  CHECK(nesting(free, at_nine).regular == 1);
  CHECK(nesting(at_nine_more, at_nine).regular == 1);

  CHECK_THAT(nesting(at_nine_more, free).reason, Contains("fixes a at 9"));
  CHECK_THROWS_AS(likelihood_ratio_test(at_nine_more, free), UsageError);
  CHECK_THAT(nesting(at_eight_more, at_nine).reason,
             Contains("fixes a at 8; the smaller model has 9"));
}

TEST_CASE("a coefficient that a model does not have is at zero") {
  const data::Table table = stand_lines();
  const FittedModel without = fitted_case(table, {});
  const FittedModel larger = fitted_case(table, {.sub_models = {"a ~ 1 + z", "b ~ 1 + z"}});
  CHECK(nesting(larger, without).regular == 2);
  const FittedModel at_half =
      fitted_case(table, {.sub_models = {"a ~ 1 + z", "b ~ 1 + z"}, .fixed = {{"a:z", 0.5}}});
  CHECK_THAT(nesting(at_half, without).reason,
             Contains("fixes a:z at 0.5; the smaller model has 0"));
  const FittedModel at_zero =
      fitted_case(table, {.sub_models = {"a ~ 1 + z", "b ~ 1 + z"}, .fixed = {{"a:z", 0.0}}});
  CHECK(nesting(at_zero, without).is_nested);
  CHECK(nesting(at_zero, without).regular == 1);
}

TEST_CASE("without any variance the held coefficients are unknown") {
  const data::Table table = stand_lines();
  const FittedModel larger = fitted_case(table, {.sub_models = {"a ~ 1 + z"}});
  FittedModel smaller = fitted_case(table, {});
  smaller.covariance.setConstant(std::nan(""));
  CHECK_THAT(nesting(larger, smaller).reason, Contains("does not store which coefficients"));
}

TEST_CASE("a held exponent is no special case of a constant variance, nor contains one") {
  const data::Table table = stand_lines();
  // Without strata and random effects, so that gnls is the method of all.
  const FittedModel none = fitted_case(table, {.variance = "stratum(stand)"});
  const auto with = [&](const char* variance, std::vector<std::string> more = {"a ~ 1 + z"}) {
    return fitted_case(table, {.sub_models = std::move(more), .variance = variance});
  };
  const FittedModel held = with("stratum(stand) * power(x, delta = 0.5)");
  CHECK_THAT(nesting(held, none).reason, Contains("fixes the exponent of power(x, delta = 0.5)"));
  CHECK_THROWS_AS(likelihood_ratio_test(held, none), UsageError);
  CHECK_FALSE(nesting(with("stratum(stand) * exponential(x, delta = 0.1)"), none).is_nested);
  // With an estimated delta, delta = 0 is the constant; a power held at 0 is a constant, too.
  CHECK(nesting(with("stratum(stand) * power(x)"), none).is_nested);
  CHECK(nesting(with("stratum(stand) * power(x, delta = 0)"), none).is_nested);
  CHECK(
      nesting(with("stratum(stand) * power(x)"), with("stratum(stand) * power(x, delta = 0.5)", {}))
          .is_nested);
  CHECK(nesting(held, with("stratum(stand) * power(x, delta = 0.5)", {})).is_nested);
}

TEST_CASE("a coefficient at a bound is a special case of one that is estimated") {
  const data::Table table = stand_lines();
  const FittedModel free = fitted_case(table, {});
  // The data have a = 10 and b = 2.
  const FittedModel at_bound = fitted_case(table, {.bounds = {{"a", {.low = 12.0}}}});
  const FittedModel held = fitted_case(table, {.fixed = {{"a", 12.0}}});
  const NestedTest test = likelihood_ratio_test(free, at_bound);
  CHECK(test.degrees_of_freedom == 1);
  CHECK(test.statistic == Approx(likelihood_ratio_test(free, held).statistic).epsilon(1e-9));
  CHECK_THAT(test.note, Contains("at its bound"));
  CHECK(likelihood_ratio_test(free, held).note.empty());
  // However many parameters they count, the free fit is the larger one.
  CHECK(free.parameter_count == at_bound.parameter_count);
  for (const auto& order : {std::vector{&free, &at_bound}, std::vector{&at_bound, &free}}) {
    const Comparison comparison = compare(order);
    CHECK(comparison.fits.back().fit == &free);
    CHECK(comparison.pairs.front().test.has_value());
  }
  const FittedModel both =
      fitted_case(table, {.bounds = {{"a", {.low = 12.0}}, {"b", {.low = 3.0}}}});
  REQUIRE(both.covariance.diagonal().array().isNaN().all());
  CHECK(likelihood_ratio_test(free, both).degrees_of_freedom == 2);
  CHECK_FALSE(nesting(both, free).is_nested);
}

TEST_CASE("the identity of one effect is that effect's variance") {
  const data::Table table = stand_lines();
  const FittedModel both = fitted_case(table, {.random = "a + b | stand"});
  FittedModel one = fitted_case(table, {.random = "a | stand"});
  one.specification.random.back().covariance = Covariance::kIdentity;
  const Nesting how = nesting(both, one);
  CHECK(how.is_nested);
  CHECK(how.correlated_effects == 1);
  CHECK(nesting(one, fitted_case(table, {.random = "a | stand"})).is_nested);
  FittedModel joint = both;
  joint.specification.random.back().covariance = Covariance::kIdentity;
  CHECK_THAT(nesting(joint, one).reason,
             Contains("does not contain a model with one random effect"));
  CHECK(nesting(both, joint).is_nested);
}

TEST_CASE("compound symmetry is between the identity and a general covariance") {
  const FittedModel general = fitted_case(stand_lines(), {.random = "a + b | stand"});
  const auto with = [&](Covariance form) {
    FittedModel fit = general;
    fit.specification.random.back().covariance = form;
    return fit;
  };
  const FittedModel symmetric = with(Covariance::kCompoundSymmetry);
  CHECK(nesting(general, symmetric).regular == 1);  // 3 parameters and 2
  CHECK(nesting(symmetric, with(Covariance::kIdentity)).regular == 1);
  CHECK_FALSE(nesting(symmetric, with(Covariance::kDiagonal)).is_nested);
  CHECK_FALSE(nesting(with(Covariance::kDiagonal), symmetric).is_nested);
}

TEST_CASE("factors of a variance function are paired by their strata, in any order") {
  const data::Table table = stand_lines();
  FittedModel larger = fitted_case(table, {});
  FittedModel smaller = larger;
  const auto is_nested = [&](const char* large, const char* small) {
    larger.specification.variance = parse_variance_function(large);
    smaller.specification.variance = parse_variance_function(small);
    return nesting(larger, smaller).is_nested;
  };
  CHECK(is_nested("stratum(plot) * stratum(stand)", "stratum(stand)"));
  CHECK(is_nested("stratum(plot) * stratum(stand)", "stratum(plot)"));
  CHECK(is_nested("stratum(plot) * stratum(stand)", "stratum(stand) * stratum(plot)"));
  CHECK(is_nested("power(x | stand) * power(x)", "power(x) * power(x | stand)"));
  CHECK(is_nested("power(x | stand)", "power(x)"));
  CHECK(is_nested("constant-plus-power(x) * power(x | stand)", "power(x | stand)"));
  CHECK_FALSE(is_nested("stratum(plot)", "stratum(stand)"));
  CHECK_FALSE(is_nested("power(x)", "power(x | stand)"));
}

TEST_CASE("a covariate that is zero somewhere does not change the formula of a fit") {
  // At z = 0 a power c*z of the base has no derivative by c of its own, only a limit.
  Random random(5);
  data::Table table;
  std::vector<double> x;
  std::vector<double> z;
  std::vector<double> y;
  for (int i = 0; i < 60; ++i) {
    x.push_back(1.0 + 0.5 * i);
    z.push_back(i % 4);
    y.push_back(20.0 * std::pow(1.0 - std::exp(-0.1 * x.back()), 1.3) + random.normal(0.0, 0.3));
  }
  table.set("x", x);
  table.set("z", z);
  table.set("y", y);
  const auto fitted = [&table](const std::vector<std::string>& sub_models) {
    return fit_model(specify_model("y ~ a*(1 - exp(-b*x))^c", sub_models, table), table).fit;
  };
  const FittedModel smaller = fitted({});
  for (const char* const sub_model : {"a ~ 1 + z", "b ~ 1 + z", "c ~ 1 + z"}) {
    INFO(sub_model);
    const FittedModel larger = fitted({sub_model});
    CHECK(larger.specification.formula.right.text() == "a*(1 - exp(-b*x))^c");
    CHECK(likelihood_ratio_test(larger, smaller).degrees_of_freedom == 1);
  }
}
