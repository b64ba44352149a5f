// SPDX-License-Identifier: MIT
// Scenes of the structural classes from the published library.
#include "silvafit/study/scenes.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <set>

#include "reference.hpp"
#include "scratch_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/study/predict_responses.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

ModelLibrary shanxia() { return find_library("shanxia-2023", test::source_file("models")); }

const fit::FittedModel& fit_of(const ModelLibrary& library,
                               const std::string& species,
                               const std::string& response,
                               const std::string& role) {
  for (const LibraryModel& model : library.models) {
    if (model.species == species && model.response == response && model.role == role) {
      return model.fit;
    }
  }
  throw UsageError("no such model");
}

}  // namespace

TEST_CASE("published coefficients form a library that predicts without any fit") {
  const ModelLibrary library = shanxia();
  CHECK(library.models.size() == 27);
  data::Table trees;
  data::TextColumn species;
  species.append("SM");
  species.append("BHN");
  trees.set("species", species);
  trees.set("dbh", std::vector<double>{25.9, 14.4});
  trees.set("C", std::vector<double>{0.5, 0.25});
  trees.set("M", std::vector<double>{0.0, 1.0});
  trees.set("U", std::vector<double>{0.25, 0.75});
  const PredictedResponses predicted = predict_responses(library, trees);
  REQUIRE(predicted.responses.size() == 3);
  REQUIRE(predicted.responses[0].response == "h");
  // Table 4 with the signs of equations 15 and 18; only rounding differs.
  const double sm = 1.3 + 36.7543 * (1.0 - std::exp((-0.0236 + -0.0045 * 0.5) * 25.9));
  CHECK(predicted.responses[0].value[0] == Approx(sm).epsilon(1e-12));
  const double bhn =
      1.3 + 20.0990 * (1.0 - std::exp((-0.0399 + -0.0133 * 0.25 + -0.0078 * 0.75) * 14.4));
  CHECK(predicted.responses[0].value[1] == Approx(bhn).epsilon(1e-12));
}

TEST_CASE("values that a publication lacks are missing from its library") {
  const ModelLibrary library = shanxia();
  const fit::FittedModel& mixed = fit_of(library, "SM", "h", "nlme");
  CHECK(mixed.convergence.converged());
  CHECK_THAT(mixed.convergence.verdict(), Contains("Published model, not fitted by silvafit"));
  CHECK(mixed.standard_errors().array().isNaN().all());
  CHECK(std::isnan(mixed.sigma));
  // Table 5: variances 4.99 and 7.51e-5, correlation -0.986.
  CHECK(mixed.random.back().covariance(0, 1) == Approx(-0.986 * std::sqrt(4.99 * 7.51e-5)));
  const fit::FittedModel& unprinted = fit_of(library, "BHN", "h", "nlme");
  CHECK(std::isnan(unprinted.random.back().covariance(1, 1)));
  // Of a base model sigma^2 = SSE / (n - p); RMSE^2 = SSE / n but for the mean error of 0.02 m and
  // n - 1, which are below a thousandth.
  const fit::FittedModel& base = fit_of(library, "SM", "h", "ols");
  // Table 4 prints an AIC of 4686.538 for three parameters, sigma among them, with a log-likelihood
  // of two decimals.
  CHECK(base.aic() == Approx(4686.538).margin(0.01));
  CHECK(std::isnan(mixed.aic()));
  CHECK(base.sigma == Approx(2.7644 * std::sqrt(961.0 / 959.0)).epsilon(1e-12));
}

TEST_CASE("a published library is read back from a library file") {
  const test::ScratchFile file("", ".json");
  const ModelLibrary library = shanxia();
  write_library(library, file.path());
  const ModelLibrary read = read_library(file.path());
  CHECK(to_json(read) == to_json(library));
  CHECK(read.inventory.commonest_dbh_cm.at("BHN") == 14.4);
}

TEST_CASE("an unknown library is an error that lists the published ones") {
  CHECK(published_libraries(test::source_file("models")) ==
        std::vector<std::string>{"shanxia-2023"});
  CHECK_THROWS_WITH(find_library("shanxia-2023", "/nowhere/models"),
                    Contains("/nowhere/models/published") && Contains("No such file"));
  CHECK_THROWS_WITH(find_library("shanxia", test::source_file("models")),
                    Contains("shanxia: is neither") && Contains("shanxia-2023"));
}

TEST_CASE("the published library has 25, 25 and 125 scenes") {
  const Scenes scenes = scenes_of(shanxia());
  REQUIRE(scenes.species.size() == 3);
  CHECK(scenes.species[0].indices == std::vector<std::string>{"C", "M"});
  CHECK(scenes.species[0].scenes == 25);
  CHECK(scenes.species[1].indices == std::vector<std::string>{"C", "U"});
  CHECK(scenes.species[1].scenes == 25);
  CHECK(scenes.species[2].indices == std::vector<std::string>{"C", "M", "U"});
  CHECK(scenes.species[2].scenes == 125);
  CHECK(scenes.trees.rows() == std::size_t{175} * 5);
  const data::TextColumn plots = scenes.trees.labels("plot");
  std::set<std::string> names;
  for (std::size_t row = 0; row < plots.size(); ++row) names.emplace(plots[row]);
  CHECK(names.size() == 175);
}

TEST_CASE("the reference tree of each scene has the indices of its class") {
  for (const double uniform_angle : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const Scenes scenes = scenes_of(shanxia(), {.uniform_angle_index = uniform_angle});
    const test::ScratchFile file("", ".csv");
    data::write_csv_table(scenes.trees, file.path());
    const stand::Inventory inventory = stand::read_inventory(file.path()).inventory;
    REQUIRE(inventory.size() == scenes.trees.rows());
    const stand::StructuralUnits units = stand::structural_units(
        inventory, {.edge = stand::EdgeCorrection::kNone, .scope = stand::SearchScope::kPlot});
    for (std::size_t row = 0; row < inventory.size(); row += 5) {
      INFO(scenes.trees.labels("plot")[row]);
      CHECK(units.W[row] == scenes.trees.numbers("W")[row]);
      CHECK(units.M[row] == scenes.trees.numbers("M")[row]);
      CHECK(units.U[row] == scenes.trees.numbers("U")[row]);
      CHECK(units.C[row] == scenes.trees.numbers("C")[row]);
      CHECK(units.W[row] == uniform_angle);
    }
  }
}

TEST_CASE("scenes need models of all responses, a DBH and possible trees") {
  ModelLibrary library = shanxia();
  CHECK_THROWS_WITH(scenes_of(library, {.species = {"OAK"}}), Contains("SM, BHN, MH"));
  CHECK_THROWS_WITH(scenes_of(library, {.uniform_angle_index = 0.3}), Contains("W must be"));
  // For a DBH of 0, the height is breast height.
  CHECK_THROWS_WITH(scenes_of(library, {.species = {"SM"}, .dbh_cm = {{"SM", 1e-300}}}),
                    Contains("not a possible tree"));
  CHECK_THROWS_WITH(scenes_of(library, {.dbh_cm = {{"XX", 20.0}}}), Contains("no models for XX"));
  CHECK_THROWS_WITH(scenes_of({}), Contains("no models with the role nlme"));
  library.inventory.commonest_dbh_cm.clear();
  CHECK_THROWS_WITH(scenes_of(library, {.species = {"SM"}}), Contains("SM=20"));
  std::erase_if(library.models, [](const LibraryModel& model) { return model.response == "cw"; });
  CHECK_THROWS_WITH(scenes_of(library, {.species = {"SM"}, .dbh_cm = {{"SM", 20.0}}}),
                    Contains("no model for cw"));
}

TEST_CASE("the most frequent DBH is the maximum of the density") {
  // Symmetric and with one peak: its middle.
  CHECK(commonest_dbh_cm({18.0, 19.5, 20.0, 20.5, 22.0}) == 20.0);
  CHECK(commonest_dbh_cm({12.3, 12.3}) == 12.3);
  // Many trees near 10 and some at 40; the maximum of a normal density is its mean.
  std::vector<double> diameters{40.0, 41.0, data::kMissing};
  for (int i = -20; i <= 20; ++i) diameters.push_back(10.0 + 0.1 * i);
  CHECK(commonest_dbh_cm(diameters) == Approx(10.0).margin(0.05));
  const double before = commonest_dbh_cm(diameters);
  diameters.push_back(2.5e8);  // mistyped: it must affect neither the result nor the time
  CHECK(commonest_dbh_cm(diameters) == before);
  CHECK(commonest_dbh_cm({3e9, 4e9}) == 3e9);
}
