// SPDX-License-Identifier: MIT
// Predictions at all levels, and random effects of new plots, against R 4.2.2 with nlme 3.1-162 on
// shipped data; tests/reference/expected/README.md says how the figures were made.
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "expected.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/prediction.hpp"

using namespace silvafit;
using Eigen::Index;
using nlohmann::json;

namespace {

std::vector<std::size_t> rows_of(const json& numbers) {
  std::vector<std::size_t> rows;
  for (const json& number : numbers) rows.push_back(number.get<std::size_t>() - 1);
  return rows;
}

fit::ModelSpecification model_to_predict(const std::string& random, const data::Table& table) {
  fit::ModelSpecification model = fit::specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh/10))", {}, table);
  fit::add_random_effects(model, random, table);
  model.variance = fit::parse_variance_function("power");
  return model;
}

void check_values(const Eigen::VectorXd& values, const json& reference) {
  REQUIRE(values.size() == static_cast<Index>(reference.size()));
  for (Index i = 0; i < values.size(); ++i) {
    // nlme's own tolerance, at which its random effects stand, is 1e-6.
    CHECK(values[i] == Approx(reference[static_cast<std::size_t>(i)].get<double>()).epsilon(1e-6));
  }
}

}  // namespace

TEST_CASE("predictions at all levels are nlme's") {
  const json file = test::read_expected("nlme_predict.json");
  for (const json& reference : file["predictions"]) {
    INFO(reference["id"]);
    const data::Table table = test::stands();
    const fit::FittedModel fit =
        fit::fit_model(model_to_predict(reference["random"].get<std::string>(), table), table).fit;
    REQUIRE(fit.convergence.converged());
    data::Table part = table.select(rows_of(reference["rows"]));
    const json& levels = reference["levels"];
    check_values(fit::predict(fit, part, fit::Level::kPopulation).value, levels[0]);
    check_values(fit::predict(fit, part, fit::Level::kConditional).value, levels.back());
    if (levels.size() < 3) continue;
    // nlme's level 1 of nested groups is ours for a new plot of a known stand.
    data::TextColumn unknown;
    for (std::size_t row = 0; row < part.rows(); ++row) unknown.append("not seen");
    part.set("plot", unknown);
    check_values(fit::predict(fit, part, fit::Level::kConditional).value, levels[1]);
  }
}

TEST_CASE("random effects of new plots are those of the definition in R") {
  const json reference = test::read_expected("nlme_predict.json")["new_plots"];
  data::Table table = test::stands();
  fit::FittedModel fit(model_to_predict("a + b | plot", table));
  fit.method = fit::Method::kLindstromBates;
  fit.coefficient_names = {"a", "b"};
  fit.estimate =
      Eigen::Vector2d(reference["fixed"]["a"].get<double>(), reference["fixed"]["b"].get<double>());
  fit.covariance.setZero(2, 2);
  fit.random = {{.names = {"a", "b"}}};
  const json& psi = reference["covariance"];
  fit.random.back().covariance.resize(2, 2);
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t j = 0; j < 2; ++j) {
      fit.random.back().covariance(static_cast<Index>(i), static_cast<Index>(j)) =
          psi[i][j].get<double>();
    }
  }
  fit.random.back().effects.resize(2, 0);
  fit.sigma = reference["sigma"].get<double>();
  fit.variance = fit::VarianceEstimate::missing(fit::parse_variance_function("power"));
  fit.variance.factors[0].delta[0] = reference["power"].get<double>();
  for (const auto& [label, plot] : reference["plots"].items()) {
    INFO(label);
    const fit::Calibration calibration = fit::calibrate(fit, table.select(rows_of(plot["rows"])));
    REQUIRE(calibration.random.back().labels == std::vector<std::string>{label});
    CHECK(calibration.random.back().measured == std::vector<Index>{4});
    for (std::size_t k = 0; k < 2; ++k) {
      // R's search has a Jacobian by differences: its fixed point is good to about 1e-9.
      CHECK(calibration.random.back().effects(static_cast<Index>(k), 0) ==
            Approx(plot["effects"][k].get<double>()).epsilon(1e-7));
    }
  }
}
