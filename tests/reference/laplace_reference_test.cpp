// SPDX-License-Identifier: MIT
// Laplace's method against TMB 1.9.2.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "fir_mixed.hpp"
#include "public_data.hpp"
#include "silvafit/fit/fitted_model.hpp"

using namespace silvafit;
using nlohmann::json;

namespace {

const std::map<std::string, std::string> kTmbVariances{
    {"none", "none"}, {"varPower", "power"}, {"varConstPower", "constant-plus-power"}};

/// The fit of the nlme reference that has the same formula and groups.
json find_by_id(const json& file, std::string id) {
  const bool is_public = id.starts_with("spati");
  if (!is_public) id.insert(id.rfind('_'), "_nlme");
  for (const json& fit : file["fits"]) {
    if (fit["id"] == id) return fit;
  }
  FAIL("no formula for " << id);
  return {};
}

fit::FitResult fitted_by_laplace(const json& reference,
                                 const json& formula_of,
                                 const data::Table& table,
                                 const std::map<std::string, double>& start = {}) {
  fit::ModelSpecification specification =
      fit::specify_model(formula_of["formula"].get<std::string>(), {}, table);
  std::string random;
  for (const json& name : reference["random_names"]) {
    random += (random.empty() ? "" : " + ") + name.get<std::string>();
  }
  fit::add_random_effects(
      specification, random + " | " + formula_of["group"].get<std::string>(), table);
  specification.variance =
      fit::parse_variance_function(kTmbVariances.at(reference["varfun"].get<std::string>()));
  return fit::fit_model(specification, table, {.method = fit::Method::kLaplace, .start = start});
}

/// TMB's optimizer ends at a boundary covariance with a gradient of this size; its
/// estimates are then no maximum to compare with.
bool is_comparable_with_tmb(const json& reference) {
  return reference["converged"].get<bool>() && reference["max_abs_gradient"].get<double>() < 1e-6;
}

void check_against_tmb(const json& reference, const json& formula_of, const data::Table& table) {
  const fit::FittedModel fit = fitted_by_laplace(reference, formula_of, table).fit;
  INFO(reference["id"].get<std::string>() << ": " << fit.convergence.verdict());
  CHECK(fit.convergence.converged());
  CHECK(fit.observations == reference["n"].get<int>());
  CHECK(fit.parameter_count == reference["df"].get<int>());
  const double expected = reference["logLik"].get<double>();
  CHECK(fit.log_likelihood > expected - 1e-6 * std::abs(expected));
  if (!is_comparable_with_tmb(reference)) return;
  // The gradients of both are at the level of rounding.
  CHECK(fit.log_likelihood == Approx(expected).epsilon(1e-9));
  const Eigen::VectorXd errors = fit.standard_errors();
  for (std::size_t j = 0; j < fit.coefficient_names.size(); ++j) {
    const std::string& name = fit.coefficient_names[j];
    INFO(name);
    const double error = reference["std_errors"][name].get<double>();
    const auto k = static_cast<Eigen::Index>(j);
    CHECK(fit.estimate[k] ==
          Approx(reference["estimates"][name].get<double>()).margin(1e-4 * error));
    // TMB differentiates its gradient numerically as well, with a step of 1e-3.
    CHECK(errors[k] == Approx(error).epsilon(1e-3));
  }
  CHECK(fit.sigma == Approx(reference["sigma"].get<double>()).epsilon(1e-4));
}

/// Starts from coefficients that are up to a quarter away find no higher likelihood.
void check_restarts(const json& reference, const json& formula_of, const data::Table& table) {
  const fit::FittedModel best = fitted_by_laplace(reference, formula_of, table).fit;
  INFO(reference["id"].get<std::string>());
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> factor(0.75, 1.25);
  for (int restart = 0; restart < 2; ++restart) {
    std::map<std::string, double> start;
    for (std::size_t j = 0; j < best.coefficient_names.size(); ++j) {
      start[best.coefficient_names[j]] =
          best.estimate[static_cast<Eigen::Index>(j)] * factor(random);
    }
    const fit::FittedModel other = fitted_by_laplace(reference, formula_of, table, start).fit;
    // 1e-6 is what two searches of one maximum may differ by.
    if (other.convergence.converged()) CHECK(other.log_likelihood < best.log_likelihood + 1e-6);
  }
}

}  // namespace

TEST_CASE("the mixed models of the study agree with TMB", "[reference][slow]") {
  const json file = test::read_expected("laplace_tmb.json");
  const json formulas = test::read_expected("fir_mixed_nlme.json");
  const std::string species = GENERATE("SM", "BHN", "MH");
  const data::Table table = test::fir_mixed(species);
  for (const json& reference : file["fits"]) {
    if (reference["id"].get<std::string>().starts_with(species)) {
      check_against_tmb(reference, find_by_id(formulas, reference["id"]), table);
    }
  }
}

TEST_CASE("restarts from perturbed points find nothing better", "[reference][slow]") {
  const json file = test::read_expected("laplace_tmb.json");
  const json study = test::read_expected("fir_mixed_nlme.json");
  const json open_data = test::read_expected("public_nlme.json");
  const std::string data_set = GENERATE("SM", "BHN", "MH", "spati");
  const bool is_public = data_set == "spati";
  const data::Table table = is_public ? test::public_table(data_set) : test::fir_mixed(data_set);
  for (const json& reference : file["fits"]) {
    if (!reference["id"].get<std::string>().starts_with(data_set)) continue;
    check_restarts(reference, find_by_id(is_public ? open_data : study, reference["id"]), table);
  }
}

TEST_CASE("mixed models of public data agree with TMB", "[reference][slow]") {
  const json file = test::read_expected("laplace_tmb.json");
  const json formulas = test::read_expected("public_nlme.json");
  const data::Table table = test::public_table("spati");
  for (const json& reference : file["fits"]) {
    if (reference["id"].get<std::string>().starts_with("spati")) {
      check_against_tmb(reference, find_by_id(formulas, reference["id"]), table);
    }
  }
}
