// SPDX-License-Identifier: MIT
// Degrees of freedom, intervals and profiles against R 4.2.2: nlme's own, and limits that plain
// definitions written in R find; tests/reference/expected/README.md says how.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "expected.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/intervals.hpp"
#include "silvafit/fit/observed_information.hpp"

using namespace silvafit;
using nlohmann::json;

namespace {

json figures(const std::string& name) {
  std::ifstream stream(test::source_file("tests/reference/expected/" + name + ".json"));
  return json::parse(stream).at("fits");
}

const json& inference_figures() {
  static const json result = [] {
    json all = figures("inference");
    for (const json& record : figures("profile_laplace")) all.at("profiles").push_back(record);
    return all;
  }();
  return result;
}

/// The thickest tree of each row's plot or stand: covariates that are constant within them.
void add_tops(data::Table& table) {
  const auto dbh = table.numbers("dbh");
  for (const char* const group : {"plot", "stand"}) {
    const data::TextColumn labels = table.labels(group);
    std::map<std::string, double> tops;
    const auto label = [&](std::size_t row) { return labels.levels()[labels.code(row)]; };
    for (std::size_t row = 0; row < table.rows(); ++row) {
      tops[label(row)] = std::max(tops[label(row)], dbh[row]);
    }
    std::vector<double> values(table.rows());
    for (std::size_t row = 0; row < table.rows(); ++row) values[row] = tops[label(row)];
    table.set(std::string(group) + "_top", values);
  }
}

data::Table stands_with_tops() {
  data::Table table = test::stands();
  add_tops(table);
  return table;
}

/// The members of an object, none of null.
const json& members(const json& object) {
  static const json none = json::object();
  return object.is_null() ? none : object;
}

std::vector<std::string> texts(const json& list) {
  std::vector<std::string> result;
  for (const json& one : list) result.push_back(one.get<std::string>());
  return result;
}

fit::FittedModel fitted_record(const json& record,
                               const data::Table& table,
                               const char* method = "") {
  fit::ModelSpecification specification = fit::specify_model(
      record.at("formula").get<std::string>(),
      record.contains("sub_models") ? texts(record["sub_models"]) : std::vector<std::string>{},
      table);
  if (const std::string random = record.value("random", ""); !random.empty()) {
    fit::add_random_effects(specification, random, table);
    if (record.value("covariance", json()) == "diagonal") {
      specification.random.back().covariance = fit::Covariance::kDiagonal;
    }
  }
  specification.variance = fit::parse_variance_function(record.value("variance", "none"));
  fit::FitModelOptions options{.reml = record.value("reml", false)};
  if (*method != '\0') options.method = value_of<fit::Method>(method, "method");
  return fit::fit_model(specification, table, options).fit;
}

const fit::ParameterInterval& named(const fit::Intervals& intervals, const std::string& name) {
  const auto found = std::ranges::find(intervals.parameters, name, &fit::ParameterInterval::name);
  REQUIRE(found != intervals.parameters.end());
  return *found;
}

/// Both limits, to a share of the interval's length.
void check_limits(const fit::ParameterInterval& ours, double lower, double upper, double share) {
  INFO(ours.name << " " << ours.lower << " to " << ours.upper << ", expected " << lower << " to "
                 << upper);
  const double margin = share * (upper - lower);
  CHECK(ours.lower == Approx(lower).margin(margin));
  CHECK(ours.upper == Approx(upper).margin(margin));
}

}  // namespace

TEST_CASE("t tests have nlme's degrees of freedom") {
  const data::Table table = stands_with_tops();
  for (const json& record : inference_figures().at("degrees_of_freedom")) {
    INFO(record["id"]);
    const fit::FittedModel fit = fitted_record(record, table);
    REQUIRE(fit.convergence.converged());
    for (std::size_t k = 0; k < record["coefficients"].size(); ++k) {
      const std::string name = record["coefficients"][k].get<std::string>();
      // nlme calls the intercept of a parameter with covariates "a.(Intercept)", others "a.x".
      std::string ours = name;
      if (const auto at = ours.find(".(Intercept)"); at != std::string::npos) ours.resize(at);
      std::ranges::replace(ours, '.', ':');
      const auto j = std::ranges::find(fit.coefficient_names, ours);
      INFO(ours);
      REQUIRE(j != fit.coefficient_names.end());
      CHECK(fit.degrees_of_freedom[j - fit.coefficient_names.begin()] ==
            record["df"][k].get<double>());
    }
  }
}

TEST_CASE("Wald intervals are those of nlme") {
  const data::Table table = stands_with_tops();
  for (const json& record : inference_figures().at("nlme_intervals")) {
    INFO(record["id"]);
    const fit::FittedModel fit = fitted_record(record, table);
    REQUIRE(fit.convergence.converged());
    const fit::Intervals ours = fit::confidence_intervals(fit, table);
    const double n = record["n"].get<double>();
    const double p = record["p"].get<double>();
    // nlme's Hessian is that of second differences of the log-likelihood, with some three digits;
    // for two other models of these data it is not even positive definite.
    constexpr double kDifferences = 0.01;
    const auto check = [&](const std::string& name, const json& limits, double tolerance) {
      check_limits(named(ours, name), limits[0].get<double>(), limits[2].get<double>(), tolerance);
    };
    const json& fixed = record["fixed"];
    for (const auto& [name, limits] : members(fixed).items()) {
      std::string coefficient = name;
      if (const auto at = name.find(".(Intercept)"); at != std::string::npos) {
        coefficient.resize(at);
      }
      std::ranges::replace(coefficient, '.', ':');
      // intervals() leaves out nlme's factor for maximum likelihood; gnls has it in sigma.
      const bool is_gnls = record["random"].get<std::string>().empty();
      const double factor = is_gnls ? 1.0 : std::sqrt(n / (n - p));
      const double middle = limits[1].get<double>();
      const double reach = factor * (limits[2].get<double>() - middle);
      check_limits(named(ours, coefficient), middle - reach, middle + reach, 1e-4);
    }
    const json& levels = record["random_intervals"];
    for (const auto& [group, rows] : members(levels).items()) {
      const std::string suffix = levels.size() > 1 ? " | " + group + ")" : ")";
      for (const auto& [name, limits] : rows.items()) {
        std::string parameter = name;
        for (const auto& [from, to] :
             {std::pair<std::string, std::string>{"(Intercept)", "a"}, {"dbh", "b"}, {",", ", "}}) {
          if (const auto at = parameter.find(from); at != std::string::npos) {
            parameter.replace(at, from.size(), to);
          }
        }
        parameter.pop_back();
        check(parameter + suffix, limits, kDifferences);
      }
    }
    const json& variance = record["variance_intervals"];
    for (const auto& [name, limits] : members(variance).items()) {
      check(name == "BHN" ? "ratio (BHN)" : "delta", limits, kDifferences);
    }
    const fit::ParameterInterval& sigma = named(ours, "sigma");
    // Of gnls nlme's sigma has n - p in the denominator.
    const bool is_gnls = record["random"].get<std::string>().empty();
    const double factor = is_gnls ? std::sqrt((n - p) / n) : 1.0;
    check_limits(sigma,
                 factor * record["sigma"][0].get<double>(),
                 factor * record["sigma"][2].get<double>(),
                 kDifferences);
  }
}

TEST_CASE("profile limits are where definitions written in R have them") {
  const data::Table table = stands_with_tops();
  for (const json& record : inference_figures().at("profiles")) {
    INFO(record["id"]);
    const std::string method = record["method"].get<std::string>();
    const fit::FittedModel fit = fitted_record(record, table, method.c_str());
    REQUIRE(fit.convergence.converged());
    // lb and nlme stop within 1e-6 standard errors of each other, which moves the likelihood of the
    // model linear there by as little.
    CHECK(fit.log_likelihood == Approx(record["logLik"].get<double>()).margin(1e-4));
    const fit::Intervals ours = fit::confidence_intervals(
        fit, table, {.method = fit::IntervalMethod::kProfile, .threads = 2});
    for (const auto& [name, limits] : record["limits"].items()) {
      // R's limits are roots to 1e-7 of inner maxima to about 1e-5 of the deviance.
      check_limits(named(ours, name), limits[0].get<double>(), limits[1].get<double>(), 2e-4);
    }
  }
}

TEST_CASE("the number of threads does not change profile intervals") {
  const data::Table table = stands_with_tops();
  for (const json& record : inference_figures().at("profiles")) {
    const fit::FittedModel fit =
        fitted_record(record, table, record["method"].get<std::string>().c_str());
    const auto with = [&](unsigned threads) {
      return fit::confidence_intervals(
          fit, table, {.method = fit::IntervalMethod::kProfile, .threads = threads});
    };
    const fit::Intervals one = with(1);
    const fit::Intervals three = with(3);
    for (std::size_t k = 0; k < one.parameters.size(); ++k) {
      CHECK(one.parameters[k].lower == three.parameters[k].lower);
      CHECK(one.parameters[k].upper == three.parameters[k].upper);
    }
  }
}

TEST_CASE("least squares has the exact Hessian next to that of Gauss and Newton") {
  const data::Table table = stands_with_tops();
  for (const json& record : inference_figures().at("profiles")) {
    if (record["id"] != "ols") continue;
    const fit::FittedModel fit = fitted_record(record, table, "ols");
    const fit::ObservedInformation information = fit::observed_information(fit, table);
    for (Eigen::Index i = 0; i < 2; ++i) {
      for (Eigen::Index j = 0; j < 2; ++j) {
        // Both are exact formulas at a minimum that nls has found to 1e-10.
        const auto at = [&](const char* key) { return record[key][i][j].get<double>(); };
        CHECK(information.fixed_covariance(i, j) == Approx(at("covariance")).epsilon(1e-6));
        CHECK(fit.covariance(i, j) == Approx(at("gauss_newton")).epsilon(1e-6));
      }
    }
    CHECK(information.scales.back() == "log");
    // Of log sigma: 1 / (2 (n - p)), which does not depend on the model.
    const double freedom = static_cast<double>(fit.observations - 2);
    CHECK(information.covariance(2, 2) == Approx(0.5 / freedom).epsilon(1e-4));
  }
}

TEST_CASE("a standard deviation of zero has an upper limit by the half-and-half mixture") {
  const json& record = inference_figures().at("edge");
  data::Table table;
  std::vector<double> x;
  std::vector<double> y;
  data::TextColumn plot;
  for (const json& row : record["data"]) {
    x.push_back(row["x"].get<double>());
    y.push_back(row["y"].get<double>());
    plot.append(std::to_string(row["plot"].get<int>()));
  }
  table.set("x", x);
  table.set("y", y);
  table.set("plot", plot);
  for (const char* const method : {"lb", "laplace"}) {
    INFO(method);
    const fit::FittedModel fit = fitted_record(record, table, method);
    REQUIRE(fit.convergence.converged());
    REQUIRE(fit.convergence.boundary() == std::vector<std::string>{"sd(a) = 0"});
    const fit::Intervals profile =
        fit::confidence_intervals(fit, table, {.method = fit::IntervalMethod::kProfile});
    const fit::ParameterInterval& sd = named(profile, "sd(a)");
    CHECK(sd.lower == Approx(0.0).margin(1e-6));
    const double upper = record["upper_one_sided"].is_array()
                             ? record["upper_one_sided"][0].get<double>()
                             : record["upper_one_sided"].get<double>();
    // The model is linear, so that both likelihoods are R's; its root is good to 1e-6.
    CHECK(sd.upper == Approx(upper).epsilon(1e-4));
    CHECK_FALSE(sd.note.empty());
    // A standard error means nothing there.
    const fit::Intervals wald = fit::confidence_intervals(fit, table);
    CHECK(std::isnan(named(wald, "sd(a)").upper));
    CHECK(std::isfinite(named(wald, "sigma").upper));
  }
}

TEST_CASE(
    "profile limits of a marginal likelihood are those of one valley, and widen with the level") {
  const data::Table table = data::read_csv_table(test::reference_data("spati.csv"));
  fit::ModelSpecification specification =
      fit::specify_model("h ~ 1.3 + d^2/(a + b*d)^2", {}, table);
  fit::add_random_effects(specification, "a + b | plot", table);
  specification.variance = fit::parse_variance_function("power(d)");
  const fit::FittedModel fitted =
      fit::fit_model(specification, table, {.method = fit::Method::kLaplace}).fit;
  double last = 1.0;
  for (const double level : {0.8, 0.9, 0.95, 0.99}) {
    const fit::Intervals intervals = fit::confidence_intervals(
        fitted, table, {.method = fit::IntervalMethod::kProfile, .level = level});
    const auto correlation = std::ranges::find(
        intervals.parameters, fit::ParameterKind::kCorrelation, &fit::ParameterInterval::kind);
    REQUIRE(correlation != intervals.parameters.end());
    INFO(level);
    CHECK(correlation->lower < last);
    last = correlation->lower;
    // Laplace's likelihood written in R and maximized with the correlation held has a deviance of
    // 3.84 at -0.655, and of 0.06 only where some searches get stuck in a plot's second mode.
    if (level == 0.95) CHECK(correlation->lower == Approx(-0.655).margin(1e-3));
  }
}
