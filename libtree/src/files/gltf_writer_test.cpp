// SPDX-License-Identifier: MIT
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/scene.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;
using nlohmann::json;

namespace {

std::uint32_t word_at(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof(word));
  return word;
}

json description_of(const std::string& glb) {
  return json::parse(glb.substr(20, word_at(glb, 12)));
}

test::Scene two_trees() {
  test::Scene scene;
  Morphology tree = test::paper_tree_1();
  tree.position = {12.5, 30.25, 101.5};
  scene.trees.push_back(grow_tree(tree, test::shipped_presets().named("cunninghamia-lanceolata")));
  tree.tree = "2 \"b\"";
  tree.position = {-3.0, -4.0, 99.0};
  tree.hc_m.reset();
  scene.trees.push_back(grow_tree(tree, test::shipped_presets().named("schima-superba")));
  return scene;
}

}  // namespace

TEST_CASE("a GLB has its header, and the sizes of its parts sum to its length") {
  const std::string glb = test::glb_bytes(two_trees());
  CHECK(glb.substr(0, 4) == "glTF");
  CHECK(word_at(glb, 4) == 2);
  CHECK(word_at(glb, 8) == glb.size());
  const std::size_t binary = 20 + word_at(glb, 12);
  CHECK(glb.substr(binary + 4, 3) == "BIN");
  CHECK(binary + 8 + word_at(glb, binary) == glb.size());
}

TEST_CASE("trees have the positions of the inventory, y up, and their measurements") {
  const json gltf = description_of(test::glb_bytes(two_trees()));
  REQUIRE(gltf["nodes"].size() == 2);
  CHECK(gltf["scenes"][0]["nodes"] == json({0, 1}));
  const json& node = gltf["nodes"][0];
  CHECK(node["name"] == "1-1");
  CHECK(gltf["meshes"][0]["name"] == "1-1");
  CHECK(gltf["nodes"][1]["name"] == "1-2 \"b\"");
  CHECK(node["translation"] == json({12.5, 101.5, -30.25}));
  const json& extras = node["extras"];
  // Floats resolve these to about a micrometer.
  CHECK(extras["h"].get<double>() == Approx(20.2).margin(1e-5));
  CHECK(extras["hcb"].get<double>() == Approx(5.8).margin(1e-5));
  CHECK(extras["dbh"].get<double>() == Approx(28.1).margin(1e-5));
  CHECK(extras["radii"]["s"].get<double>() == Approx(1.5).margin(1e-5));
  CHECK(extras["species"] == "Cunninghamia lanceolata");
  CHECK_FALSE(extras.contains("notes"));
  CHECK(gltf["nodes"][1]["extras"]["notes"].size() == 1);
}

TEST_CASE("the crown's extent in the file is east +x, north -z") {
  const json gltf = description_of(test::glb_bytes(two_trees()));
  // The second primitive is the branches.
  const json& primitive = gltf["meshes"][0]["primitives"][1];
  const json& accessor = gltf["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
  CHECK(accessor["max"][0].get<double>() == Approx(2.1).margin(0.01));
  CHECK(accessor["min"][0].get<double>() == Approx(-2.5).margin(0.01));
  CHECK(accessor["max"][2].get<double>() == Approx(1.5).margin(0.01));
  CHECK(accessor["min"][2].get<double>() == Approx(-2.4).margin(0.01));
  CHECK(accessor["min"][1].get<double>() == Approx(5.8).margin(0.01));
}

TEST_CASE("the same trees give the same bytes") {
  CHECK(test::glb_bytes(two_trees()) == test::glb_bytes(two_trees()));
  CHECK_THROWS_AS(test::glb_bytes({}), GeometryError);
}

TEST_CASE("large coordinates move the scene's origin, small ones do not") {
  std::vector<Morphology> trees(2, test::paper_tree_1());
  trees[0].position = {120, 80, 7000};
  CHECK(scene_origin(trees).x_m == 0.0);
  trees[0].position = {512345.6, 3012345.6, 120};
  trees[1].position = {512395.6, 3012305.6, 118};
  const Position origin = scene_origin(trees);
  CHECK(origin.x_m == 512300.0);
  CHECK(origin.y_m == 3012300.0);
  CHECK(origin.z_m == 0.0);
}
