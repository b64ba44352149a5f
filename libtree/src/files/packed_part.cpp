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

/// Normals in signed bytes; the fourth is 0.
PackedStream directions_in_bytes(const std::vector<float>& values) {
  constexpr std::size_t kWidth = 3;
  PackedStream stream{.attribute = "NORMAL",
                      .component = ComponentType::kByte,
                      .components = 3,
                      .normalized = true,
                      .stride = 4};
  stream.count = values.size() / kWidth;
  stream.bytes.resize(stream.count * 4);
  for (std::size_t i = 0; i < values.size(); ++i) {
    constexpr double kLargestByte = 127.0;
    put(stream.bytes,
        i / kWidth * 4 + i % kWidth,
        static_cast<std::int8_t>(std::lround(kLargestByte * double{values[i]})));
  }
  return stream;
}

/// In shorts, or in floats if a texture is repeated very often.
PackedStream uvs_in_steps(const std::vector<float>& uvs, const Texture& texture) {
  const std::array<std::size_t, 2> steps = texture_steps(texture);
  std::vector<float> counted(uvs.size());
  for (std::size_t i = 0; i < uvs.size(); ++i) {
    counted[i] = std::round(static_cast<float>(steps[i % 2]) * uvs[i]);
  }
  const bool fits =
      std::ranges::all_of(counted, [](float v) { return std::abs(v) <= kLargestShort; });
  if (!fits) return copied("TEXCOORD_0", ComponentType::kFloat, 2, counted);
  const std::vector<std::int16_t> shorts(counted.begin(), counted.end());
  return copied("TEXCOORD_0", ComponentType::kShort, 2, shorts);
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

PackedPart plain(const MeshPart& part) {
  PackedPart packed;
  packed.attributes.push_back(copied("POSITION", ComponentType::kFloat, 3, part.positions));
  packed.attributes.push_back(copied("NORMAL", ComponentType::kFloat, 3, part.normals));
  if (has_picture(part)) {
    packed.attributes.push_back(copied("TEXCOORD_0", ComponentType::kFloat, 2, part.uvs));
  }
  if (has_normal_map(part, false) && !part.tangents.empty()) {
    packed.attributes.push_back(copied("TANGENT", ComponentType::kFloat, 4, part.tangents));
  }
  return packed;
}

PackedPart quantized(const MeshPart& part, double step_m) {
  PackedPart packed;
  packed.attributes.push_back(step_m > 0.0
                                  ? positions_in_steps(part.positions, step_m)
                                  : copied("POSITION", ComponentType::kFloat, 3, part.positions));
  packed.attributes.push_back(directions_in_bytes(part.normals));
  if (has_picture(part)) packed.attributes.push_back(uvs_in_steps(part.uvs, *part.texture));
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

void compress_attribute(PackedStream& stream, const MeshPart& part) {
  const std::vector<float>& normals = part.normals;
  std::vector<std::uint8_t> source = stream.bytes;
  if (stream.attribute == "NORMAL") {
    std::vector<float> four(stream.count * 4, 0.0F);
    for (std::size_t i = 0; i < normals.size(); ++i) four[i / 3 * 4 + i % 3] = normals[i];
    // The normals of cards are those of the crown, more or less: a few degrees do not matter.
    const bool is_card = part.kind == PartKind::kFoliage && has_picture(part);
    const int bits = is_card ? 5 : 8;
    meshopt_encodeFilterOct(source.data(), stream.count, stream.stride, bits, four.data());
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
  return !is_packed && has_picture(part) && part.normal_texture != nullptr;
}

std::array<std::size_t, 2> texture_steps(const Texture& texture) {
  if (texture.pictures > 0) return {texture.pictures, texture.pictures};
  return {texture.width, texture.height};
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
  for (PackedStream& stream : packed.attributes) compress_attribute(stream, ordered);
  return packed;
}

}  // namespace silvafit::tree
