// SPDX-License-Identifier: MIT
// The data of the report page against the study that they show.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "silvafit/fit/prediction.hpp"
#include "study_record_support.hpp"

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

TEST_CASE("observations are columns of equal length, residuals over their own spread") {
  const test::RecordedStudy recorded({});
  const ResponseStudy& study = recorded.record.study.results.front();
  const json observations = data_of(recorded.record)["results"][0]["observations"];
  const std::size_t count = study.rows.size();
  for (const auto& [name, values] : observations.items()) {
    INFO(name);
    CHECK(values.size() == count);
  }
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

TEST_CASE("gain is the difference of R2 in percent points, and null without a mixed model") {
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

TEST_CASE("the report of a study is the same text each time, whatever the clock says") {
  const test::RecordedStudy recorded({});
  const std::string first = report_data(recorded.record, test::catalogue());
  CHECK(report_data(recorded.record, test::catalogue()) == first);
  CHECK(first.find("\"seconds\"") == std::string::npos);
}
