// SPDX-License-Identifier: MIT
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "bamboo/bamboo.hpp"
#include "bamboo/bamboo_leaves.hpp"
#include "scratch_file.hpp"
#include "silvafit/base/error.hpp"
#include "test_support/bamboo_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

TEST_CASE("pictures are ranked by the color weight of their visible pixels") {
  // Half the pixels drawn: (3, 4, 12) has the weight 13, (0, 0, 0) none; the rest is transparent.
  const Texture picture{.name = "a",
                        .width = 2,
                        .height = 2,
                        .rgba = {3, 4, 12, 255, 0, 0, 0, 255, 250, 250, 250, 0, 9, 9, 9, 100}};
  CHECK(color_weight(picture) == Approx(6.5).epsilon(1e-15));
  CHECK(color_weight({.width = 1, .height = 1, .rgba = {9, 9, 9, 0}}) == 0.0);
  const auto& pictures = test::moso().preset().leaves.pictures;
  REQUIRE(pictures.size() >= 3);
  for (std::size_t i = 1; i < pictures.size(); ++i) {
    CHECK(color_weight(*pictures[i]) > color_weight(*pictures[i - 1]));
  }
  for (const auto& leaf : pictures) {
    REQUIRE(leaf->rgba.size() == 4 * leaf->width * leaf->height);
    std::size_t drawn = 0;
    for (std::size_t i = 3; i < leaf->rgba.size(); i += 4) drawn += leaf->rgba[i] > 127 ? 1 : 0;
    const double cover =
        static_cast<double>(drawn) / static_cast<double>(leaf->width * leaf->height);
    CHECK(cover > 0.1);
    CHECK(cover < 0.6);
  }
  const std::vector<std::shared_ptr<const Texture>> turned(pictures.rbegin(), pictures.rend());
  CHECK(ranked_by_color(turned) == pictures);
}

TEST_CASE("an invalid bamboo preset is refused with its file and field") {
  const std::filesystem::path models = test::source_file("models");
  std::ifstream file(models / "bamboo" / "moso.json");
  const std::string good((std::istreambuf_iterator<char>(file)), {});
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string bad = good;
    const std::size_t at = bad.find(from);
    REQUIRE(at != std::string::npos);
    bad.replace(at, from.size(), to);
    const test::ScratchFile scratch(bad, ".json");
    try {
      BambooBuilder::load(models, scratch.path());
    } catch (const InputError& error) {
      return test::path_of(error);
    }
    return std::string("accepted");
  };
  CHECK(refused("\"mu\": 4", "\"mu\": 3.5") == "branches.mu");
  CHECK(refused("\"expectation_deg\": 50", "\"expectation_deg\": 80") ==
        "branches.angle.expectation_deg");
  CHECK(refused("\"internode_m\"", "\"internode\"") == "culm.internode");
  CHECK(refused("\"form\": \"crossed cards\"", "\"form\": \"ball\"") == "leaves.form");
  CHECK(refused("\"outer\": 0.4", "\"outer\": 0.5") == "leaves.light.outer");
  CHECK(refused("\"grades\": 4", "\"grades\": 2.5") == "leaves.grades");
  CHECK(refused("\"picture_size\": 256", "\"picture_size\": 257") == "leaves.picture_size");
  CHECK(refused("\"bark_color\": [0.19", "\"bark_color\": [1.9") == "bark_color");
}

TEST_CASE("pictures are copied side by side") {
  const auto one = std::make_shared<const Texture>(
      Texture{.name = "one", .width = 1, .height = 1, .rgba = {1, 2, 3, 255}});
  const auto two = std::make_shared<const Texture>(
      Texture{.name = "two", .width = 2, .height = 1, .rgba = {4, 5, 6, 255, 7, 8, 9, 0}});
  const PictureRow row = side_by_side({one, two, one}, 2, "row");
  // Three squares of two pixels and an empty one.
  CHECK(row.whole->width == 8);
  CHECK(row.whole->height == 2);
  CHECK(row.share == 0.25);
  const std::vector<std::uint8_t> line{1, 2, 3, 255, 1, 2, 3, 255, 4, 5, 6, 255, 7, 8, 9, 0,
                                       1, 2, 3, 255, 1, 2, 3, 255, 0, 0, 0, 0,   0, 0, 0, 0};
  const auto& rgba = row.whole->rgba;
  REQUIRE(rgba.size() == 2 * line.size());
  CHECK(std::equal(line.begin(), line.end(), rgba.begin()));
  CHECK(std::equal(line.begin(), line.end(), rgba.begin() + 32));
  // 188 is the sRGB of 0.5029 (IEC 61966-2-1).
  const Color mean = mean_color({.width = 2, .height = 1, .rgba = {188, 0, 255, 255, 9, 9, 9, 0}});
  CHECK(mean[0] == Approx(0.5029).margin(0.0001));
  CHECK(mean[1] == 0.0);
  CHECK(mean[2] == 1.0);
}

TEST_CASE("a preset's own pictures are ranked for any order and size") {
  // Opaque, packed with Python's zlib: 2 x 1 pixels (200, 220, 90) (180, 210, 80), and 1 x 1
  // of (20, 60, 15).
  const std::string bright = std::string(
      "\211\120\116\107\015\012\032\012\000\000\000\015\111\110\104\122\000\000"
      "\000\002\000\000\000\001\010\002\000\000\000\173\100\350\335\000\000\000"
      "\017\111\104\101\124\170\332\143\070\161\047\152\313\245\000\000\016\173"
      "\003\325\054\270\227\037\000\000\000\000\111\105\116\104\256\102\140\202",
      72);
  const std::string dark = std::string(
      "\211\120\116\107\015\012\032\012\000\000\000\015\111\110\104\122\000\000"
      "\000\001\000\000\000\001\010\002\000\000\000\220\167\123\336\000\000\000"
      "\014\111\104\101\124\170\332\143\020\261\341\007\000\000\307\000\140\150"
      "\306\366\207\000\000\000\000\111\105\116\104\256\102\140\202",
      69);
  const test::ScratchFile first(bright, ".png");
  const test::ScratchFile second(dark, ".png");
  std::ifstream file(test::source_file("models/bamboo/moso.json"));
  std::string text((std::istreambuf_iterator<char>(file)), {});
  const std::string field = "\"pictures\": [\"" + first.path().filename().string() + "\", \"" +
                            second.path().filename().string() + "\"], \"per_twig\"";
  text.replace(text.find("\"per_twig\""), 10, field);
  const test::ScratchFile preset(text, ".json");
  const auto builder = BambooBuilder::load(test::source_file("models"), preset.path());
  const BambooPreset& loaded = builder->preset();
  REQUIRE(loaded.leaves.pictures.size() == 2);
  CHECK(loaded.leaves.pictures[0]->rgba == std::vector<std::uint8_t>{20, 60, 15, 255});
  CHECK(loaded.leaves.pictures[1]->rgba ==
        std::vector<std::uint8_t>{200, 220, 90, 255, 180, 210, 80, 255});
  const SceneTree bamboo = grow_tree(test::usual_culm(), *builder, {.mesh = {.textured = true}});
  REQUIRE(bamboo.mesh.parts.back().texture);
  CHECK(bamboo.mesh.parts.back().texture->width == 512);

  const test::ScratchFile broken(bright.substr(0, 40), ".png");
  text.replace(text.find(first.path().filename().string()),
               first.path().filename().string().size(),
               broken.path().filename().string());
  const test::ScratchFile bad(text, ".json");
  CHECK_THROWS_AS(BambooBuilder::load(test::source_file("models"), bad.path()), InputError);
}
