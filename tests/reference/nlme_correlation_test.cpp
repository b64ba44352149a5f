// SPDX-License-Identifier: MIT
// Correlated residuals against the corStruct classes of R nlme 3.1-162, most of them on the
// examples of Pinheiro and Bates (2000); bench/r/reference_correlation.R made the figures.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "expected.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"
#include "silvafit/fit/residuals.hpp"

using namespace silvafit;
using nlohmann::json;

namespace {

data::Table table_of(const json& reference) {
  return data::read_csv_table(test::reference_data(reference["data"].get<std::string>() + ".csv"));
}

fit::FitResult fit_of(const json& reference, const data::Table& table) {
  const fit::ModelTexts texts{.formula = reference["formula"],
                              .sub_models = reference["parameters"].get<std::vector<std::string>>(),
                              .random = reference["random"],
                              .covariance = reference["covariance"] == ""
                                                ? std::vector<std::string>{}
                                                : std::vector<std::string>{reference["covariance"]},
                              .variance = reference["variance"],
                              .correlation = reference["correlation"]};
  return fit::fit_model(
      fit::specify_model(texts, table), table, {.reml = reference["reml"].get<bool>()});
}

std::vector<double> ascending(const Eigen::VectorXd& values) {
  std::vector<double> result(values.begin(), values.end());
  std::ranges::sort(result);
  return result;
}

std::vector<double> ascending(const json& values) {
  auto result = values.get<std::vector<double>>();
  std::ranges::sort(result);
  return result;
}

/// The parameters are not determined: a correlation of effects at -1, a nugget of 0.
const std::set<std::string> kOnlyLikelihood{"bodyweight_nugget", "spruce_nugget"};

}  // namespace

TEST_CASE("Correlated residuals have nlme's likelihood and parameters") {
  const json file = test::read_expected("nlme_correlation.json");
  for (const json& reference : file["fits"]) {
    const std::string id = reference["id"];
    INFO(id << " " << reference["call"]);
    const data::Table table = table_of(reference);
    const fit::FitResult result = fit_of(reference, table);
    const fit::FittedModel& fit = result.fit;
    INFO(fit.convergence.verdict());
    CHECK(fit.convergence.converged());
    const double expected = reference["log_likelihood"];
    CHECK(fit.log_likelihood > expected - 1e-4);
    if (kOnlyLikelihood.contains(id)) continue;
    // nlme's optimizer differentiates numerically and stops within 1e-4 of the maximum.
    CHECK(fit.log_likelihood < expected + 1e-4);
    REQUIRE(fit.variance.correlation);
    const auto values = reference["values"].get<std::vector<double>>();
    for (std::size_t k = 0; k < values.size(); ++k) {
      INFO(fit.variance.correlation->names[k]);
      CHECK(fit.variance.correlation->values[static_cast<Eigen::Index>(k)] ==
            Approx(values[k]).epsilon(1e-4));
    }
    // That of gnls has N - p in the denominator, ours of maximum likelihood N.
    const bool is_gnls = fit.random.empty() && !fit.reml;
    const auto n = static_cast<double>(fit.observations);
    const auto p = static_cast<double>(fit.estimate.size());
    CHECK(fit.sigma * std::sqrt(is_gnls ? n / (n - p) : 1.0) ==
          Approx(reference["sigma"].get<double>()).epsilon(1e-3));
    CHECK(fit.aic() == Approx(reference["aic"].get<double>()).margin(2e-4));
    const std::vector<double> estimates = ascending(fit.estimate);
    const std::vector<double> errors = ascending(fit.standard_errors());
    const std::vector<double> their_errors = ascending(reference["std_errors"]);
    const std::vector<double> theirs = ascending(reference["estimate"]);
    for (std::size_t j = 0; j < theirs.size(); ++j) {
      CHECK(std::abs(estimates[j] - theirs[j]) < 2e-3 * their_errors.back());
      CHECK(errors[j] == Approx(their_errors[j]).epsilon(1e-3));
    }
    // A file keeps all of it.
    const fit::FittedModel read = fit::from_json(fit::to_json(fit), "fit.json");
    CHECK(read.specification.correlation == fit.specification.correlation);
    REQUIRE(read.variance.correlation);
    CHECK(read.variance.correlation->values == fit.variance.correlation->values);
  }
}

TEST_CASE("Normalized residuals are those of nlme") {
  const json file = test::read_expected("nlme_correlation.json");
  for (const json& reference : file["fits"]) {
    const std::string id = reference["id"];
    if (id != "ovary_ar1" && id != "dialyzer_gls_ar1" && id != "stems_car1") continue;
    INFO(id);
    const data::Table table = table_of(reference);
    const fit::Residuals residuals = fit::residuals(fit_of(reference, table).fit, table);
    const auto theirs = reference["normalized"].get<std::vector<double>>();
    for (std::size_t i = 0; i < theirs.size(); ++i) {
      CHECK(residuals.normalized[static_cast<Eigen::Index>(i)] ==
            Approx(theirs[i]).epsilon(1e-3).margin(1e-3));
    }
  }
}
