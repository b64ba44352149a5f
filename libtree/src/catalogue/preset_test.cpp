// SPDX-License-Identifier: MIT
#include "silvafit/tree/preset.hpp"

#include <catch2/catch.hpp>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;
namespace fs = std::filesystem;

TEST_CASE("the catalogue has its presets") {
  const test::ShippedPresets& catalogue = test::shipped_presets();
  CHECK(catalogue.named("generic-conifer").foliage.kind == FoliageKind::kNeedles);
  CHECK(catalogue.named("generic-broadleaf").foliage.kind == FoliageKind::kLeaves);
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
  for (const char* folder : {"taper", "shoots", "bark"}) {
    fs::copy(test::source_file("models") / folder, models / folder);
  }
  const std::string good = read_file(test::source_file("models/presets/generic-broadleaf.json"));
  const auto column_of_error = [&](const std::string& find, const std::string& replacement) {
    std::string text = good;
    REQUIRE(text.find(find) != std::string::npos);
    text.replace(text.find(find), find.size(), replacement);
    write_file(models / "presets" / "generic-broadleaf.json", text);
    try {
      SegmentBuilder::load(models, models / "presets" / "generic-broadleaf.json");
    } catch (const InputError& error) {
      return test::path_of(error);
    }
    return std::string("accepted");
  };
  const auto with_value = [&](const std::string& field, const std::string& value) {
    const std::size_t at = good.find("\"" + field + "\": ");
    REQUIRE(at != std::string::npos);
    std::size_t end = at + field.size() + 4;
    for (int depth = 0; end < good.size(); ++end) {
      if (good[end] == '[' || good[end] == '{') ++depth;
      if (depth == 0 && (good[end] == ',' || good[end] == ' ' || good[end] == '\n')) break;
      if (good[end] == ']' || good[end] == '}') --depth;
    }
    return column_of_error(good.substr(at, end - at), "\"" + field + "\": " + value);
  };
  CHECK(with_value("index_up", "3.5") == "crown.index_up");
  CHECK(with_value("index_up", "\"round\"") == "crown.index_up");
  CHECK(with_value("arrangement", "\"random\"") == "branching.arrangement");
  CHECK(with_value("angle_layers", "[[0, 80, 50]]") == "branching.angle_layers");
  CHECK(with_value("angle_layers", "[[0.1, 50, 80]]") == "branching.angle_layers");
  CHECK(with_value("leaves_per_tuft", "2.5") == "foliage.leaves_per_tuft");
  CHECK(with_value("limbs", "0") == "branching.fork.limbs");
  CHECK(with_value("segments", "0") == "branching.segments");
  CHECK(with_value("outer_color", "[0, 0, 2]") == "foliage.outer_color");
  CHECK(with_value("outer_color", "[0, 1, 1]") == "foliage.outer_color");
  CHECK(with_value("picture", "\"roses\"") == "leafy_shoots.picture");
  CHECK(with_value("groove", "1.5") == "leafy_shoots.groove");
  CHECK(with_value("bark", "\"cork\"") == "bark");
  CHECK(with_value("bark_color",
                   "[0.1, 0.1, 0.1], \"bark_by_diameter\": [[1, 0, 0, 0], [0.5, 0, 0, 0]]") ==
        "bark_by_diameter");
  CHECK(with_value("taper", "\"none\"").empty());
  CHECK(column_of_error("\"basis\"", "\"basics\"") == "basis");
  CHECK(with_value("index_up", "1.5") == "accepted");
  fs::remove_all(models);
}
