// SPDX-License-Identifier: MIT
#include "files/packed_part.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>

namespace silvafit::tree {
namespace {

constexpr double kLargestShort = 32767.0;

template <typename Value>
void put(std::vector<std::uint8_t>& bytes, std::size_t at, Value value) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
}

template <typename From>
PackedStream copied(const char* attribute,
                    ComponentType component,
                    int components,
                    const std::vector<From>& values) {
  PackedStream stream{.attribute = attribute, .component = component, .components = components};
  stream.stride = sizeof(From) * static_cast<std::size_t>(components);
  stream.bytes.resize(values.size() * sizeof(From));
  std::memcpy(stream.bytes.data(), values.data(), stream.bytes.size());
  stream.count = stream.bytes.size() / stream.stride;
  return stream;
}

PackedStream positions_in_steps(const std::vector<float>& positions, double step_m) {
  PackedStream stream{
      .attribute = "POSITION", .component = ComponentType::kShort, .components = 3, .stride = 8};
  stream.count = positions.size() / 3;
  stream.bytes.resize(stream.count * stream.stride);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double steps = std::clamp(double{positions[i]} / step_m, -kLargestShort, kLargestShort);
    put(stream.bytes, i / 3 * 8 + i % 3 * 2, static_cast<std::int16_t>(std::lround(steps)));
  }
  return stream;
}

/// Normals or tangents in signed bytes; the fourth of a normal is 0.
PackedStream directions_in_bytes(const char* attribute,
                                 std::size_t width,
                                 const std::vector<float>& values) {
  PackedStream stream{.attribute = attribute,
                      .component = ComponentType::kByte,
                      .components = static_cast<int>(width),
                      .normalized = true,
                      .stride = 4};
  stream.count = values.size() / width;
  stream.bytes.resize(stream.count * 4);
  for (std::size_t i = 0; i < values.size(); ++i) {
    constexpr double kLargestByte = 127.0;
    put(stream.bytes,
        i / width * 4 + i % width,
        static_cast<std::int8_t>(std::lround(kLargestByte * double{values[i]})));
  }
  return stream;
}

PackedStream uvs_in_shorts(const std::vector<float>& uvs) {
  PackedStream stream{.attribute = "TEXCOORD_0",
                      .component = ComponentType::kUshort,
                      .components = 2,
                      .normalized = true,
                      .stride = 4};
  stream.count = uvs.size() / 2;
  stream.bytes.resize(uvs.size() * 2);
  for (std::size_t i = 0; i < uvs.size(); ++i) {
    put(stream.bytes, 2 * i, static_cast<std::uint16_t>(std::lround(65535.0 * double{uvs[i]})));
  }
  return stream;
}

/// Two bytes per index if they suffice; the largest value of each type is reserved.
PackedStream indices_of(const std::vector<std::uint32_t>& indices, std::size_t vertices) {
  if (vertices >= std::numeric_limits<std::uint16_t>::max()) {
    return copied("", ComponentType::kUint, 1, indices);
  }
  const std::vector<std::uint16_t> narrow(indices.begin(), indices.end());
  return copied("", ComponentType::kUshort, 1, narrow);
}

bool has_picture(const MeshPart& part) { return part.texture != nullptr && !part.uvs.empty(); }

/// Tangents are for normal maps.
bool has_tangents(const MeshPart& part, bool is_packed) {
  return has_normal_map(part, is_packed) && !part.tangents.empty();
}

PackedPart plain(const MeshPart& part) {
  PackedPart packed;
  packed.attributes.push_back(copied("POSITION", ComponentType::kFloat, 3, part.positions));
  packed.attributes.push_back(copied("NORMAL", ComponentType::kFloat, 3, part.normals));
  if (has_picture(part)) {
    packed.attributes.push_back(copied("TEXCOORD_0", ComponentType::kFloat, 2, part.uvs));
  }
  if (has_tangents(part, false)) {
    packed.attributes.push_back(copied("TANGENT", ComponentType::kFloat, 4, part.tangents));
  }
  return packed;
}

PackedPart quantized(const MeshPart& part, double step_m) {
  PackedPart packed;
  packed.attributes.push_back(step_m > 0.0
                                  ? positions_in_steps(part.positions, step_m)
                                  : copied("POSITION", ComponentType::kFloat, 3, part.positions));
  packed.attributes.push_back(directions_in_bytes("NORMAL", 3, part.normals));
  if (has_tangents(part, true)) {
    packed.attributes.push_back(directions_in_bytes("TANGENT", 4, part.tangents));
  }
  if (has_picture(part)) {
    const bool fits = std::all_of(
        part.uvs.begin(), part.uvs.end(), [](float v) { return v >= 0.0F && v <= 1.0F; });
    packed.attributes.push_back(fits ? uvs_in_shorts(part.uvs)
                                     : copied("TEXCOORD_0", ComponentType::kFloat, 2, part.uvs));
  }
  return packed;
}

void bound(PackedPart& packed) {
  const PackedStream& positions = packed.attributes.front();
  packed.least.fill(std::numeric_limits<double>::infinity());
  packed.most.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < positions.count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      double value = 0.0;
      const std::uint8_t* at = positions.bytes.data() + i * positions.stride;
      if (positions.component == ComponentType::kFloat) {
        float stored = 0.0F;
        std::memcpy(&stored, at + 4 * k, sizeof(stored));
        value = stored;
      } else {
        std::int16_t stored = 0;
        std::memcpy(&stored, at + 2 * k, sizeof(stored));
        value = stored;
      }
      packed.least[k] = std::min(packed.least[k], value);
      packed.most[k] = std::max(packed.most[k], value);
    }
  }
}

void compress_attribute(PackedStream& stream, const std::vector<float>& normals) {
  std::vector<std::uint8_t> source = stream.bytes;
  if (stream.attribute == "NORMAL") {
    std::vector<float> four(stream.count * 4, 0.0F);
    for (std::size_t i = 0; i < normals.size(); ++i) four[i / 3 * 4 + i % 3] = normals[i];
    constexpr int kBits = 8;
    meshopt_encodeFilterOct(source.data(), stream.count, stream.stride, kBits, four.data());
    stream.octahedral = true;
  }
  stream.packed.resize(meshopt_encodeVertexBufferBound(stream.count, stream.stride));
  stream.packed.resize(meshopt_encodeVertexBuffer(
      stream.packed.data(), stream.packed.size(), source.data(), stream.count, stream.stride));
}

/// Orders triangles and vertices for better compression.
MeshPart reordered(const MeshPart& part) {
  MeshPart result = part;
  const std::size_t vertices = part.vertex_count();
  meshopt_optimizeVertexCache(
      result.indices.data(), part.indices.data(), part.indices.size(), vertices);
  std::vector<unsigned> remap(vertices);
  const std::size_t used = meshopt_optimizeVertexFetchRemap(
      remap.data(), result.indices.data(), result.indices.size(), vertices);
  meshopt_remapIndexBuffer(
      result.indices.data(), result.indices.data(), result.indices.size(), remap.data());
  const auto move = [&](auto& values, std::size_t each) {
    if (values.empty()) return;
    auto moved = values;
    meshopt_remapVertexBuffer(
        moved.data(), values.data(), vertices, each * sizeof(values[0]), remap.data());
    moved.resize(used * each);
    values = std::move(moved);
  };
  move(result.positions, 3);
  move(result.normals, 3);
  move(result.colors, 4);
  move(result.uvs, 2);
  move(result.tangents, 4);
  return result;
}

void compress_indices(PackedStream& stream,
                      const std::vector<std::uint32_t>& indices,
                      std::size_t vertices) {
  // The version is a global setting of the library; the format requires 1 and 0.
  static std::once_flag once;
  std::call_once(once, [] {
    meshopt_encodeIndexVersion(1);
    meshopt_encodeVertexVersion(0);
  });
  stream.packed.resize(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  stream.packed.resize(meshopt_encodeIndexBuffer(
      stream.packed.data(), stream.packed.size(), indices.data(), indices.size()));
}

PackedPart packed_as_is(const MeshPart& part, const PackOptions& options) {
  PackedPart packed = options.quantize ? quantized(part, options.step_m) : plain(part);
  if (!part.colors.empty()) {
    packed.attributes.push_back(copied("COLOR_0", ComponentType::kUbyte, 4, part.colors));
    packed.attributes.back().normalized = true;
  }
  packed.indices = indices_of(part.indices, part.vertex_count());
  bound(packed);
  return packed;
}

}  // namespace

bool has_normal_map(const MeshPart& part, bool is_packed) {
  return has_picture(part) && part.normal_texture != nullptr &&
         !(is_packed && part.kind == PartKind::kFoliage);
}

double quantization_step_m(const std::vector<const MeshPart*>& parts) {
  double farthest = 1e-6;
  for (const MeshPart* part : parts) {
    for (const float value : part->positions)
      farthest = std::max(farthest, std::abs(double{value}));
  }
  return farthest / kLargestShort;
}

PackedPart pack(const MeshPart& part, const PackOptions& options) {
  if (!options.compress) return packed_as_is(part, options);
  const MeshPart ordered = reordered(part);
  PackedPart packed = packed_as_is(ordered, options);
  compress_indices(packed.indices, ordered.indices, ordered.vertex_count());
  for (PackedStream& stream : packed.attributes) compress_attribute(stream, ordered.normals);
  return packed;
}

}  // namespace silvafit::tree
