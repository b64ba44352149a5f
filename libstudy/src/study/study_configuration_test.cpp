// SPDX-License-Identifier: MIT
// Settings of a study as a file.
#include "silvafit/study/study_configuration.hpp"

#include "scratch_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/json_reader.hpp"
#include "study/study_test_support.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

StudyConfiguration read(const std::string& text) {
  const test::ScratchFile file(text, ".json");
  return read_study_configuration(file.path());
}

}  // namespace

TEST_CASE("an empty configuration has the default settings") {
  const StudyConfiguration configuration = read("{}");
  CHECK(configuration.study.responses == StudyOptions{}.responses);
  CHECK(configuration.study.criteria.covariates == Criterion::kBic);
  CHECK(configuration.units.window.empty());
  CHECK(configuration.units.edge == stand::EdgeCorrection::kBuffer);
}

TEST_CASE("a candidate that is not in the catalogue is an error with its key") {
  const Catalogue catalogue = Catalogue::load(test::source_file("models"));
  const test::ScratchFile file(R"({"candidates": {"h": ["M4", "M999"]}})", ".json");
  CHECK_NOTHROW(read_study_configuration(file.path()));
  CHECK_THROWS_AS(read_study_configuration(file.path(), &catalogue), InputError);
  CHECK_THROWS_WITH(read_study_configuration(file.path(), &catalogue),
                    Contains(".json: candidates.h") && Contains("unknown model M999"));
  const test::ScratchFile known(R"({"candidates": {"h": ["M4", "h ~ a + b*dbh"]}})", ".json");
  CHECK_NOTHROW(read_study_configuration(known.path(), &catalogue));
}

TEST_CASE("a configuration may have all keys, and comments") {
  const StudyConfiguration configuration = read(R"json({
    // With one species only.
    "species": ["SM"], "minimum_trees": 30,
    "responses": ["h"], "candidates": {"h": ["M4", "h ~ a + b*dbh"]},
    "covariates": ["C", "slope"], "covariate_parameters": 2,
    "group": "stand", "maximum_random_effects": 2, "variance_functions": ["none", "power(dbh)"],
    "criteria": {"base": "bic", "variance": "aicc"}, "choice": "parsimonious", "equally_good": 4,
    "significance": 0.01, "compared_trees": 5000,
    "columns": {"dbh": "DBH_cm"}, "window": "plots.geojson", "edge": "buffer", "buffer": 3,
    "per": "stand", "neighbors": 6, "period": "year",
    "plots": "plots.csv", "plots_columns": {"area": "SIZE"}, "circles": ["7=4", "30=12"],
    "subplots": 4, "subplot": "sub", "slope_correction": true})json");
  const StudyOptions& study = configuration.study;
  CHECK(study.species == std::vector<std::string>{"SM"});
  CHECK(study.minimum_trees == 30);
  CHECK(study.candidates.at("h") == std::vector<std::string>{"M4", "h ~ a + b*dbh"});
  CHECK(study.covariates == std::vector<std::string>{"C", "slope"});
  CHECK(study.covariate_parameters == 2);
  CHECK(study.group == "stand");
  CHECK(study.maximum_random_effects == 2);
  CHECK(study.variance_functions == std::vector<std::string>{"none", "power(dbh)"});
  CHECK(study.criteria.base == Criterion::kBic);
  CHECK(study.criteria.random == Criterion::kBic);
  CHECK(study.criteria.variance == Criterion::kAicc);
  CHECK(study.parsimonious);
  CHECK(study.equally_good == 4.0);
  CHECK(study.significance == 0.01);
  CHECK(study.compared_trees == 5000);
  CHECK(configuration.reading.columns == std::vector<std::string>{"dbh=DBH_cm"});
  CHECK_THAT(configuration.units.window, Catch::Matchers::EndsWith("/plots.geojson"));
  CHECK(configuration.units.edge == stand::EdgeCorrection::kBuffer);
  CHECK(configuration.units.buffer_m == 3.0);
  CHECK(configuration.units.per == stand::SearchScope::kStand);
  CHECK(configuration.units.neighbors == 6U);
  CHECK(study.period == "year");
  const SamplingSettings& sampling = configuration.sampling;
  CHECK_THAT(sampling.plots_file, Catch::Matchers::EndsWith("/plots.csv"));
  CHECK(sampling.plots_columns == std::vector<std::string>{"area=SIZE"});
  CHECK(sampling.circles == std::vector<std::string>{"7=4", "30=12"});
  CHECK(sampling.subplots == 4);
  CHECK(sampling.subplot == "sub");
  CHECK(sampling.slope_correction);
}

TEST_CASE("one criterion may apply to all levels, without tests") {
  const StudyOptions study = read(R"({"criteria": "cv", "tests": "shown"})").study;
  CHECK(study.criteria.base == Criterion::kCrossValidation);
  CHECK(study.criteria.variance == Criterion::kCrossValidation);
  CHECK_FALSE(study.needs_tests);
}

TEST_CASE("errors in a configuration have their key") {
  CHECK_THROWS_WITH(read(R"({"speces": []})"), Contains("speces") && Contains("species"));
  CHECK_THROWS_WITH(read(R"({"criteria": {"base": "dic"}})"), Contains("criteria.base"));
  CHECK_THROWS_WITH(read(R"({"candidates": {"h": []}})"), Contains("candidates.h"));
  CHECK_THROWS_WITH(read(R"({"candidates": {"h": ["h ~ a*("]}})"), Contains("candidates.h[0]"));
  CHECK_THROWS_WITH(read(R"({"variance_functions": ["cubic"]})"),
                    Contains("variance_functions[0]"));
  CHECK_THROWS_WITH(read(R"({"covariate_parameters": 3})"), Contains("covariate_parameters"));
  CHECK_THROWS_WITH(read(R"({"edge": "soft"})"), Contains("edge"));
  CHECK_THROWS_WITH(read("{\n\"species\": [\n}"), Contains("not valid JSON"));
}

TEST_CASE("the generated configuration has the default settings") {
  const data::Table table = test::stand({});
  const std::string text = study_configuration_for(table, test::catalogue());
  CHECK_THAT(text, Contains("SM (240)"));
  CHECK_THAT(text, Contains("\"M4\",  // Meyer: h ~ 1.3 + a*(1 - exp(-b*dbh))"));
  const StudyConfiguration configuration = read(text);
  CHECK(data::JsonReader::parse(text, "study.json", true).members_by_name().size() == 49);
  const StudyOptions& study = configuration.study;
  CHECK(study.species.empty());
  CHECK(study.responses == std::vector<std::string>{"h"});  // the stand has no other response
  CHECK(study.candidates.at("h").size() == test::catalogue().candidates("h").size());
  CHECK(study.criteria.variance == StudyOptions{}.criteria.variance);
  CHECK(study.variance_functions == StudyOptions{}.variance_functions);
  CHECK_FALSE(study.parsimonious);
}

TEST_CASE("candidates may be formulas of the user, also for other responses") {
  data::Table table = test::stand({});
  std::vector<double> areas;
  for (const double dbh : table.numbers("dbh")) {
    areas.push_back(0.007854 * dbh * dbh + (areas.size() % 2 == 0 ? 1e-3 : -1e-3));
  }
  table.set("area", areas);
  StudyOptions options{.responses = {"h", "area"}, .covariates = {}};
  options.candidates["h"] = {"M4", "h ~ 1.3 + limit*(1 - exp(-rate*dbh))"};
  options.candidates["area"] = {"area ~ k*dbh^2"};
  const Study study = run_study(table, test::catalogue(), options);
  REQUIRE(study.results.size() == 2);
  const std::vector<Candidate>& base = study.results[0].base;
  REQUIRE(base.size() == 2);
  CHECK(base[0].fit.model == "M4");
  CHECK(base[1].fit.model.empty());
  // The same equation under other names: the same optimum, to the digits of a converged fit.
  CHECK(base[1].fit.log_likelihood == Approx(base[0].fit.log_likelihood).epsilon(1e-10));
  CHECK(base[1].fit.coefficient_names == std::vector<std::string>{"limit", "rate"});
  REQUIRE(study.results[1].ols);
  // The disturbance of 1e-3 is below 0.1 % of typical areas.
  CHECK(study.results[1].ols->fit.estimate[0] == Approx(0.007854).epsilon(1e-3));
}

TEST_CASE("candidates of another response are errors") {
  const data::Table table = test::stand({});
  StudyOptions options{.responses = {"h"}};
  options.candidates["h"] = {"M22"};
  CHECK_THROWS_WITH(run_study(table, test::catalogue(), options), Contains("not a model for h"));
  options.candidates.clear();
  options.responses = {"volume"};
  CHECK_THROWS_WITH(run_study(table, test::catalogue(), options), Contains("study.json"));
}
