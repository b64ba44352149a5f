// SPDX-License-Identifier: MIT
#include "silvafit/study/analyses.hpp"

#include <catch2/catch.hpp>
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
