// SPDX-License-Identifier: MIT
// Mixed models against R 4.2.2 with nlme 3.1.162, through the program's own JSON and without start
// values.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "fir_mixed.hpp"
#include "public_data.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/fit/fitted_model.hpp"

using namespace silvafit;
using fit::FitResult;
using nlohmann::json;

namespace {

const std::map<std::string, std::string> kNlmeVariances{{"none", "none"},
                                                        {"varExp", "exponential"},
                                                        {"varPower", "power"},
                                                        {"varConstPower", "constant-plus-power"}};

/// nlme stops short here: its log-likelihood is below that of the same model with varPower, which
/// constant-plus-power contains (see the notes beside the reference numbers).
const std::set<std::string> kStoppedShort{
    "spati_curtis_varConstPower", "spati_korf_varConstPower", "SM_h_nlme_varConstPower"};

/// The reference's formula, whose names that are no columns are our coefficients.
FitResult fitted_as_nlme(const json& reference, const data::Table& table) {
  fit::ModelSpecification specification =
      fit::specify_model(reference["formula"].get<std::string>(), {}, table);
  std::string random;
  for (const json& name : reference["random_names"]) {
    random += (random.empty() ? "" : " + ") + name.get<std::string>();
  }
  fit::add_random_effects(
      specification, random + " | " + reference["group"].get<std::string>(), table);
  specification.variance =
      fit::parse_variance_function(kNlmeVariances.at(reference["varfun"].get<std::string>()));
  return fit::fit_model(specification, table);
}

/// Points of the likelihood at which nlme's tolerances allow a comparison: tight control, a
/// covariance well inside its range, general as ours, and the same maximum.
bool is_comparable_with_nlme(const json& reference, double log_likelihood) {
  return reference["control"] == "tight" &&
         reference["random_cor_min_eigen"].get<double>() > 1e-3 &&
         reference["random_structure"].get<std::string>().starts_with("pdSymm") &&
         !kStoppedShort.contains(reference["id"].get<std::string>()) &&
         std::abs(log_likelihood - reference["logLik"].get<double>()) < 1e-4;
}

void check_estimates(const json& reference, const json& ours) {
  for (const auto& [name, value] : reference["estimates"].items()) {
    INFO(name);
    const double error = reference["std_errors"][name].get<double>();
    // To 1e-5 relative, or 1e-4 standard errors because of nlme's stopping rule.
    const double tolerance = std::max(1e-5 * std::abs(value.get<double>()), 1e-4 * error);
    CHECK(ours["fixed"][name]["estimate"].get<double>() ==
          Approx(value.get<double>()).margin(tolerance));
    CHECK(ours["fixed"][name]["se"].get<double>() == Approx(error).epsilon(1e-4));
  }
}

/// nlme's residual standard deviation at a fitted value.
double residual_sd(const json& reference, double fitted) {
  const json& parameters = reference["varfun_params"];
  const double sigma = reference["sigma"].get<double>();
  if (reference["varfun"] == "varExp") {
    return sigma * std::exp(parameters["expon"].get<double>() * fitted);
  }
  if (reference["varfun"] == "none") return sigma;
  const double power = std::pow(std::abs(fitted), parameters["power"].get<double>());
  if (reference["varfun"] == "varPower") return sigma * power;
  return sigma * (parameters["const"].get<double>() + power);
}

void check_variance_of_nlme(const json& reference, const json& ours) {
  // sigma, delta and the constant lie on a ridge: sigma = s v^-delta for a typical v, so that their
  // own digits are fewer than those of the standard deviation that they make.
  const double digits = reference["varfun"] == "none" ? 1e-5 : 5e-4;
  CHECK(ours["sigma"].get<double>() == Approx(reference["sigma"].get<double>()).epsilon(digits));
  const std::map<std::string, std::string> names{
      {"expon", "delta"}, {"power", "delta"}, {"const", "constant"}};
  for (const auto& [name, value] : reference["varfun_params"].items()) {
    // A constant near zero is an effect of nlme's logarithmic scale and is not compared.
    if (name == "const" && value.get<double>() < 1e-3) continue;
    INFO(name);
    CHECK(ours["variance"][names.at(name)].get<double>() ==
          Approx(value.get<double>()).epsilon(digits));
  }
}

/// Predictions for the trees of the reference, matched by number.
void check_fitted(const json& reference,
                  const FitResult& result,
                  const data::Table& table,
                  const std::string& id_column) {
  const json& first = reference["first20"];
  std::map<double, Eigen::Index> observation_of;
  for (std::size_t i = 0; i < result.rows.size(); ++i) {
    observation_of[table.numbers(id_column)[result.rows[i]]] = static_cast<Eigen::Index>(i);
  }
  for (std::size_t i = 0; i < first["id"].size(); ++i) {
    const Eigen::Index observation = observation_of.at(first["id"][i].get<double>());
    CHECK(result.fitted_conditional[observation] ==
          Approx(first["fitted1"][i].get<double>()).margin(1e-4));
    CHECK(result.residual_sd[observation] ==
          Approx(residual_sd(reference, first["fitted1"][i].get<double>())).epsilon(2e-5));
  }
}

void check_against_nlme(const json& reference,
                        const data::Table& table,
                        const std::string& id_column) {
  const FitResult result = fitted_as_nlme(reference, table);
  const json ours = json::parse(fit::to_json(result.fit));
  INFO(reference["id"].get<std::string>() << ": " << ours["verdict"].get<std::string>());
  CHECK(ours["converged"].get<bool>());
  CHECK(ours["n"] == reference["n"]);
  REQUIRE(ours["log_likelihood"].is_number());
  const double log_likelihood = ours["log_likelihood"].get<double>();
  CHECK(log_likelihood > reference["logLik"].get<double>() - 1e-3);
  if (reference["random_structure"].get<std::string>().starts_with("pdSymm")) {
    CHECK(ours["k"] == reference["df"]);
  }
  if (!is_comparable_with_nlme(reference, log_likelihood)) return;
  check_estimates(reference, ours);
  check_variance_of_nlme(reference, ours);
  check_fitted(reference, result, table, id_column);
  CHECK(ours["aic"].get<double>() == Approx(reference["AIC"].get<double>()).margin(2e-4));
  CHECK(ours["bic"].get<double>() == Approx(reference["BIC"].get<double>()).margin(2e-4));
  CHECK(ours["statistics"]["conditional"]["rmse"].get<double>() ==
        Approx(reference["stats_conditional"]["RMSE"].get<double>()).epsilon(1e-5));
}

bool is_mixed(const json& reference) { return reference.contains("random_names"); }

}  // namespace

TEST_CASE("the mixed models of the study agree with nlme", "[reference][slow]") {
  const json file = test::read_expected("fir_mixed_nlme.json");
  const std::string species = GENERATE("SM", "BHN", "MH");
  const data::Table table = test::fir_mixed(species);
  int compared = 0;
  for (const json& reference : file["fits"]) {
    if (!is_mixed(reference) || reference["species"] != species) continue;
    check_against_nlme(reference, table, "tree");
    ++compared;
  }
  CHECK(compared == 12);
}

TEST_CASE("mixed models of public data agree with nlme", "[reference][slow]") {
  const json file = test::read_expected("public_nlme.json");
  const std::string name = GENERATE("Loblolly", "Orange", "spati", "alsTree");
  const data::Table table = test::public_table(name);
  for (const json& reference : file["fits"]) {
    const std::string id = reference["id"].get<std::string>();
    if (!is_mixed(reference) || !id.starts_with(name)) continue;
    check_against_nlme(reference, table, "number");
  }
}

TEST_CASE("rounding errors do not hide a fixed point", "[reference][slow]") {
  // The derivatives of Korf's curve are nearly dependent, so that the steps of penalized least
  // squares end at rounding errors that are far above the tolerance. The marginal likelihood has
  // its maximum nearby.
  const data::Table table = test::public_table("spati");
  fit::ModelSpecification specification =
      fit::specify_model("h ~ 1.3 + a*exp(-b*d^(-c))", {}, table);
  fit::add_random_effects(specification, "a + b + c | plot", table);
  const fit::FittedModel linearized = fit::fit_model(specification, table).fit;
  INFO(linearized.convergence.verdict());
  REQUIRE(linearized.convergence.converged());
  const fit::FittedModel marginal =
      fit::fit_model(specification, table, {.method = fit::Method::kInteraction}).fit;
  REQUIRE(marginal.convergence.converged());
  // Both likelihoods are first-order ones; at a fixed point some 30 units lower, to which lb comes
  // otherwise, the curves of the plots differ.
  CHECK(linearized.log_likelihood == Approx(marginal.log_likelihood).margin(3.0));
}
