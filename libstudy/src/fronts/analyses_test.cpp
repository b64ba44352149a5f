// SPDX-License-Identifier: MIT
#include "silvafit/study/analyses.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "reference.hpp"
#include "silvafit/base/error.hpp"

using namespace silvafit;
using namespace silvafit::study;

namespace {

/// Two plots of two trees, 400 m2 each.
data::TableSource trees() {
  data::Table table;
  table.set("plot", {1, 1, 2, 2});
  table.set("dbh", {10, 20, 30, 40});
  data::TextColumn species;
  for (const char* const name : {"A", "B", "A", "A"}) species.append(name);
  table.set("species", species);
  return std::make_shared<const data::Table>(std::move(table));
}

AnalysisResult result_of(const char* analysis, const std::string& arguments) {
  return prepare_analysis(
      analysis,
      {.arguments = arguments, .table = trees(), .data_folder = test::source_file(".")})({});
}

void refuses(const std::string& arguments, const std::string& argument, const std::string& part) {
  INFO(arguments);
  try {
    prepare_analysis("stand_summary", {.arguments = arguments, .table = trees()});
    FAIL("was accepted");
  } catch (const UsageError& error) {
    CHECK(error.place().column == argument);
    CHECK_THAT(error.message(), Catch::Contains(part));
  }
}

}  // namespace

TEST_CASE("an analysis has its tables and its JSON") {
  const AnalysisResult result = result_of("stand_summary", R"({"plot_area": 400, "threads": 1})");
  REQUIRE(result.tables.front().first == "plots");
  // Each plot has two trees on 0.04 ha.
  CHECK(result.tables.front().second.numbers("stems_per_ha")[0] == Approx(50.0));
  CHECK(nlohmann::json::parse(result.json).at("schema") == "silvafit-stand/1");
}

TEST_CASE("arguments of a call may be lists or single values, numbers as labels, and null") {
  const auto quiet = [](const std::string& arguments) {
    CHECK_NOTHROW(prepare_analysis("stand_summary", {.arguments = arguments, .table = trees()}));
  };
  quiet(R"({"missing": -88, "fill_down": "plot", "stratum": "", "window": null})");
  quiet(R"({"columns": {"dbh": "dbh"}, "circles": {"7": 4}, "alpha": ["72", "SM=60"]})");
  quiet(R"({"layers": 10, "stratum_areas": {"A": 120}, "neighbors": 3.0, "edge": ""})");
}

TEST_CASE("an argument that cannot be used is named") {
  refuses(R"({"neighbours": 3})", "neighbours", "did you mean neighbors");
  refuses(R"({"neighbors": 2.5})", "`neighbors`", "2.5 is no whole number");
  refuses(R"({"neighbors": true})", "`neighbors`", "must be a number");
  refuses(R"({"buffer": -1})", "`buffer`", "-1 is below 0");
  refuses(R"({"edge": "rim"})", "`edge`", "must be one of buffer, hanisch, torus, none");
  refuses(R"({"columns": {"dbh": [1]}})", "`columns`", "must be a text");
  refuses(R"({"threads": -1})", "`threads`", "must be between 0");
}

TEST_CASE("codes of missing values are missing in data of fits and predictions, and said") {
  data::Table table;
  table.set("x", {1.0, 2.0, 3.0, 4.0, -9999.0, 6.0});
  table.set("y", {1.1, 1.9, 3.2, -9999.0, 5.0, 5.8});
  const data::TableSource rows = std::make_shared<const data::Table>(std::move(table));
  const AnalysisResult fitted = prepare_analysis(
      "fit",
      {.arguments = R"({"formula": "y ~ a + b*x", "columns": ["x", "y"]})", .table = rows})({});
  const fit::FittedModel& fit = fitted.fits.front().second;
  CHECK(fitted.rows == std::vector<std::size_t>{0, 1, 2, 5});
  CHECK(fit.excluded == 2);
  // lm() of the four rows.
  CHECK(fit.estimate[1] == Approx(0.95).epsilon(1e-12));
  CHECK_THAT(
      fit.convergence.verdict(),
      Catch::Matchers::StartsWith("Codes read as missing values: x 1 (-9999), y 1 (-9999)."));
  CHECK(fit.convergence.has_doubts());
  const AnalysisResult predicted = prepare_analysis(
      "predict", {.arguments = R"({"level": "population"})", .table = rows, .fits = {&fit}})({});
  CHECK(std::isnan(predicted.tables.front().second.numbers("value")[4]));
  CHECK(predicted.warnings ==
        std::vector<std::string>{"codes read as missing values: x 1 (-9999), y 1 (-9999)"});
  data::Table impossible;
  impossible.set("x", {1.0, -1.0, HUGE_VAL});
  const AnalysisResult warned =
      prepare_analysis("predict",
                       {.arguments = R"({"level": "population"})",
                        .table = std::make_shared<const data::Table>(std::move(impossible)),
                        .fits = {&fit}})({});
  CHECK(warned.warnings == std::vector<std::string>{
                               "2 rows have an infinite or negative value of x, which is 1 to 6 in "
                               "the data of the fit"});
}

TEST_CASE("labels of a fit that differ in capitals only are named") {
  data::Table table;
  table.set("y", {1.1, 1.9, 3.2, 4.5, 5.0, 5.8});
  data::TextColumn site;
  for (const char* const label : {"a", "A", "a", "b", "b", "A"}) site.append(label);
  table.set("site", std::move(site));
  const AnalysisResult fitted =
      prepare_analysis("fit",
                       {.arguments = R"({"formula": "y ~ a", "random": "a | site"})",
                        .table = std::make_shared<const data::Table>(std::move(table))})({});
  REQUIRE(fitted.warnings.size() == 1);
  CHECK_THAT(fitted.warnings.front(), Catch::Matchers::Contains("different: 'a' and 'A'"));
}
