// SPDX-License-Identifier: MIT
// The tables for papers contain the numbers of the fits.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "study/study_record_test_support.hpp"
#include "study/study_tables.hpp"

using namespace silvafit;
using namespace silvafit::study;

namespace {

std::size_t column_of(const FormattedTable& table, const std::string& name) {
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    if (table.columns[i].name == name) return i;
  }
  FAIL("no column " << name);
  return 0;
}

}  // namespace

TEST_CASE("the table of coefficients has a row for each model, with stars and letters") {
  const test::RecordedStudy recorded({});
  const ResponseStudy& result = recorded.record.study.results.front();
  const FormattedTable table = coefficients_table(recorded.record.study);
  REQUIRE(table.rows.size() == 2);  // without indices the models of levels 1 and 2 are the same
  const fit::FittedModel& ols = result.ols->fit;
  for (std::size_t k = 0; k < ols.coefficient_names.size(); ++k) {
    const auto& cell =
        std::get<MarkedNumber>(table.rows.front()[column_of(table, ols.coefficient_names[k])]);
    CHECK(cell.value == ols.estimate[static_cast<Eigen::Index>(k)]);
    // 240 trees on a steep curve: both parameters are far from zero.
    CHECK(cell.after == "***");
  }
  CHECK(std::get<double>(table.rows[1][column_of(table, "aic")]) == result.nlme->fit.aic());
  // The stand has a standard deviation of 2 m between plots, three times that of trees.
  const auto& letters = std::get<std::string>(table.rows[1][column_of(table, "letters")]);
  CHECK(letters.ends_with(" ***"));
}

TEST_CASE("effects of a covariate are in its column with the name of their parameter") {
  const Study study = run_study(test::stand({}), test::catalogue(), {.responses = {"h"}});
  const fit::FittedModel& fit = study.results.front().with_covariates->fit;
  const FormattedTable table = coefficients_table(study);
  // The rate of growth decreases with C in this stand.
  REQUIRE(column_of(table, "C") > 0);
  for (std::size_t k = 0; k < fit.coefficient_names.size(); ++k) {
    const std::string& name = fit.coefficient_names[k];
    const std::size_t colon = name.find(':');
    if (colon == std::string::npos) continue;
    const auto& cell =
        std::get<MarkedNumber>(table.rows[1][column_of(table, name.substr(colon + 1))]);
    CHECK(cell.before == name.substr(0, colon) + ": ");
    CHECK(cell.value == fit.estimate[static_cast<Eigen::Index>(k)]);
  }
}

TEST_CASE("the table has variances, accuracy, and accuracy for plots left out") {
  const test::RecordedStudy recorded({});
  const ResponseStudy& result = recorded.record.study.results.front();
  const FormattedTable table = variance_and_fit_table(recorded.record.study);
  REQUIRE(table.rows.size() == 2);  // without indices the models of levels 1 and 2 are the same
  const fit::FittedModel& nlme = result.nlme->fit;
  const auto number = [&](std::size_t row, const std::string& name) {
    return std::get<double>(table.rows[row][column_of(table, name)]);
  };
  CHECK(number(1, "psi2_1") == nlme.random.back().covariance(0, 0));
  CHECK(number(1, "sigma2") == nlme.sigma * nlme.sigma);
  CHECK(number(1, "r2") == nlme.conditional.r2);
  CHECK(number(0, "r2") == result.ols->fit.population.r2);
  CHECK(number(0, "r2_left_out") == result.left_out->r2_ols);
  CHECK(std::isnan(number(0, "psi2_1")));
}

TEST_CASE("each plot has a row for each of its random effects") {
  const test::RecordedStudy recorded({});
  const fit::FittedModel& nlme = recorded.record.study.results.front().nlme->fit;
  const FormattedTable table = plot_effects_table(recorded.record.study);
  REQUIRE(table.rows.size() == nlme.random.back().labels.size() * nlme.random.back().names.size());
  CHECK(std::get<std::string>(table.rows[0][column_of(table, "plot")]) ==
        nlme.random.back().labels[0]);
  CHECK(std::get<double>(table.rows[0][column_of(table, "eblup")]) ==
        nlme.random.back().effects(0, 0));
  CHECK(std::get<double>(table.rows[0][column_of(table, "se")]) > 0.0);
}
