// SPDX-License-Identifier: MIT
#include "silvafit/study/model_library.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "scratch_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/fit_json.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

fit::FittedModel line() {
  data::Table table;
  table.set("dbh", std::vector<double>{10.0, 20.0, 30.0, 40.0});
  table.set("h", std::vector<double>{11.0, 21.1, 31.3, 40.7});
  return fit::fit_model(fit::specify_model("h ~ a + b*dbh", {}, table), table).fit;
}

ModelLibrary library() {
  ModelLibrary result{.inventory = {.file = "trees.csv", .fingerprint = "sha256:00", .trees = 4}};
  result.models.push_back(
      {.species = "SM", .response = "h", .unit = "m", .role = "ols", .fit = line()});
  result.models.push_back({.species = "BHN", .response = "h", .role = "nlme", .fit = line()});
  return result;
}

}  // namespace

TEST_CASE("a library is read back from its file and written with the same bytes") {
  const test::ScratchFile file("", ".json");
  const ModelLibrary written = library();
  write_library(written, file.path());
  const ModelLibrary read = read_library(file.path());
  CHECK(to_json(read) == to_json(written));
  CHECK(read.inventory.file == "trees.csv");
  CHECK(read.inventory.trees == 4);
  REQUIRE(read.models.size() == 2);
  CHECK(read.models[0].species == "SM");
  CHECK(read.models[0].unit == "m");
  CHECK(read.models[1].unit.empty());
  CHECK(read.models[1].role == "nlme");
  CHECK(read.models[0].fit.estimate == written.models[0].fit.estimate);
  CHECK(read.models[0].fit.covariance == written.models[0].fit.covariance);
}

TEST_CASE("a library stores how the structural indices of its study were computed") {
  ModelLibrary written = library();
  written.inventory.units = {.per = stand::SearchScope::kStand,
                             .neighbors = 6,
                             .alpha = std::vector<std::string>{"60", "SM=72"},
                             .dominance = stand::SizeMeasure::kHeight,
                             .crowding = stand::CrownReach::kFacingRadii,
                             .competition_radius_m = 7.5,
                             .open_grown = "0.7 + 0.16*dbh"};
  const test::ScratchFile file(to_json(written), ".json");
  const auto units = read_library(file.path()).inventory.units;
  REQUIRE(units.has_value());
  CHECK(units->per == stand::SearchScope::kStand);
  CHECK(units->neighbors == 6U);
  CHECK(units->alpha == std::vector<std::string>{"60", "SM=72"});
  CHECK(units->dominance == stand::SizeMeasure::kHeight);
  CHECK(units->crowding == stand::CrownReach::kFacingRadii);
  CHECK(units->competition_radius_m == 7.5);
  CHECK(units->open_grown == "0.7 + 0.16*dbh");
  const test::ScratchFile without(to_json(library()), ".json");
  CHECK(!read_library(without.path()).inventory.units);
}

TEST_CASE("one fit or several are libraries for any species") {
  const test::ScratchFile one(fit::to_json(line()), ".json");
  CHECK(read_library(one.path()).models.size() == 1);
  const test::ScratchFile several(
      "{\"fits\": [" + fit::to_json(line()) + "," + fit::to_json(line()) + "]}", ".json");
  const ModelLibrary read = read_library(several.path());
  REQUIRE(read.models.size() == 2);
  CHECK(read.models[1].species.empty());
  CHECK(read.models[1].response == "h");
}

TEST_CASE("an invalid library is an error with file and key") {
  const auto read = [](const std::string& text) {
    const test::ScratchFile file(text, ".json");
    return read_library(file.path());
  };
  CHECK_THROWS_WITH(
      read("{\"schema\": \"silvafit-library/9\"}"),
      Contains(".json: schema: silvafit-library/9 was written by a newer version of silvafit"));
  CHECK_THROWS_WITH(read("{\"schema\": \"else\"}"), Contains("schema: must be"));
  CHECK_THROWS_WITH(read("{}"), Contains("\"schema\" is missing"));
  std::string text = to_json(library());
  const std::size_t place = text.find("\"response\": \"h\"");
  text.replace(place, 15, "\"response\": \"q\"");
  CHECK_THROWS_WITH(read(text), Contains("models[0].response: is not the left-hand side"));
  for (const char* trees : {"1e77", "-1", "0.5", "null"}) {
    CHECK_THROWS_WITH(
        read(fmt::format(
            "{{\"schema\": \"silvafit-library/1\", \"inventory\": "
            "{{\"file\": \"a.csv\", \"fingerprint\": \"f\", \"trees\": {}}}, \"models\": []}}",
            trees)),
        Contains("inventory.trees: must be a whole number of 0 or more"));
  }
}
