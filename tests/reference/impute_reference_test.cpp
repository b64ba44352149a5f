// SPDX-License-Identifier: MIT
// Imputed heights of the spati data against R 4.2.2 with nlme 3.1-162, by the model that lmfor's
// ImputeHeights documents; bench/r/impute_spati.R made the figures.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/study/impute.hpp"

using namespace silvafit;
using nlohmann::json;

TEST_CASE("heights of spati are imputed as nlme does it", "[reference]") {
  std::ifstream stream(test::source_file("tests/reference/expected/impute_spati.json"));
  const json reference = json::parse(stream)["fits"];
  data::Table table =
      data::read_csv_table(test::reference_data("spati.csv"), {.text_columns = {"plot"}});
  const auto rows = reference["row"].get<std::vector<std::size_t>>();
  const auto d = table.numbers("d");
  table.set("dbh", std::vector<double>(d.begin(), d.end()));
  const auto measured = table.numbers("h");
  std::vector<double> heights(measured.begin(), measured.end());
  for (const std::size_t row : rows) heights[row - 1] = std::numeric_limits<double>::quiet_NaN();
  table.set("h", heights);

  const auto catalogue = study::Catalogue::load(silvafit::test::data_file("models"));
  const study::Imputation result = study::impute(table, catalogue);
  REQUIRE(result.models.size() == 1);
  const fit::FittedModel& fit = result.models[0].fit;
  CHECK(fit.observations == reference["n"].get<Eigen::Index>());
  CHECK(fit.log_likelihood == Approx(reference["log_likelihood"].get<double>()).epsilon(1e-7));
  double largest = 0.0;
  double largest_of_nlme = 0.0;
  std::size_t population = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t row = rows[i] - 1;
    CHECK(result.source[row] == study::ImputeSource::kImputed);
    CHECK(word_of(result.level[row]) == reference["level"][i].get<std::string>());
    population += static_cast<std::size_t>(result.level[row] == study::ImputeLevel::kPopulation);
    const auto difference = [&](const char* name) {
      return std::abs(result.value[row] - reference[name][i].get<double>());
    };
    largest = std::max(largest, difference("h"));
    largest_of_nlme = std::max(largest_of_nlme, difference("h_nlme"));
  }
  CHECK(population > 100);
  // nlme's method carried to its fixed point in double precision; its own result at the tightest
  // control that it meets is 3e-6 m from that.
  CHECK(largest < 1e-6);
  CHECK(largest_of_nlme < 1e-5);
}
