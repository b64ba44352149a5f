// SPDX-License-Identifier: MIT
#include "silvafit/tree/preset.hpp"

#include <catch2/catch.hpp>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;
namespace fs = std::filesystem;

TEST_CASE("the catalogue has its presets, and finds the preset of a species") {
  const PresetCatalogue& catalogue = test::shipped_presets();
  CHECK(catalogue.named("generic-conifer").foliage.kind == FoliageKind::kNeedles);
  CHECK(catalogue.named("generic-broadleaf").foliage.kind == FoliageKind::kLeaves);
  const auto name_for = [&](const char* species) {
    const Preset* preset = catalogue.for_species(species);
    return preset == nullptr ? std::string() : preset->name;
  };
  CHECK(name_for("Cunninghamia lanceolata") == "cunninghamia-lanceolata");
  CHECK(name_for("SM") == "cunninghamia-lanceolata");
  CHECK(name_for("schima SUPERBA") == "schima-superba");
  CHECK(name_for("Machilus thunbergii") == "machilus-pauhoi");
  CHECK(name_for("Picea abies") == "generic-conifer");
  CHECK(name_for("Quercus robur") == "generic-broadleaf");
  CHECK(catalogue.for_species("OF") == nullptr);
  CHECK(catalogue.for_species("") == nullptr);
  CHECK_THROWS_AS(catalogue.named("oak"), UsageError);
}

TEST_CASE("no species is listed by two presets") {
  std::vector<std::string> all;
  for (const Preset& preset : test::shipped_presets().presets()) {
    all.insert(all.end(), preset.species.begin(), preset.species.end());
  }
  std::sort(all.begin(), all.end());
  CHECK(std::adjacent_find(all.begin(), all.end()) == all.end());
}

TEST_CASE("a preset with an invalid field is refused with file and field") {
  const fs::path models = fs::temp_directory_path() / "silvafit-preset-test";
  fs::remove_all(models);
  fs::create_directories(models / "presets");
  fs::copy(test::source_file("models/taper"), models / "taper");
  const std::string good = read_file(test::source_file("models/presets/generic-broadleaf.json"));
  const auto column_of_error = [&](const std::string& find, const std::string& replacement) {
    std::string text = good;
    REQUIRE(text.find(find) != std::string::npos);
    text.replace(text.find(find), find.size(), replacement);
    write_file(models / "presets" / "generic-broadleaf.json", text);
    try {
      PresetCatalogue::load(models);
    } catch (const InputError& error) {
      return test::path_of(error);
    }
    return std::string("accepted");
  };
  const auto with_value = [&](const std::string& field, const std::string& value) {
    return column_of_error("\"" + field + "\": ", "\"" + field + "\": " + value + ", \"was\": ");
  };
  CHECK(with_value("index_up", "3") == "crown.index_up");
  CHECK(with_value("index_up", "\"round\"") == "crown.index_up");
  CHECK(with_value("arrangement", "\"random\"") == "branching.arrangement");
  CHECK(with_value("angle_layers", "[[0, 80, 50]]") == "branching.angle_layers");
  CHECK(with_value("angle_layers", "[[0.1, 50, 80]]") == "branching.angle_layers");
  CHECK(with_value("leaves_per_tuft", "2.5") == "foliage.leaves_per_tuft");
  CHECK(with_value("limbs", "0") == "branching.fork.limbs");
  CHECK(with_value("segments", "0") == "branching.segments");
  CHECK(with_value("outer_color", "[0, 0, 2]") == "foliage.outer_color");
  CHECK(with_value("outer_color", "[0, 1, 1]") == "foliage.outer_color");
  CHECK(with_value("taper", "\"none\"").empty());
  CHECK(column_of_error("\"basis\"", "\"basics\"") == "basis");
  CHECK(with_value("index_up", "1.5") == "accepted");
  fs::remove_all(models);
}
