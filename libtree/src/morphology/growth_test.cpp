// SPDX-License-Identifier: MIT
#include "silvafit/tree/growth.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <nlohmann/json.hpp>

#include "scratch_file.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/tree/scene_reader.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

data::Table growth_table(const std::string& csv) {
  const test::ScratchFile file(csv);
  return data::read_csv_table(file.path(), {.text_columns = {"plot", "tree", "species"}});
}

/// Tree 1 grows from 2021 to 2023, 2 is cut after 2022, 3 is new in 2023, 4 was not measured in
/// 2022 and does not change.
const char* const kGrowth =
    "year,plot,tree,x,y,dbh,h,hcb,cw\n"
    "2023,1,1,0,0,12,12,4,3\n"
    "2021,1,1,0,0,10,10,4,2\n"
    "2022,1,1,0,0,11,10,4,2.5\n"
    "2021,1,2,5,0,10,10,4,2\n"
    "2022,1,2,5,0,10,10,4,2\n"
    "2023,1,3,9,0,10,8,4,2\n"
    "2021,1,4,9,5,10,8,4,2\n"
    "2023,1,4,9,5,10,8,4,2\n";

std::vector<SceneWriter::Model> numbered(const GrowingTree& tree) {
  std::vector<SceneWriter::Model> models;
  for (std::size_t i = 0; i < tree.stages.size(); ++i) models.push_back(i);
  return models;
}

using Scale = std::array<double, 3>;

/// The value of keyframes at a time: each is valid until the next.
double shown_at(const AnimatedModel& model, double time_s) {
  double shown = -1.0;
  for (const Keyframe& keyframe : model.shown) {
    if (keyframe.time_s <= time_s) shown = keyframe.scale[0];
  }
  return shown;
}

}  // namespace

TEST_CASE("a table is split by its times, in their order") {
  const Moments all = read_moments(growth_table(kGrowth), "year", {});
  REQUIRE(all.moments.size() == 3);
  CHECK(all.left_out.empty());
  CHECK(all.moments[0].name == "2021");
  CHECK(all.moments[2].time == 2023.0);
  CHECK(all.moments[0].trees.size() == 3);
  CHECK(all.moments[1].trees.size() == 2);
  CHECK(all.moments[1].trees[0].dbh_cm == 11.0);
  // Text: in the order of its appearance.
  const Moments text = read_moments(
      growth_table(
          "when,plot,tree,dbh,h,hcb,cw\nspring,1,1,9,9,3,2\nautumn,1,1,9,9,3,2\n,1,1,9,9,3,2\n"
          "spring,1,1,9,9,3,2\nautumn,1,2,9,1,3,2\n"),
      "when",
      {});
  REQUIRE(text.moments.size() == 2);
  CHECK(text.moments[0].name == "spring");
  CHECK(text.moments[1].time == 1.0);
  // No time, a tree twice at one time, an impossible height.
  REQUIRE(text.left_out.size() == 3);
  CHECK(text.left_out[0].place.line == std::size_t{4});
  CHECK_THROWS_AS(read_moments(growth_table(kGrowth), "month", {}), InputError);
  CHECK_THROWS_AS(read_moments(growth_table(kGrowth), "year", {.plots = {"9"}}), InputError);
}

TEST_CASE("trees have a stage for each change over time") {
  const Moments all = read_moments(growth_table(kGrowth), "year", {});
  const std::vector<GrowingTree> trees = growing_trees(all.moments);
  REQUIRE(trees.size() == 4);
  CHECK(trees[0].stages.size() == 3);
  CHECK(trees[0].gone == 3);
  CHECK(trees[1].stages.size() == 1);
  CHECK(trees[1].gone == 2);
  CHECK(trees[2].stages.size() == 1);  // 4: forgotten, unchanged
  CHECK(trees[2].gone == 3);
  CHECK(trees[3].stages.front().moment == 2);
}

TEST_CASE("keyframes show one stage at a time, which grows to the next one's size") {
  const Moments all = read_moments(growth_table(kGrowth), "year", {});
  const std::vector<GrowingTree> trees = growing_trees(all.moments);
  const Pace pace{.seconds_per_unit = 2.0, .growing_up = 0.25};
  const auto first = animated(trees[0], all.moments, numbered(trees[0]), pace);
  REQUIRE(first.size() == 3);
  for (const double time : {0.0, 1.0, 2.0, 3.9, 4.0, 5.0, 6.0}) {
    double shown = 0.0;
    for (const AnimatedModel& model : first) shown += shown_at(model, time);
    CHECK(shown == 1.0);
  }
  // From 2 to 2.5 m width and to its height in 2022: linear, 2 s long.
  REQUIRE(first[0].size.size() == 2);
  CHECK(first[0].size[1].time_s == 2.0);
  CHECK(first[0].size[1].scale == Scale{1.25, 1.0, 1.25});
  CHECK(first[1].size[1].scale == Scale{3.0 / 2.5, 1.2, 3.0 / 2.5});
  CHECK(first[2].size.empty());
  CHECK_FALSE(first[0].at_rest);
  CHECK(first[2].at_rest);

  const auto cut = animated(trees[1], all.moments, numbered(trees[1]), pace);
  CHECK(shown_at(cut[0], 3.9) == 1.0);
  CHECK(shown_at(cut[0], 4.0) == 0.0);
  CHECK_FALSE(cut[0].at_rest);

  // It grows up in the quarter of a year before it is measured.
  const auto shooting = animated(trees[3], all.moments, numbered(trees[3]), pace);
  CHECK(shown_at(shooting[0], 3.4) == 0.0);
  CHECK(shown_at(shooting[0], 3.5) == 1.0);
  REQUIRE(shooting[0].size.size() == 2);
  CHECK(shooting[0].size[0].time_s == 3.5);
  CHECK(shooting[0].size[0].scale == Scale{0.0, 0.0, 0.0});
  CHECK(shooting[0].size[1].time_s == 4.0);
  for (const auto* models : {&first, &cut, &shooting}) {
    for (const AnimatedModel& model : *models) {
      CHECK(model.shown.front().time_s == 0.0);
      CHECK(model.shown.back().time_s == 6.0);
      for (const auto* keyframes : {&model.shown, &model.size}) {
        for (std::size_t i = 1; i < keyframes->size(); ++i) {
          CHECK((*keyframes)[i].time_s > (*keyframes)[i - 1].time_s);
        }
      }
    }
  }
  CHECK_THROWS_AS(animated(trees[0], all.moments, numbered(trees[0]), {.seconds_per_unit = 0.0}),
                  UsageError);
  // Without a time for growing up it uses the whole time since the last measurement.
  const auto slow = animated(trees[3], all.moments, numbered(trees[3]), {});
  CHECK(slow[0].size[0].time_s == 1.0);
  CHECK(slow[0].size[1].time_s == 2.0);
}

TEST_CASE("an animated scene at rest shows the last moment") {
  const Moments all = read_moments(growth_table(kGrowth), "year", {});
  const Preset& preset = test::shipped_presets().named("generic-broadleaf");
  const test::ScratchFile file("", ".glb");
  {
    const auto writer = open_scene(file.path(), SceneFormat::kGlb, {});
    for (const GrowingTree& tree : growing_trees(all.moments)) {
      std::vector<SceneWriter::Model> models;
      for (const Stage& stage : tree.stages) {
        const SceneTree grown = grow_tree(stage.tree, preset, {.mesh = level_of_detail(3)});
        models.push_back(writer->add_model("m", parts_of(grown.mesh, grown.preset)));
      }
      const Morphology& last = tree.stages.back().tree;
      writer->animate(
          "t" + last.tree, last.position, animated(tree, all.moments, models, {}), "{\"a\":1}");
    }
    writer->finish();
  }
  // Trees 1, 4 and 3 stand in 2023; 2 is gone.
  const ReadScene scene = read_scene(file.path());
  CHECK(scene.instances.size() == 3);

  const std::string bytes = read_file(file.path());
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, 4);
  const auto gltf = nlohmann::json::parse(bytes.substr(20, size));
  REQUIRE(gltf["animations"].size() == 1);
  const auto& animation = gltf["animations"][0];
  CHECK(gltf["scenes"][0]["nodes"].size() == 4);
  // 6 stages are shown and hidden; two of tree 1 grow, and tree 3 grows up.
  CHECK(animation["channels"].size() == 9);
  std::size_t steps = 0;
  for (const auto& channel : animation["channels"]) {
    CHECK(channel["target"]["path"] == "scale");
    const auto& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
    steps += sampler["interpolation"] == "STEP" ? 1 : 0;
    const auto& input = gltf["accessors"][sampler["input"].get<std::size_t>()];
    const auto& output = gltf["accessors"][sampler["output"].get<std::size_t>()];
    CHECK(input["count"] == output["count"]);
    CHECK(output["type"] == "VEC3");
  }
  CHECK(steps == 6);
}

TEST_CASE("animations are refused for formats without them") {
  const test::ScratchFile file("", ".obj");
  const auto writer = open_scene(file.path(), SceneFormat::kObj, {});
  CHECK_THROWS_AS(writer->animate("t", {}, {}, ""), UsageError);
}

TEST_CASE("a tree that is new after several years grows up during all of them") {
  const Moments all = read_moments(growth_table("year,plot,tree,x,y,dbh,h,hcb,cw\n"
                                                "2010,1,1,0,0,10,10,4,2\n"
                                                "2015,1,1,0,0,11,11,4,2\n"
                                                "2015,1,2,5,0,10,10,4,2\n"),
                                   "year",
                                   {});
  const std::vector<GrowingTree> trees = growing_trees(all.moments);
  const auto late = animated(trees[1], all.moments, numbered(trees[1]), {});
  CHECK(shown_at(late[0], 0.1) == 1.0);
  REQUIRE(late[0].size.size() == 2);
  CHECK(late[0].size[0].time_s == 0.0);
  CHECK(late[0].size[1].time_s == 5.0);
}

TEST_CASE("times that single precision cannot represent are refused") {
  const auto animate = [](const std::string& second, const std::string& third, const Pace& pace) {
    const std::string tree = ",1,1,0,0,10,";
    const Moments all =
        read_moments(growth_table("t,plot,tree,x,y,dbh,h,hcb,cw\n0" + tree + "10,4,2\n" + second +
                                  tree + "11,4,2\n" + third + tree + "12,4,2\n"),
                     "t",
                     {});
    const std::vector<GrowingTree> trees = growing_trees(all.moments);
    return animated(trees[0], all.moments, numbered(trees[0]), pace);
  };
  CHECK_NOTHROW(animate("1", "2", {}));
  // Floats are whole numbers up to 2^24 = 16777216, and even ones from there on.
  CHECK_NOTHROW(animate("16777213", "16777214", {}));
  CHECK_THROWS_AS(animate("16777216", "16777217", {}), UsageError);
  CHECK_THROWS_AS(animate("1000000000", "1000000001", {}), UsageError);
  // Floats end at 3.4e38, and below 1e-45 all are 0.
  CHECK_THROWS_AS(animate("1", "2", {.seconds_per_unit = 1e39}), UsageError);
  CHECK_THROWS_AS(animate("1", "2", {.seconds_per_unit = 1e-50}), UsageError);
  CHECK_THROWS_AS(animate("1e39", "2e39", {}), UsageError);
  CHECK_THROWS_AS(animate("1e308", "1.5e308", {.seconds_per_unit = 100.0}), UsageError);
}
