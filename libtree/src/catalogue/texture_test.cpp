// SPDX-License-Identifier: MIT
#include "silvafit/tree/texture.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <sstream>

#include "catalogue/leafy_shoots_entry.hpp"
#include "scratch_file.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/tree/scene_reader.hpp"
#include "silvafit/tree/scene_writer.hpp"
#include "silvafit/tree/texture_library.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

/// All pictures of a folder of models/.
template <typename Picture>
std::vector<std::shared_ptr<const Picture>> shipped(
    const char* folder, std::shared_ptr<const Picture> (*load)(const std::filesystem::path&)) {
  std::vector<std::shared_ptr<const Picture>> pictures;
  for (const auto& file : files_in_folder(test::source_file("models") / folder, ".json")) {
    pictures.push_back(load(file));
  }
  REQUIRE(pictures.size() >= 10);
  return pictures;
}
const auto& barks() {
  static const auto all = shipped("bark", bark_picture);
  return all;
}
const auto& shoots() {
  static const auto all = shipped("shoots", shoot_picture);
  return all;
}

double linear(std::uint8_t srgb) {
  const double c = srgb / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

/// Mean difference between the pixels of two columns, or two rows.
double step_between(const Texture& texture, std::size_t a, std::size_t b, bool columns) {
  double sum = 0.0;
  const std::size_t length = columns ? texture.height : texture.width;
  for (std::size_t i = 0; i < length; ++i) {
    const auto value = [&](std::size_t line) {
      const std::size_t x = columns ? line : i;
      const std::size_t y = columns ? i : line;
      return double{linear(texture.rgba[4 * (y * texture.width + x)])};
    };
    sum += std::abs(value(a) - value(b));
  }
  return sum / static_cast<double>(length);
}

SceneTree textured_tree(const char* preset) {
  return grow_tree(
      test::paper_tree_1(), test::shipped_presets().named(preset), {.mesh = {.textured = true}});
}

}  // namespace

TEST_CASE("a texture read back from its PNG is unchanged") {
  Texture texture{.name = "noise", .width = 8, .height = 4};
  for (int i = 0; i < 128; ++i) texture.rgba.push_back(static_cast<std::uint8_t>(37 * i + 11));
  const std::string bytes = png_bytes(texture);
  CHECK(bytes.substr(1, 3) == "PNG");
  const Texture read = texture_from_png(bytes, "noise");
  CHECK(read.width == 8);
  CHECK(read.height == 4);
  CHECK(read.rgba == texture.rgba);
  CHECK(png_bytes(texture) == bytes);
  texture.rgba.pop_back();
  CHECK_THROWS_AS(png_bytes(texture), UsageError);
  CHECK_THROWS_AS(png_bytes(Texture{}), UsageError);
  CHECK_THROWS_AS(texture_from_png(bytes.substr(0, bytes.size() / 2), "half"), InputError);
  CHECK_THROWS_AS(texture_from_png("no picture", "none"), InputError);
}

TEST_CASE("pictures of bark are seamless at all edges") {
  for (const auto& picture : barks()) {
    const Texture& bark = *picture->color();
    INFO(bark.name);
    REQUIRE(bark.width == 256);
    REQUIRE(bark.height == 512);
    CHECK_FALSE(has_transparency(bark));
    for (const bool columns : {true, false}) {
      double inside = 0.0;
      double largest = 0.0;
      const std::size_t lines = columns ? bark.width : bark.height;
      for (std::size_t i = 0; i + 1 < lines; ++i) {
        const double step = step_between(bark, i, i + 1, columns);
        inside += step / static_cast<double>(lines - 1);
        largest = std::max(largest, step);
      }
      // The difference across the edge is not larger than the largest one inside.
      CHECK(step_between(bark, lines - 1, 0, columns) <= largest);
      CHECK(inside > 0.0);
    }
  }
}

TEST_CASE("pictures keep the brightness of the colors that they are multiplied with") {
  for (const auto& picture : barks()) {
    const Texture& bark = *picture->color();
    double sum = 0.0;
    for (std::size_t i = 0; i < bark.rgba.size(); i += 4) sum += linear(bark.rgba[i]);
    INFO(bark.name);
    // Bytes round evenly; brightness above white is cut off.
    CHECK(4.0 * sum / static_cast<double>(bark.rgba.size()) == Approx(0.6).margin(0.02));
  }
  for (const auto& picture : shoots()) {
    const Texture& leaf = *picture->leafy().color;
    double sum = 0.0;
    double cover = 0.0;
    for (std::size_t i = 0; i < leaf.rgba.size(); i += 4) {
      sum += leaf.rgba[i + 3] * linear(leaf.rgba[i + 1]);
      cover += leaf.rgba[i + 3];
    }
    INFO(leaf.name);
    CHECK(has_transparency(leaf));
    CHECK(sum / cover == Approx(0.8).margin(0.02));
    const double share = cover / (255.0 * static_cast<double>(leaf.width * leaf.height));
    // Leaves overlap, but by at most half of their area. Opacity is stored in bytes.
    CHECK(picture->leafy().covered > share - 0.002);
    CHECK(picture->leafy().covered < 2.0 * share);
    CHECK(share > 0.15);
    CHECK(share < 0.8);
  }
  CHECK(barks().front()->color() == barks().front()->color());
}

TEST_CASE("a shoot begins in the middle of the lower edge, and is inside its quarter") {
  for (const auto& picture : shoots()) {
    INFO(picture->name());
    const Texture& atlas = *picture->leafy().color;
    REQUIRE(atlas.width == 1024);
    REQUIRE(atlas.height == 1024);
    const auto opacity_at = [&](std::size_t x, std::size_t y) {
      return int{atlas.rgba[4 * (y * atlas.width + x) + 3]};
    };
    for (std::size_t k = 0; k < kShootsPerAtlas; ++k) {
      const std::size_t left = k % 2 * 512;
      const std::size_t top = k / 2 * 512;
      int at_base = 0;
      for (std::size_t x = left + 240; x < left + 272; ++x) {
        for (std::size_t y = top + 490; y < top + 512; ++y) {
          at_base = std::max(at_base, opacity_at(x, y));
        }
      }
      CHECK(at_base == 255);
      // Few leaves are cut by the edge of a quarter.
      int on_edge = 0;
      for (std::size_t i = 0; i < 512; ++i) {
        on_edge += opacity_at(left, top + i) > 127;
        on_edge += opacity_at(left + 511, top + i) > 127;
        on_edge += opacity_at(left + i, top) > 127;
      }
      CHECK(on_edge < 60);
    }
    // On the average the normals point out of the picture.
    const Texture& normals = *picture->leafy().normals;
    REQUIRE(normals.rgba.size() == atlas.rgba.size());
    double mean = 0.0;
    for (std::size_t i = 2; i < normals.rgba.size(); i += 4) mean += normals.rgba[i];
    CHECK(4.0 * mean / static_cast<double>(normals.rgba.size()) > 230.0);
  }
}

TEST_CASE("a GLB stores each picture once, and it is read back unchanged") {
  test::Scene scene;
  scene.trees = {textured_tree("cunninghamia-lanceolata"), textured_tree("generic-conifer")};
  const ReadScene read = read_glb(test::glb_bytes(scene));
  REQUIRE(read.models.size() == 2);
  std::set<const Texture*> pictures;
  for (std::size_t i = 0; i < 2; ++i) {
    const Preset& preset =
        test::shipped_presets().named(i == 0 ? "cunninghamia-lanceolata" : "generic-conifer");
    const ShootAtlas& atlas = preset.leafy_shoots.picture->leafy();
    for (const ReadPart& part : read.models[i].parts) {
      REQUIRE(part.mesh.texture != nullptr);
      REQUIRE(part.mesh.normal_texture != nullptr);
      const bool is_leaf = part.mesh.kind == PartKind::kFoliage;
      const Texture& color = is_leaf ? *atlas.color : *preset.bark.picture->color();
      const Texture& normals = is_leaf ? *atlas.normals : *preset.bark.picture->normals();
      CHECK(part.mesh.texture->rgba == color.rgba);
      CHECK(part.mesh.texture->name == color.name);
      CHECK(part.mesh.normal_texture->rgba == normals.rgba);
      CHECK(part.mesh.uvs.size() == 2 * part.mesh.vertex_count());
      CHECK(part.mesh.tangents.size() == 4 * part.mesh.vertex_count());
      CHECK(part.mesh.colors.empty() == !is_leaf);
      pictures.insert(part.mesh.texture.get());
      pictures.insert(part.mesh.normal_texture.get());
    }
  }
  CHECK(pictures.size() == 8);
  const std::string bytes = test::glb_bytes(scene);
  CHECK(bytes.find("\"alphaMode\":\"MASK\"") != std::string::npos);
  CHECK(bytes.find("\"name\":\"generic-conifer-leaf\"") != std::string::npos);
}

TEST_CASE("files of trees without textures have no images") {
  test::Scene scene;
  scene.trees = {
      grow_tree(test::paper_tree_1(), test::shipped_presets().named("generic-broadleaf"))};
  const std::string bytes = test::glb_bytes(scene);
  for (const char* word :
       {"textures", "images", "samplers", "alphaMode", "baseColorTexture", "TEXCOORD", "TANGENT"}) {
    CHECK(bytes.find(word) == std::string::npos);
  }
}

TEST_CASE("OBJ refers to its pictures in the same folder") {
  const test::ScratchFile file("", ".obj");
  const auto writer = open_scene(file.path(), SceneFormat::kObj);
  writer->add_tree(textured_tree("schima-superba"));
  writer->finish();
  std::filesystem::path materials = file.path();
  materials.replace_extension(".mtl");
  const std::string text = read_file(materials);
  const std::string stem = materials.stem().string();
  const std::string leaf = stem + "-shoots-alternate.png";
  CHECK(text.find("map_Kd " + stem + "-bark-smooth.png\n") != std::string::npos);
  CHECK(text.find("map_Kd " + leaf + "\nmap_d " + leaf + "\n") != std::string::npos);
  CHECK(texture_from_png(read_file(file.path().parent_path() / leaf), "leaf").rgba ==
        test::shipped_presets().named("schima-superba").leafy_shoots.picture->leafy().color->rgba);
  for (const std::string& name : {leaf, stem + "-bark-smooth.png", stem + ".mtl"}) {
    std::filesystem::remove(file.path().parent_path() / name);
  }
}

TEST_CASE("an OBJ whose name has blanks refers to existing materials and pictures") {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "silvafit obj test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const auto writer = open_scene(folder / "my scene.obj", SceneFormat::kObj);
  writer->add_tree(textured_tree("schima-superba"));
  writer->finish();
  // The names in the OBJ and its materials, up to the end of the line, are those of the files.
  std::set<std::filesystem::path> named;
  const auto collect = [&](const std::filesystem::path& path, const std::string& word) {
    std::istringstream lines(read_file(path));
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with(word + " ")) named.insert(folder / line.substr(word.size() + 1));
    }
  };
  collect(folder / "my scene.obj", "mtllib");
  REQUIRE(named.size() == 1);
  CHECK(named.begin()->filename() == "my_scene.mtl");
  const std::filesystem::path materials = *named.begin();
  REQUIRE(std::filesystem::exists(materials));
  collect(materials, "map_Kd");
  collect(materials, "map_d");
  CHECK(named.size() == 3);
  for (const std::filesystem::path& path : named) CHECK(std::filesystem::exists(path));
  const std::vector<std::filesystem::path> others = writer->other_files();
  CHECK(std::set(others.begin(), others.end()) == named);
  std::filesystem::remove_all(folder);
}

TEST_CASE("the twigs of a shoot without leaves are where they are below the leaves") {
  for (const auto& picture : shoots()) {
    INFO(picture->name());
    const Texture& leafy = *picture->leafy().color;
    const Texture& bare = *picture->bare().color;
    REQUIRE(bare.rgba.size() == leafy.rgba.size());
    std::size_t twigs = 0;
    std::size_t outside = 0;
    std::size_t leaves = 0;
    for (std::size_t i = 3; i < bare.rgba.size(); i += 4) {
      const bool is_twig = bare.rgba[i] > 127;
      twigs += is_twig ? 1U : 0U;
      leaves += leafy.rgba[i] > 127 ? 1U : 0U;
      outside += is_twig && leafy.rgba[i] <= 127 ? 1U : 0U;
    }
    CHECK(twigs > 0);
    CHECK(outside == 0);
    CHECK(2 * twigs < leaves);
    CHECK(picture->bare().covered == 0.0);
  }
}
