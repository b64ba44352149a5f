// SPDX-License-Identifier: MIT
// The data of the report page against its study.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "silvafit/fit/prediction.hpp"
#include "silvafit/study/report_page.hpp"
#include "study/study_record_test_support.hpp"

using namespace silvafit;
using namespace silvafit::study;
using nlohmann::json;

namespace {

json data_of(const StudyRecord& record) {
  return json::parse(report_data(record, test::catalogue()));
}

}  // namespace

TEST_CASE("the report shows each level with one chosen row, and the verdict of the study") {
  const test::RecordedStudy recorded({});
  const json data = data_of(recorded.record);
  CHECK(data["schema"] == "silvafit-report/1");
  CHECK(data["command"] == "silvafit study stand.csv --out out");
  CHECK(data["options"][0]["name"] == "Window");
  CHECK(data["inventory"]["trees"] == 240);
  CHECK(data["inventory"]["plots"] == 8);
  REQUIRE(data["results"].size() == 1);
  const json& result = data["results"][0];
  CHECK(result["verdict"] == recorded.record.study.results.front().verdict());
  for (const char* level : {"base", "random", "variance"}) {
    INFO(level);
    int chosen = 0;
    for (const json& row : result[level]) chosen += row["chosen"].get<bool>() ? 1 : 0;
    CHECK(chosen == 1);
  }
}

TEST_CASE("observations are columns of equal length, standardized residuals") {
  const test::RecordedStudy recorded({});
  const ResponseStudy& study = recorded.record.study.results.front();
  const json observations = data_of(recorded.record)["results"][0]["observations"];
  const std::size_t count = study.rows.size();
  for (const auto& [name, values] : observations.items()) {
    INFO(name);
    if (values.is_array()) CHECK(values.size() == count);
  }
  CHECK(observations["covariates"].empty());
  // (observed - ols) / sigma of least squares, sigma^2 = SSE / (n - p): n - p in all.
  double sum = 0.0;
  for (const json& value : observations["residual_ols"]) {
    sum += value.get<double>() * value.get<double>();
  }
  const auto freedom =
      static_cast<double>(count) - static_cast<double>(study.ols->fit.estimate.size());
  CHECK(sum == Approx(freedom).epsilon(1e-9));
  for (std::size_t i = 0; i < count; i += 17) {
    const double difference =
        observations["observed"][i].get<double>() - observations["conditional"][i].get<double>();
    const double scaled = observations["residual_nlme"][i].get<double>();
    const double sd = study.nlme->residual_sd[static_cast<Eigen::Index>(i)];
    CHECK(scaled == Approx(difference / sd).margin(1e-12));
  }
}

TEST_CASE("curves are the models at mean covariates, within each plot's own diameters") {
  const test::RecordedStudy recorded({});
  const ResponseStudy& study = recorded.record.study.results.front();
  const json curves = data_of(recorded.record)["results"][0]["curves"];
  data::Table grid;
  grid.set("dbh", curves["dbh"].get<std::vector<double>>());
  const Eigen::VectorXd ols = fit::predict(study.ols->fit, grid, fit::Level::kPopulation).value;
  const data::Table& trees = recorded.record.table;
  CHECK(curves["plots"].size() == 8);
  for (std::size_t i = 0; i < grid.rows(); ++i) {
    CHECK(curves["ols"][i].get<double>() == ols[static_cast<Eigen::Index>(i)]);
    const double dbh = curves["dbh"][i].get<double>();
    bool is_inside_low = false;
    bool is_inside_high = false;
    for (std::size_t row = 0; row < trees.rows(); ++row) {
      if (trees.labels("plot")[row] != "03") continue;
      is_inside_low |= trees.numbers("dbh")[row] <= dbh;
      is_inside_high |= trees.numbers("dbh")[row] >= dbh;
    }
    CHECK(curves["plots"]["03"][i].is_null() != (is_inside_low && is_inside_high));
  }
}

TEST_CASE("gain is the difference of R2 in percentage points, and null without a mixed model") {
  const test::RecordedStudy recorded({});
  const json result = data_of(recorded.record)["results"][0];
  const auto r2 = [&](const char* role, const char* kind) {
    return result["fits"][role]["statistics"][kind]["r2"].get<double>();
  };
  CHECK(result["gain"]["conditional"].get<double>() ==
        Approx(100.0 * (r2("nlme", "conditional") - r2("ols", "population"))).epsilon(1e-12));
  const test::RecordedStudy one({.plots = 1, .trees = 150});
  const json single = data_of(one.record)["results"][0];
  CHECK(single["gain"]["conditional"].is_null());
  CHECK(single["fits"]["nlme"].is_null());
  CHECK(single["random"].empty());
}

TEST_CASE("the report of a study does not depend on the time") {
  const test::RecordedStudy recorded({});
  const std::string first = report_data(recorded.record, test::catalogue());
  CHECK(report_data(recorded.record, test::catalogue()) == first);
  CHECK(first.find("\"seconds\"") == std::string::npos);
}

TEST_CASE("classes of a covariate are the chosen models at its values, the rest at their means") {
  test::RecordedStudy recorded({});
  StudyRecord& record = recorded.record;
  record.table = test::stand({});
  record.study = run_study(record.table, test::catalogue(), {.responses = {"h"}});
  const ResponseStudy& study = record.study.results.front();
  // C has a strong effect on the height of the stand, so level 2 selects it.
  REQUIRE(study.nlme->fit.specification.predictors() == std::vector<std::string>{"dbh", "C"});
  const json result = data_of(record)["results"][0];
  REQUIRE(result["curves"]["by_class"].size() == 1);
  const json& classes = result["curves"]["by_class"][0];
  CHECK(classes["covariate"] == "C");
  CHECK(classes["classes"] == json({0.0, 0.25, 0.5, 0.75, 1.0}));
  std::vector<std::size_t> trees(5, 0);
  for (const std::size_t row : study.rows) {
    ++trees[static_cast<std::size_t>(std::lround(4.0 * record.table.numbers("C")[row]))];
  }
  CHECK(classes["trees"] == json(trees));
  CHECK(result["observations"]["covariates"]["C"].size() == study.rows.size());
  data::Table grid;
  const auto dbh = result["curves"]["dbh"].get<std::vector<double>>();
  grid.set("dbh", dbh);
  for (std::size_t k = 0; k < 5; ++k) {
    grid.set("C", std::vector<double>(dbh.size(), 0.25 * static_cast<double>(k)));
    const auto expected = fit::predict(study.nlme->fit, grid, fit::Level::kPopulation).value;
    const auto least_squares =
        fit::predict(study.with_covariates->fit, grid, fit::Level::kPopulation).value;
    for (std::size_t i = 0; i < dbh.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      CHECK(classes["population"][k][i].get<double>() == expected[at]);
      CHECK(classes["covariates"][k][i].get<double>() == least_squares[at]);
    }
  }
  // Crowding lowers the rate of growth in this stand: the curves are in the order of the classes.
  CHECK(classes["population"][0][30].get<double>() > classes["population"][4][30].get<double>());
}

TEST_CASE("a covariate that is no share has classes at its own quantiles") {
  data::Table table = test::stand({});
  std::vector<double> ages;
  for (const double crowding : table.numbers("C")) ages.push_back(20.0 + 100.0 * crowding);
  table.set("age", ages);
  for (const char* name : {"W", "M", "C", "U"})
    table.set(name, std::vector<double>(ages.size(), 0.5));
  test::RecordedStudy recorded({});
  StudyRecord& record = recorded.record;
  record.table = table;
  record.study = run_study(table, test::catalogue(), {.responses = {"h"}, .covariates = {"age"}});
  const json classes = data_of(record)["results"][0]["curves"]["by_class"];
  REQUIRE(classes.size() == 1);
  CHECK(classes[0]["covariate"] == "age");
  // Ages are 20, 45, 70, 95 and 120, each for about a fifth of the trees.
  CHECK(classes[0]["classes"] == json({20.0, 45.0, 70.0, 95.0, 120.0}));
}

TEST_CASE("the report names the file's fingerprint and what computed it") {
  const test::RecordedStudy recorded({});
  const json repeat = data_of(recorded.record)["repeat"];
  CHECK(repeat["fingerprint"] == library_of(recorded.record).inventory.fingerprint);
  std::vector<std::string> names;
  for (const json& entry : repeat["versions"]) {
    names.push_back(entry["name"]);
    INFO(names.back());
    CHECK(entry["version"].get<std::string>().find_first_of("0123456789") != std::string::npos);
  }
  CHECK(names == std::vector<std::string>{"silvafit", "compiler", "Eigen", "Boost"});
}

TEST_CASE("names from the inventory are escaped") {
  const std::string species = R"(</script><script>alert("x")//',)";
  const test::RecordedStudy recorded({.species = species});
  const json data = data_of(recorded.record);
  CHECK(data["results"][0]["species"] == species);
  CHECK(data["inventory"]["species"][0]["code"] == species);
}

TEST_CASE("random effects have conditional standard errors, smaller than their spread") {
  test::RecordedStudy recorded({});
  const fit::FittedModel& fit = recorded.record.study.results.front().nlme->fit;
  REQUIRE(fit.random.back().uncertainty.is_known());
  const json random = data_of(recorded.record)["results"][0]["fits"]["nlme"]["random"].at(0);
  CHECK(random["eblup_se"].size() == fit.random.back().labels.size());
  CHECK_FALSE(random.contains("eblup_covariance"));
  const Eigen::Index q = fit.random.back().effects.rows();
  for (std::size_t group = 0; group < fit.random.back().labels.size(); ++group) {
    const auto g = static_cast<Eigen::Index>(group);
    for (Eigen::Index k = 0; k < q; ++k) {
      const std::string& effect = fit.random.back().names[static_cast<std::size_t>(k)];
      const double se = random["eblup_se"][fit.random.back().labels[group]][effect].get<double>();
      // Given the plot's trees, V; text and back leave the double as it is.
      CHECK(se == std::sqrt(fit.random.back().uncertainty.covariance(g, q)(k, k)));
      // Thirty trees of a plot give more information about it than the distribution of plots does.
      CHECK(se < fit.random.back().sd()[k]);
    }
  }
}
