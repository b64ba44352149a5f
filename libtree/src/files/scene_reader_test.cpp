// SPDX-License-Identifier: MIT
// Small files whose declared sizes exceed their content.
#include "silvafit/tree/scene_reader.hpp"

#include <meshoptimizer.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "silvafit/base/error.hpp"

using namespace silvafit;
using namespace silvafit::tree;
using nlohmann::json;

namespace {

/// Three positions and three indices.
std::string triangle_bytes() {
  const std::array<float, 9> positions{0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::array<std::uint32_t, 3> indices{0, 1, 2};
  std::string bytes(sizeof(positions) + sizeof(indices), '\0');
  std::memcpy(bytes.data(), positions.data(), sizeof(positions));
  std::memcpy(bytes.data() + sizeof(positions), indices.data(), sizeof(indices));
  return bytes;
}

json triangle() {
  return json::parse(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36},
                    {"buffer": 0, "byteOffset": 36, "byteLength": 12}],
    "buffers": [{"byteLength": 48}]})");
}

std::string word(std::size_t value) {
  const auto narrow = static_cast<std::uint32_t>(value);
  std::string bytes(4, '\0');
  std::memcpy(bytes.data(), &narrow, 4);
  return bytes;
}

std::string glb(const json& description, const std::string& buffer = triangle_bytes()) {
  std::string text = description.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  return "glTF" + word(2) + word(28 + text.size() + buffer.size()) + word(text.size()) + "JSON" +
         text + word(buffer.size()) + std::string("BIN\0", 4) + buffer;
}

json packed(std::size_t bytes, std::size_t stride, std::size_t count, const char* mode) {
  return {{"buffer", 0},
          {"byteLength", bytes},
          {"extensions",
           {{"EXT_meshopt_compression",
             {{"buffer", 0},
              {"byteLength", bytes},
              {"byteStride", stride},
              {"count", count},
              {"mode", mode}}}}}};
}

}  // namespace

TEST_CASE("a triangle is read") {
  const ReadScene scene = read_glb(glb(triangle()));
  CHECK(scene.triangle_count() == 1);
}

TEST_CASE("numbers of a file whose products are too large are refused") {
  json wide = triangle();
  wide["bufferViews"][0]["byteStride"] = std::uint64_t{1} << 48U;
  wide["accessors"][0]["count"] = 65537;  // (count - 1) stride = 2^64
  CHECK_THROWS_AS(read_glb(glb(wide)), InputError);

  json long_row = triangle();
  long_row["bufferViews"][0]["byteStride"] = 256;  // glTF has 252 at most
  CHECK_THROWS_AS(read_glb(glb(long_row)), InputError);

  json many = triangle();
  many["accessors"][0]["count"] = 4;
  CHECK_THROWS_AS(read_glb(glb(many)), InputError);

  json late = triangle();
  late["accessors"][0]["byteOffset"] = 33;  // a row less one byte
  CHECK_THROWS_AS(read_glb(glb(late)), InputError);
  late["accessors"][0]["byteOffset"] = std::numeric_limits<std::uint64_t>::max();
  CHECK_THROWS_AS(read_glb(glb(late)), InputError);
}

TEST_CASE("packed bytes must be sufficient for the declared size") {
  // 256 times 2^31 bytes from 36.
  json bomb = triangle();
  bomb["bufferViews"][0] = packed(36, 256, std::size_t{1} << 31U, "ATTRIBUTES");
  CHECK_THROWS_AS(read_glb(glb(bomb)), InputError);
  // So many that a product of 64 bits overflows.
  bomb["bufferViews"][0] = packed(36, 256, std::size_t{1} << 56U, "ATTRIBUTES");
  CHECK_THROWS_AS(read_glb(glb(bomb)), InputError);
  bomb["bufferViews"][0] = packed(36, 4, 3 * (std::size_t{1} << 29U), "TRIANGLES");
  CHECK_THROWS_AS(read_glb(glb(bomb)), InputError);
}

TEST_CASE("equal vertices, which have the best compression, are unpacked") {
  constexpr std::size_t kVertices = 300'000;
  const std::vector<float> same(3 * kVertices, 0.5F);
  std::string buffer(meshopt_encodeVertexBufferBound(kVertices, 12), '\0');
  meshopt_encodeVertexVersion(0);
  buffer.resize(meshopt_encodeVertexBuffer(
      reinterpret_cast<unsigned char*>(buffer.data()), buffer.size(), same.data(), kVertices, 12));
  json scene = triangle();
  scene["bufferViews"] = json::array({packed(buffer.size(), 12, kVertices, "ATTRIBUTES")});
  scene["meshes"][0]["primitives"][0].erase("indices");
  scene["accessors"][0]["count"] = kVertices;
  // The best possible compression: close to the bound of 64 to 1.
  REQUIRE(12 * kVertices > 60 * buffer.size());
  buffer.resize((buffer.size() + 3) / 4 * 4);
  CHECK(read_glb(glb(scene, buffer)).models[0].parts[0].mesh.positions == same);
}

TEST_CASE("a node has one parent") {
  json twice = triangle();
  twice["scenes"][0]["nodes"] = {0, 0};
  CHECK_THROWS_AS(read_glb(glb(twice)), InputError);
  // Each node has the next one as a child twice: 2^30 triangles.
  json bomb = triangle();
  bomb["nodes"] = json::array();
  for (int node = 0; node < 30; ++node) {
    bomb["nodes"].push_back({{"children", {node + 1, node + 1}}});
  }
  bomb["nodes"].push_back({{"mesh", 0}});
  CHECK_THROWS_AS(read_glb(glb(bomb)), InputError);
  json circle = triangle();
  circle["nodes"][0]["children"] = {0};
  CHECK_THROWS_AS(read_glb(glb(circle)), InputError);
}

TEST_CASE("a small file cannot refer to its bytes so often that memory is exhausted") {
  // 20,000 parts of the same 100,000 bytes would be 16 GB of numbers.
  const std::string buffer(100'000, '\0');
  json scene = triangle();
  scene["bufferViews"] = json::array({{{"buffer", 0}, {"byteLength", buffer.size()}}});
  scene["accessors"] = json::array(
      {{{"bufferView", 0}, {"componentType", 5121}, {"count", 33'333}, {"type", "VEC3"}}});
  scene["meshes"][0]["primitives"] = json::array();
  for (int part = 0; part < 20'000; ++part) {
    scene["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}});
  }
  CHECK_THROWS_AS(read_glb(glb(scene, buffer)), InputError);
  // Parts may share them.
  auto& parts = scene["meshes"][0]["primitives"].get_ref<json::array_t&>();
  parts.resize(20);
  CHECK(read_glb(glb(scene, buffer)).triangle_count() == std::size_t{20} * 11'111);
}

TEST_CASE("nodes with scale 0 are skipped, for any form of the transformation") {
  json scene = triangle();
  for (const json& node : {json{{"mesh", 0}, {"matrix", std::vector<int>(16, 0)}},
                           json{{"mesh", 0}, {"scale", {0, 0, 0}}}}) {
    scene["nodes"][0] = node;
    CHECK(read_glb(glb(scene)).instances.empty());
  }
  scene["nodes"][0] = {{"mesh", 0}, {"scale", {1e300, 1, 1}}};
  CHECK_THROWS_AS(read_glb(glb(scene)), InputError);
}

TEST_CASE("a picture in a separate file is refused with its name") {
  json scene = triangle();
  scene["images"] = json::array({{{"uri", "bark.jpg"}}});
  scene["textures"] = json::array({{{"source", 0}}});
  scene["materials"] =
      json::array({{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}});
  scene["meshes"][0]["primitives"][0]["material"] = 0;
  CHECK_THROWS_WITH(read_glb(glb(scene)), Catch::Contains("bark.jpg"));
  scene["materials"] = json::array({{{"normalTexture", {{"index", 0}}}}});
  CHECK_THROWS_WITH(read_glb(glb(scene)), Catch::Contains("bark.jpg"));
}

TEST_CASE("transformations to a plane, a line or a point are recognized as flattening") {
  std::array<double, 16> transform{2, 0, 0, 0, 0, -3, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1};
  CHECK_FALSE(is_flattened(transform));
  for (const std::size_t k : {std::size_t{0}, std::size_t{5}, std::size_t{10}}) {
    std::array<double, 16> flat = transform;
    flat[k] = 0.0;
    CHECK(is_flattened(flat));
  }
  transform[0] = std::nan("");
  CHECK(is_flattened(transform));
}
