// SPDX-License-Identifier: MIT
#include "silvafit/tree/packed_glb.hpp"

#include <zlib.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>

#include "silvafit/base/error.hpp"
#include "silvafit/tree/scene.hpp"
#include "silvafit/tree/scene_reader.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;
using nlohmann::json;

namespace {

std::size_t length_at(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof(word));
  return word;
}

json description_in(const std::string& glb) {
  return json::parse(glb.substr(20, length_at(glb, 12)));
}

std::string buffer_in(const std::string& glb) { return glb.substr(28 + length_at(glb, 12)); }

std::string with_buffer(const json& description, const std::string& buffer) {
  std::string text = description.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto word = [](std::size_t value) {
    const auto narrow = static_cast<std::uint32_t>(value);
    std::string bytes(4, '\0');
    std::memcpy(bytes.data(), &narrow, 4);
    return bytes;
  };
  return "glTF" + word(2) + word(28 + text.size() + buffer.size()) + word(text.size()) + "JSON" +
         text + word(buffer.size()) + std::string("BIN\0", 4) + buffer;
}

/// A tree with pictures and normal maps.
std::string textured_tree() {
  test::Scene scene;
  scene.trees.push_back(grow_tree(test::paper_tree_1(),
                                  test::shipped_presets().named("schima-superba"),
                                  {.mesh = level_of_detail(2, {.textured = true})}));
  return test::glb_bytes(scene);
}

/// Corners of all triangles of a part: positions, directions, texture coordinates, in an order that
/// depends on the positions only.
using Corner = std::array<double, 8>;
std::vector<Corner> corners_in(const MeshPart& mesh) {
  std::vector<Corner> corners;
  for (const std::uint32_t i : mesh.indices) {
    Corner corner{};
    const double length =
        std::hypot(mesh.normals[3 * i], mesh.normals[3 * i + 1], mesh.normals[3 * i + 2]);
    for (std::size_t k = 0; k < 3; ++k) {
      corner.at(k) = mesh.positions[3 * i + k];
      corner.at(3 + k) = mesh.normals[3 * i + k] / length;
    }
    for (std::size_t k = 0; k < 2; ++k) corner.at(6 + k) = mesh.uvs[2 * i + k];
    corners.push_back(corner);
  }
  return corners;
}

/// Whether each corner has one in the other list within the given distances.
bool has_all(const std::vector<Corner>& corners,
             std::vector<Corner> among,
             double meters,
             double degrees,
             double of_picture) {
  std::ranges::sort(among);
  const double least_cosine = std::cos(degrees * std::numbers::pi / 180.0);
  return std::ranges::all_of(corners, [&](const Corner& own) {
    auto other = std::ranges::lower_bound(among, Corner{own[0] - meters});
    for (; other != among.end() && (*other)[0] <= own[0] + meters; ++other) {
      const double cosine = own[3] * (*other)[3] + own[4] * (*other)[4] + own[5] * (*other)[5];
      if (std::abs(own[1] - (*other)[1]) <= meters && std::abs(own[2] - (*other)[2]) <= meters &&
          std::abs(own[6] - (*other)[6]) <= of_picture &&
          std::abs(own[7] - (*other)[7]) <= of_picture && cosine >= least_cosine) {
        return true;
      }
    }
    return false;
  });
}

}  // namespace

TEST_CASE("a packed scene has the same corners and pictures within its steps") {
  const std::string glb = textured_tree();
  const std::string packed = packed_glb(glb);
  CHECK(packed.size() < glb.size());
  const ReadScene before = read_glb(glb);
  const ReadScene after = read_glb(packed);
  REQUIRE(after.models.size() == before.models.size());
  const std::vector<ReadPart>& parts = after.models[0].parts;
  REQUIRE(parts.size() == before.models[0].parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const ReadPart& own = before.models[0].parts[i];
    CHECK(parts[i].part == own.part);
    CHECK(parts[i].mesh.texture->rgba == own.mesh.texture->rgba);
    CHECK(parts[i].mesh.triangle_count() == own.mesh.triangle_count());
    CHECK(parts[i].mesh.colors.size() == own.mesh.colors.size());
    CHECK(parts[i].mesh.tangents.size() == own.mesh.tangents.size());
    // A tree of 20.2 m: half a step of 20.2 m / 32768, and that of a picture, beside the rounding
    // of floats. Octahedral coordinates of 8 bits are within 0.9 degrees (half of 1/127 in both,
    // three times as far on the sphere where the faces meet); signed bytes add sqrt(3)/2/127, 0.4
    // degrees.
    CHECK(has_all(corners_in(own.mesh), corners_in(parts[i].mesh), 3.2e-4, 1.3, 1.3e-4));
  }
}

TEST_CASE("a packed scene keeps names, extras, materials and pictures") {
  const std::string glb = textured_tree();
  const json before = description_in(glb);
  const json after = description_in(packed_glb(glb));
  for (const char* list : {"nodes", "scenes", "materials", "textures", "meshes", "samplers"}) {
    CHECK(after[list] == before[list]);
  }
  CHECK(after["images"].size() == before["images"].size());
  // Bounds of positions are required.
  for (const json& mesh : after["meshes"]) {
    for (const json& primitive : mesh["primitives"]) {
      const auto positions = primitive["attributes"]["POSITION"].get<std::size_t>();
      const json& own = before["accessors"][positions];
      for (std::size_t k = 0; k < 3; ++k) {
        for (const char* bound : {"min", "max"}) {
          CHECK(after["accessors"][positions][bound][k].get<double>() ==
                Approx(own[bound][k].get<double>()).margin(3.2e-4));
        }
      }
    }
  }
}

TEST_CASE("packed scenes, small ones and those with unknown extensions do not change") {
  const std::string glb = textured_tree();
  const std::string packed = packed_glb(glb);
  CHECK(packed_glb(packed) == packed);
  json description = description_in(glb);
  description["extensionsUsed"] = {"EXAMPLE_refers_to_vertices"};
  const std::string unknown = with_buffer(description, buffer_in(glb));
  CHECK(packed_glb(unknown) == unknown);
  // The description of compressed bytes is longer than one triangle.
  const std::array<float, 9> positions{0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::string bytes(sizeof(positions), '\0');
  std::memcpy(bytes.data(), positions.data(), sizeof(positions));
  const json triangle = json::parse(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36}]})");
  const std::string small = with_buffer(triangle, bytes);
  CHECK(packed_glb(small) == small);
}

TEST_CASE("vertices of several primitives, morph targets and animations are kept") {
  // A strip of 3000 triangles that two primitives share; the second has a morph target.
  constexpr std::uint32_t kVertices = 3002;
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < kVertices; ++i) {
    for (const float value : {0.01F * static_cast<float>(i), static_cast<float>(i % 2), 0.25F}) {
      positions.push_back(value);
    }
    if (i + 2 < kVertices) indices.insert(indices.end(), {i, i + 1, i + 2});
  }
  std::string bytes(4 * (positions.size() + indices.size()), '\0');
  std::memcpy(bytes.data(), positions.data(), 4 * positions.size());
  std::memcpy(bytes.data() + 4 * positions.size(), indices.data(), 4 * indices.size());
  json gltf = json::parse(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}], "accessors": [
      {"bufferView": 0, "componentType": 5126, "count": 3002, "type": "VEC3"},
      {"bufferView": 1, "componentType": 5125, "count": 9000, "type": "SCALAR"}]})");
  gltf["meshes"] = json::parse(R"([{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1},
    {"attributes": {"POSITION": 0}, "indices": 1}]}])");
  gltf["bufferViews"] = {
      {{"buffer", 0}, {"byteLength", 4 * positions.size()}},
      {{"buffer", 0}, {"byteOffset", 4 * positions.size()}, {"byteLength", 4 * indices.size()}}};
  gltf["buffers"] = {{{"byteLength", bytes.size()}}};
  const std::string shared = with_buffer(gltf, bytes);
  const std::string packed = packed_glb(shared);
  CHECK(packed.size() < shared.size() / 2);
  const ReadScene scene = read_glb(packed);
  // The order of triangles and vertices stays where primitives share them. The last position is
  // 30.01 m from the first: half a step of 30.01 m / 32768.
  for (const ReadPart& part : scene.models.at(0).parts) {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      REQUIRE(double{part.mesh.positions[i]} == Approx(double{positions[i]}).margin(4.6e-4));
    }
  }
  gltf["meshes"][0]["primitives"][1]["targets"] = {{{"POSITION", 0}}};
  gltf["meshes"][0]["primitives"][0].erase("indices");
  const json kept = description_in(packed_glb(with_buffer(gltf, bytes)));
  CHECK(kept["accessors"] == gltf["accessors"]);
}

TEST_CASE("deflated bytes are those of zlib") {
  const std::string bytes(10000, 'a');
  const std::string small = deflated(bytes);
  CHECK(small.size() < 100);
  std::string again(bytes.size(), '\0');
  uLongf size = again.size();
  REQUIRE(uncompress(reinterpret_cast<Bytef*>(again.data()),
                     &size,
                     reinterpret_cast<const Bytef*>(small.data()),
                     small.size()) == Z_OK);
  CHECK(size == bytes.size());
  CHECK(again == bytes);
}
