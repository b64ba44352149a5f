// SPDX-License-Identifier: MIT
// The data of the comparison page against the compared libraries.
#include "silvafit/study/comparison_page.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/prediction.hpp"
#include "study/study_record_test_support.hpp"

using namespace silvafit;
using namespace silvafit::study;
using nlohmann::json;

namespace {

const ModelLibrary& library() {
  static const test::RecordedStudy recorded({});
  static const ModelLibrary made = library_of(recorded.record);
  return made;
}

json compared(const ModelLibrary& first, const ModelLibrary& second) {
  return json::parse(comparison_data({first, second}, {"a.json", "b.json"}));
}

const json& pair_of(const json& data, const std::string& role) {
  for (const json& pair : data["pairs"]) {
    if (pair["role"] == role) return pair;
  }
  throw UsageError("no pair of the role " + role);
}

/// The library with its mixed model replaced by that of least squares.
ModelLibrary simplified() {
  ModelLibrary changed = library();
  for (LibraryModel& model : changed.models) {
    if (model.role == "nlme") model.fit = library().models.front().fit;
  }
  return changed;
}

}  // namespace

TEST_CASE("a library does not differ from itself") {
  const json data = compared(library(), library());
  CHECK(data["schema"] == "silvafit-comparison/1");
  REQUIRE(data["pairs"].size() == library().models.size());
  for (const json& pair : data["pairs"]) {
    const json& difference = pair["differences"][0];
    for (const char* name : {"log_likelihood", "aic", "bic", "rmse", "r2"}) {
      INFO(pair["role"] << ' ' << name);
      CHECK(difference[name] == 0.0);
    }
    CHECK(difference["reason"].is_null());
    CHECK(pair["curves"]["values"][0] == pair["curves"]["values"][1]);
  }
}

TEST_CASE("differences are values of the second fit minus those of the first") {
  const json data = compared(library(), simplified());
  const json& difference = pair_of(data, "nlme")["differences"][0];
  const fit::FittedModel& mixed = library().models.back().fit;
  const fit::FittedModel& ordinary = library().models.front().fit;
  REQUIRE(mixed.has_random_effects());
  CHECK(difference["aic"].get<double>() == ordinary.aic() - mixed.aic());
  CHECK(difference["bic"].get<double>() == ordinary.bic() - mixed.bic());
  CHECK(difference["rmse"].get<double>() == ordinary.population.rmse - mixed.conditional.rmse);
}

TEST_CASE("likelihoods are not compared if data, trees or methods differ") {
  const auto reason_of = [](const ModelLibrary& other) {
    const json difference = pair_of(compared(library(), other), "nlme")["differences"][0];
    CHECK(difference["aic"].is_null());
    CHECK(difference["rmse"].is_number());
    return difference["reason"].get<std::string>();
  };
  ModelLibrary other = library();
  other.inventory.fingerprint = "";
  CHECK(pair_of(compared(library(), other), "nlme")["differences"][0]["reason"].is_null());
  other.models.back().fit.response_fingerprint = "other";
  CHECK(reason_of(other) == "fitted to different values");
  other.models.back().fit.response_fingerprint = "";
  CHECK(reason_of(other) == "a fit does not store which data it used");
  other.inventory.fingerprint = "fnv1a64:0000000000000000";
  CHECK(reason_of(other) == "fitted to different files");
  other = library();
  other.models.back().fit.observations -= 1;
  CHECK(reason_of(other) == "fitted to 240 and 239 trees");
  other = library();
  other.models.back().fit.reml = true;
  CHECK(reason_of(other) == "one by ML, the other by REML");
  other = library();
  other.models.back().fit.convergence.status = fit::ConvergenceStatus::kMaximumNotReached;
  CHECK(reason_of(other) == "a fit has not converged");
}

TEST_CASE("a model that only one library has is shown alone") {
  ModelLibrary fewer = library();
  fewer.models.pop_back();
  const json data = compared(fewer, library());
  const json& pair = pair_of(data, "nlme");
  CHECK(pair["fits"][0].is_null());
  CHECK(pair["differences"][0].is_null());
  CHECK(pair["curves"]["values"][0].is_null());
  CHECK(pair["curves"]["values"][1].size() == pair["curves"]["dbh"].size());
}

TEST_CASE("curves are population predictions within each fit's own range of DBH") {
  ModelLibrary shorter = library();
  const double limit = 30.0;
  for (LibraryModel& model : shorter.models) {
    for (fit::ColumnRange& range : model.fit.ranges) {
      if (range.column == "dbh") range.high = limit;
    }
  }
  const json data = compared(library(), shorter);
  const json& curves = pair_of(data, "nlme")["curves"];
  data::Table grid;
  grid.set("dbh", curves["dbh"].get<std::vector<double>>());
  const auto expected =
      fit::predict(library().models.back().fit, grid, fit::Level::kPopulation).value;
  for (std::size_t i = 0; i < grid.rows(); ++i) {
    const double value = expected[static_cast<Eigen::Index>(i)];
    CHECK(curves["values"][0][i].get<double>() == value);
    const bool is_inside = grid.numbers("dbh")[i] <= limit;
    CHECK(curves["values"][1][i].is_null() != is_inside);
  }
}

TEST_CASE("crown bases are compared at the heights of each library's own height model") {
  const ModelLibrary published = find_library("shanxia-2023", test::source_file("models"));
  const json data = compared(published, published);
  // Published coefficients have no range of DBH, so there are no curves.
  for (const json& pair : data["pairs"]) CHECK(pair["curves"].is_null());

  ModelLibrary ranged = published;
  for (LibraryModel& model : ranged.models) {
    model.fit.ranges.clear();
    for (const std::string& name : model.fit.specification.predictors()) {
      const bool is_share = name.size() == 1 && name != "h";
      model.fit.ranges.push_back({name, is_share ? 0.0 : 5.0, is_share ? 1.0 : 45.0});
    }
    model.fit.convergence.status = fit::ConvergenceStatus::kConverged;
  }
  const json with_curves = compared(ranged, ranged);
  for (const json& pair : with_curves["pairs"]) {
    INFO(pair["species"] << ' ' << pair["response"] << ' ' << pair["role"]);
    const json& curves = pair["curves"];
    REQUIRE(curves.is_object());
    CHECK(curves["own_heights"] == (pair["response"] == "hcb"));
    CHECK_FALSE(curves["held_at"].contains("h"));
    if (pair["species"] != "SM" || pair["role"] != "ols" || pair["response"] != "hcb") continue;
    // Level 1 of SM by hand: H = 1.3 + 33.4665 (1 - exp(-0.0266 D)), HCB = H/(1 + exp(0.4501 -
    // 0.0012 D)).
    const double dbh = curves["dbh"][30].get<double>();
    const double h = 1.3 + 33.4665 * (1.0 - std::exp(-0.0266 * dbh));
    const double hcb = h / (1.0 + std::exp(0.4501 - 0.0012 * dbh));
    CHECK(curves["values"][0][30].get<double>() == Approx(hcb).epsilon(1e-12));
  }
}

TEST_CASE("one library, or a missing name, cannot be compared") {
  CHECK_THROWS_AS(comparison_data({library()}, {"a"}), UsageError);
  CHECK_THROWS_AS(comparison_data({library(), library()}, {"a"}), UsageError);
}

TEST_CASE("names of libraries are escaped in the comparison page") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() /
                                       ("silvafit-comparison-" + std::to_string(::getpid()));
  const std::filesystem::path page_template = folder / "template.html";
  write_file(page_template, "{{=<% %>=}}<title><% title %></title><script><%& data %></script>");
  const std::string name = "</script><b>\"'.json";
  write_comparison_page({library(), library()}, {name, "b.json"}, page_template, folder / "c.html");
  const std::string page = read_file(folder / "c.html");
  const std::size_t from = page.find("<script>") + 8;
  const json data = json::parse(page.substr(from, page.find("</script>", from) - from));
  CHECK(data["libraries"][0]["name"] == name);
  CHECK(page.find("<b>") == std::string::npos);
  std::filesystem::remove_all(folder);
}
