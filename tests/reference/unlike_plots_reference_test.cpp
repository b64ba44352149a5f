// SPDX-License-Identifier: MIT
// Plots so unlike that one curve through all of them runs away, without start values, against R
// 4.2.2 with nlme 3.1-162 from good ones; bench/r/reference_unlike_plots.R made the figures.
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "expected.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/fitted_model.hpp"

using namespace silvafit;
using nlohmann::json;

namespace {

json fits_of_nlme() { return test::read_expected("nlme_unlike_plots.json")["fits"]; }

data::Table plots_of(const json& reference) {
  const data::Table table = data::read_csv_table(
      test::source_file("tests/reference/data/unlike_plots.csv"), {.text_columns = {"plot"}});
  return data::rows_where("set == \"" + reference["set"].get<std::string>() + "\"", table);
}

fit::FittedModel fitted_to_set(const json& reference, const fit::FitModelOptions& options) {
  const data::Table table = plots_of(reference);
  fit::ModelSpecification model =
      fit::specify_model(reference["formula"].get<std::string>(), {}, table);
  fit::add_random_effects(model, reference["random"].get<std::string>(), table);
  return fit::fit_model(model, table, options).fit;
}

// nlme stops its penalized step at 1e-6 of the squares, which moves coefficients by 1e-7 or so.
constexpr double kNlme = 1e-6;

void check_like_nlme(const fit::FittedModel& fit, const json& reference) {
  INFO(reference["set"] << ": " << fit.convergence.verdict());
  REQUIRE(fit.convergence.converged());
  // The likelihood is flat at its top.
  CHECK(fit.log_likelihood ==
        Approx(reference["log_likelihood"].get<double>()).margin(1e-5).epsilon(0.0));
  for (std::size_t j = 0; j < fit.coefficient_names.size(); ++j) {
    const double value = reference["fixed"][fit.coefficient_names[j]];
    CHECK(fit.estimate[static_cast<Eigen::Index>(j)] == Approx(value).epsilon(kNlme));
  }
  CHECK(fit.sigma == Approx(reference["sigma"].get<double>()).epsilon(kNlme));
}

}  // namespace

TEST_CASE("plots that are very unlike need no start values") {
  for (const json& reference : fits_of_nlme())
    check_like_nlme(fitted_to_set(reference, {}), reference);
}

TEST_CASE("start values for plots that are very unlike do no harm") {
  for (const json& reference : fits_of_nlme()) {
    fit::FitModelOptions options;
    for (const auto& [name, value] : reference["fixed"].items()) {
      options.start[name] = 1.1 * value.get<double>();
    }
    check_like_nlme(fitted_to_set(reference, options), reference);
  }
}

TEST_CASE("the marginal likelihoods of plots that are very unlike are near nlme's") {
  for (const json& reference : fits_of_nlme()) {
    // With one effect that enters linearly the methods agree except for the curvature of b and c.
    if (reference["random"] != "a | plot") continue;
    for (const fit::Method method : {fit::Method::kLaplace, fit::Method::kInteraction}) {
      const fit::FittedModel fit = fitted_to_set(reference, {.method = method});
      INFO(reference["set"] << ": " << fit.convergence.verdict());
      CHECK(fit.convergence.converged());
      CHECK(fit.log_likelihood ==
            Approx(reference["log_likelihood"].get<double>()).margin(0.2).epsilon(0.0));
    }
  }
}
