// SPDX-License-Identifier: MIT
#include "silvafit/fit/fit_json.hpp"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <tuple>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/prediction.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Matchers::Contains;
using nlohmann::ordered_json;

namespace {

/// Eight plots of a Meyer curve with a power variance, plots in no alphabetical order.
data::Table stand() {
  Random random(7);
  std::vector<double> dbh;
  std::vector<double> h;
  std::vector<double> c;
  data::TextColumn plot;
  data::TextColumn species;
  for (int g = 8; g > 0; --g) {
    const double a = 25.0 + random.normal(0.0, 2.0);
    for (int i = 0; i < 25; ++i) {
      dbh.push_back(random.uniform(6.0, 50.0));
      c.push_back(0.25 * static_cast<double>(random.below(5)));
      const double mean = 1.3 + a * (1.0 - std::exp(-(0.05 - 0.01 * c.back()) * dbh.back()));
      h.push_back(mean * (1.0 + random.normal(0.0, 0.06)));
      plot.append(std::to_string(g));
      species.append(i % 3 == 0 ? "SM" : "BHN");
    }
  }
  data::Table table;
  table.set("dbh", dbh);
  table.set("h", h);
  table.set("C", c);
  table.set("plot", plot);
  table.set("species", species);
  return table;
}

FittedModel mixed_fit(const std::string& variance) {
  const data::Table table = stand();
  ModelSpecification specification = specify_model(
      "h ~ 1.3 + a*(1 - exp(-b*dbh))", {"b ~ 1 + C", R"(a ~ 1 + species == "SM")"}, table);
  add_random_effects(specification, "a + b | plot", table);
  specification.variance = parse_variance_function(variance);
  FittedModel fit = fit_model(specification, table).fit;
  fit.model = "M4";
  return fit;
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
         (std::isnan(a) && std::isnan(b));
}

bool same_bits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return false;
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    if (!same_bits(a.data()[i], b.data()[i])) return false;
  }
  return true;
}

void check_same(const FittedModel& a, const FittedModel& b) {
  CHECK(a.coefficient_names == b.coefficient_names);
  CHECK(same_bits(a.estimate, b.estimate));
  CHECK(same_bits(a.covariance, b.covariance));
  REQUIRE(a.random.size() == b.random.size());
  for (std::size_t k = 0; k < a.random.size(); ++k) {
    CHECK(a.random[k].names == b.random[k].names);
    CHECK(a.random[k].labels == b.random[k].labels);
    CHECK(same_bits(a.random[k].covariance, b.random[k].covariance));
    CHECK(same_bits(a.random[k].effects, b.random[k].effects));
  }
  CHECK(a.specification.variance.text() == b.specification.variance.text());
  CHECK(same_bits(a.variance.delta(), b.variance.delta()));
  CHECK(same_bits(a.variance.constant(), b.variance.constant()));
  CHECK(same_bits(a.sigma, b.sigma));
  CHECK(same_bits(a.log_likelihood, b.log_likelihood));
  CHECK(same_bits(a.bic(), b.bic()));
  CHECK(same_bits(a.p_values(), b.p_values()));
  CHECK(same_bits(a.conditional.rmse, b.conditional.rmse));
}

FittedModel round_trip(const FittedModel& fit) { return from_json(to_json(fit, 2), "fit.json"); }

std::string changed(const std::string& pointer, const ordered_json& value) {
  ordered_json json = ordered_json::parse(to_json(mixed_fit("power")));
  json[ordered_json::json_pointer(pointer)] = value;
  return json.dump();
}

std::string without(const std::string& key) {
  ordered_json json = ordered_json::parse(to_json(mixed_fit("power")));
  json.erase(key);
  return json.dump();
}

}  // namespace

TEST_CASE("a fit read back from JSON is identical, and gives the same bytes") {
  for (const char* variance : {"none", "exponential", "power(dbh)", "constant-plus-power"}) {
    const FittedModel fit = mixed_fit(variance);
    INFO(variance << ": " << fit.convergence.verdict());
    REQUIRE(fit.convergence.converged());
    check_same(round_trip(fit), fit);
    CHECK(to_json(round_trip(fit)) == to_json(fit));
  }
}

TEST_CASE("a fit from JSON has the predictions of the original fit") {
  const data::Table table = stand();
  const FittedModel fit = mixed_fit("power");
  const FittedModel read = round_trip(fit);
  for (const Level level : {Level::kPopulation, Level::kConditional}) {
    const Prediction before = predict(fit, table, level);
    const Prediction after = predict(read, table, level);
    CHECK(same_bits(before.value, after.value));
    CHECK(same_bits(before.residual_sd, after.residual_sd));
  }
}

TEST_CASE("factors and products are read back from JSON") {
  const data::Table table = stand();
  const ModelSpecification specification =
      specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {"b ~ C*species", "a ~ I(C^2)"}, table);
  const FittedModel fit = fit_model(specification, table).fit;
  const FittedModel read = round_trip(fit);
  check_same(read, fit);
  CHECK(to_json(read) == to_json(fit));
  CHECK(read.specification.factors == std::vector<std::string>{"species"});
  CHECK(fit.coefficient_names ==
        std::vector<std::string>{
            "a", "a:I(C^2)", "b", "b:C", R"(b:(species == "SM"))", R"(b:C:(species == "SM"))"});
  CHECK(same_bits(predict(fit, table, Level::kPopulation).value,
                  predict(read, table, Level::kPopulation).value));
}

TEST_CASE("sub-models of files are columns, of which old ones may be arithmetic") {
  // Before sub-models were those of R, `log(C + 1)*dbh` was one covariate.
  const ParameterModel model = parse_stored_parameter_model("b", "0 + log(C + 1)*dbh + C^2 + C/10");
  CHECK(model.coefficient_names() ==
        std::vector<std::string>{"b:log(C + 1)*dbh", "b:C^2", "b:C/10"});
}

TEST_CASE("the keys are those of the contract, in its order") {
  const ordered_json json = ordered_json::parse(to_json(mixed_fit("power")));
  std::vector<std::string> keys;
  for (const auto& item : json.items()) keys.push_back(item.key());
  const std::vector<std::string> expected{"schema",
                                          "silvafit",
                                          "model",
                                          "formula",
                                          "parameters",
                                          "method",
                                          "reml",
                                          "n",
                                          "excluded",
                                          "response_fingerprint",
                                          "groups",
                                          "converged",
                                          "status",
                                          "verdict",
                                          "evidence",
                                          "fixed",
                                          "fixed_covariance",
                                          "random",
                                          "variance",
                                          "sigma",
                                          "log_likelihood",
                                          "k",
                                          "aic",
                                          "aicc",
                                          "bic",
                                          "bic_groups",
                                          "statistics",
                                          "r2_marginal",
                                          "r2_conditional",
                                          "ranges",
                                          "seconds",
                                          "levels",
                                          "coefficients_between",
                                          "optima"};
  CHECK(keys == expected);
  CHECK(json["parameters"]["b"] == "1 + C");
  CHECK(json["groups"]["plot"] == 8);
  CHECK(json["random"][0]["eblup"].begin().key() == "8");
  CHECK(json["variance"]["of"] == "fitted");
  CHECK(json["variance"]["constant"].is_null());
  CHECK(json["levels"] == ordered_json{{"species", {"BHN", "SM"}}});
}

TEST_CASE("without random effects their list is empty") {
  const data::Table table = stand();
  const FittedModel fit =
      fit_model(specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {}, table), table).fit;
  const ordered_json json = ordered_json::parse(to_json(fit));
  CHECK(json["model"].is_null());
  CHECK(json["random"] == ordered_json::array());
  CHECK(json["parameters"].empty());
  CHECK(json["groups"].empty());
  CHECK(json["statistics"]["conditional"].is_null());
  CHECK(json["variance"]["function"] == "none");
  CHECK(json["variance"]["delta"].is_null());
  check_same(round_trip(fit), fit);
}

TEST_CASE("a fit that failed is still an object") {
  data::Table table;
  table.set("x", std::vector<double>{1.0, 2.0});
  table.set("y", std::vector<double>{1.0, 3.0});
  table.set("g", std::vector<double>{1.0, 2.0});
  ModelSpecification specification = specify_model("y ~ a + b*x + c*x^2", {}, table);
  add_random_effects(specification, "a | g", table);
  specification.variance = parse_variance_function("constant-plus-power");
  const FittedModel fit = fit_model(specification, table).fit;
  const ordered_json json = ordered_json::parse(to_json(fit));
  CHECK(json["converged"] == false);
  CHECK(json["status"] == "too_few_observations");
  CHECK_THAT(json["verdict"].get<std::string>(), Contains("there are 2. Use a model"));
  for (const char* key : {"log_likelihood", "k", "aic", "aicc", "bic", "sigma"}) {
    CHECK(json[key].is_null());
  }
  CHECK(json["fixed"]["a"]["estimate"].is_null());
  CHECK(json["random"][0]["covariance"][0][0].is_null());
  CHECK(json["variance"]["constant"].is_null());
  check_same(round_trip(fit), fit);
}

TEST_CASE("a fit that never began has its coefficients, without values") {
  FittedModel fit(specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {"b ~ 1 + C"}, stand()));
  fit.specification.random = parse_random_effects("a | plot");
  fit.set_missing(fit.specification);
  fit.convergence.verdict() = "The data do not suit it.";
  const FittedModel read = round_trip(fit);
  CHECK(read.coefficient_names == std::vector<std::string>{"a", "b", "b:C"});
  CHECK(std::isnan(read.estimate[2]));
  CHECK(read.has_random_effects());
  CHECK(read.convergence.verdict() == fit.convergence.verdict());
}

TEST_CASE("nested groups, blocks, strata and products are kept") {
  FittedModel fit(specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {"b ~ 1 + C"}, stand()));
  add_random_effects(fit.specification, "a | species; (a + b) + b:C | species/plot", stand());
  fit.specification.variance =
      parse_variance_function("stratum(species) * power(fitted | plot) * power(dbh, delta = 0.5)");
  fit.method = Method::kLaplace;
  fit.coefficient_names = fit.specification.coefficient_names();
  fit.estimate = Eigen::Vector3d(20.0, 0.05, -0.01);
  fit.covariance = Eigen::Matrix3d::Identity();
  fit.random = {{.names = {"a"},
                 .labels = {"SM"},
                 .covariance = Eigen::MatrixXd::Constant(1, 1, 4.0),
                 .effects = Eigen::MatrixXd::Constant(1, 1, -1.5)},
                {.names = fit.specification.random.back().coefficients,
                 .labels = {"SM/1", "SM/2"},
                 .covariance = Eigen::Matrix3d::Identity(),
                 .effects = Eigen::MatrixXd::Constant(3, 2, 0.25)}};
  fit.variance = VarianceEstimate::missing(fit.specification.variance);
  fit.variance.factors[0].strata = {"SM", "MH"};
  fit.variance.factors[0].ratio = Eigen::Vector2d(1.0, 1.4);
  fit.variance.factors[1].strata = {"1", "2"};
  fit.variance.factors[1].delta = Eigen::Vector2d(0.3, 0.6);
  const FittedModel read = round_trip(fit);
  check_same(read, fit);
  CHECK(read.method == Method::kLaplace);
  CHECK(read.specification.random.back().text() == "(a + b) + b:C");
  REQUIRE(read.specification.random.size() == 2);
  CHECK(read.specification.random.front().group == "species");
  CHECK(read.variance.factors[0].ratio == fit.variance.factors[0].ratio);
  CHECK(read.variance.factors[1].strata == fit.variance.factors[1].strata);
  CHECK(read.variance.factors[1].delta == fit.variance.factors[1].delta);
  CHECK(read.variance.factors[2].factor.delta == 0.5);
}

TEST_CASE("a variance that has become constant is read back as constant") {
  FittedModel fit = mixed_fit("constant-plus-power");
  fit.variance.factors[0].constant[0] = INFINITY;
  CHECK(std::isinf(round_trip(fit).variance.constant()));
}

TEST_CASE("inconsistent content is reported with file and key") {
  CHECK_THROWS_WITH(from_json("{\n\"schema\": ", "a.json"), Contains("a.json:2: not valid JSON"));
  CHECK_THROWS_WITH(from_json("[]", "a.json"), Contains("a.json: must be an object"));
  CHECK_THROWS_WITH(
      from_json(changed("/schema", "silvafit-fit/3"), "a.json"),
      Contains("a.json: schema: silvafit-fit/3 was written by another version of silvafit"));
  const auto library =
      data::JsonReader::parse("{\"models\": [" + without("sigma") + "]}", "a.json");
  CHECK_THROWS_WITH(from_json(library.at("models").items()[0]),
                    Contains("a.json: models[0]: the key \"sigma\" is missing"));
  CHECK_THROWS_WITH(from_json(changed("/formula", "h ~ 1 + *"), "a.json"),
                    Contains("a.json: formula: column"));
  CHECK_THROWS_WITH(from_json(changed("/method", "magic"), "a.json"),
                    Contains("a.json: method: must be one of ols, gnls"));
  CHECK_THROWS_WITH(from_json(changed("/fixed_covariance/1", {1, 2}), "a.json"),
                    Contains("a.json: fixed_covariance[1]: must have 4 numbers, not 2"));
  CHECK_THROWS_WITH(from_json(changed("/sigma", "large"), "a.json"),
                    Contains("a.json: sigma: must be a number or null, not \"large\""));
  CHECK_THROWS_WITH(from_json(changed("/random/0/effects/0", "z"), "a.json"),
                    Contains("a.json: random[0].effects[0]: unknown coefficient 'z'"));
  CHECK_THROWS_WITH(from_json(changed("/fixed/z", ordered_json::object()), "a.json"),
                    Contains("a.json: fixed: must name the coefficients"));
  CHECK_THROWS_WITH(from_json(changed("/random/0/covariance/0/0", -1.0), "a.json"),
                    Contains("a.json: random[0].covariance: has a negative variance"));
  for (const char* const place : {"/fixed_covariance/1/0", "/fixed_covariance/0/1"}) {
    CHECK_THROWS_WITH(from_json(changed(place, 1e-308), "a.json"),
                      Contains("fixed_covariance: must be a symmetric matrix"));
    CHECK_THROWS_WITH(from_json(changed(place, nullptr), "a.json"),
                      Contains("fixed_covariance: must be a symmetric matrix"));
  }
  ordered_json impossible = ordered_json::parse(changed("/fixed_covariance/0/1", 1e6));
  impossible["fixed_covariance"][1][0] = 1e6;
  CHECK_THROWS_WITH(from_json(impossible.dump(), "a.json"), Contains("contradict each other"));
}

TEST_CASE("correlations that no residuals can have are refused") {
  const auto with = [](const char* structure, const ordered_json& parameters, double unit) {
    const ordered_json correlation = {
        {"structure", structure}, {"parameters", parameters}, {"unit", unit}, {"largest_group", 5}};
    return from_json(changed("/correlation", correlation), "a.json");
  };
  CHECK(with("ar1(dbh)", {{"phi", 0.5}}, 1.0).variance.correlation->values[0] == 0.5);
  CHECK(with("car1(dbh)", {{"phi", 0.0}}, 1.0).variance.correlation->values[0] == 0.0);
  CHECK(with("arma(0, 1, dbh)", {{"theta1", -1.0}}, 1.0).variance.correlation->values[0] == -1.0);
  for (const auto& [structure, name, value, unit] :
       {std::tuple("ar1(dbh)", "phi", 1.0, 1.0),
        std::tuple("ar1(dbh)", "phi", -1.5, 1.0),
        std::tuple("car1(dbh)", "phi", 1.0, 1.0),
        std::tuple("car1(dbh)", "phi", -0.5, 1.0),
        std::tuple("arma(1, 0, dbh)", "phi1", 1.2, 1.0),
        std::tuple("compound-symmetry", "rho", 1.0, 1.0),
        std::tuple("compound-symmetry", "rho", -0.3, 1.0),
        std::tuple("exponential(dbh)", "range", -2.0, 1.0),
        std::tuple("exponential(dbh)", "range", 2.0, 0.0)}) {
    INFO(structure << " " << value);
    CHECK_THROWS_WITH(with(structure, {{name, value}}, unit), Contains("are outside the range of"));
  }
}

TEST_CASE("a fit with too many random effects is refused") {
  ordered_json json = ordered_json::parse(to_json(mixed_fit("none")));
  json["random"][0]["effects"] = std::vector<std::string>(13, "a");
  json["random"][0]["covariance"] =
      std::vector<std::vector<double>>(13, std::vector<double>(13, 0.0));
  CHECK_THROWS_AS(from_json(json.dump(), "fit.json"), InputError);
  CHECK_THROWS_WITH(from_json(json.dump(), "fit.json"), Contains("more than 12 random effects"));
}
