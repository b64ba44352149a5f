// SPDX-License-Identifier: MIT
#include "files/packed_part.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>

#include "files/packed_rows.hpp"

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
  packed.push_back(copied("POSITION", ComponentType::kFloat, 3, part.positions));
  packed.push_back(copied("NORMAL", ComponentType::kFloat, 3, part.normals));
  if (has_picture(part)) {
    packed.push_back(copied("TEXCOORD_0", ComponentType::kFloat, 2, part.uvs));
  }
  if (has_normal_map(part, false) && !part.tangents.empty()) {
    packed.push_back(copied("TANGENT", ComponentType::kFloat, 4, part.tangents));
  }
  return packed;
}

PackedPart quantized(const MeshPart& part, double step_m) {
  PackedPart packed;
  packed.push_back(step_m > 0.0 ? positions_in_steps(part.positions, step_m)
                                : copied("POSITION", ComponentType::kFloat, 3, part.positions));
  packed.push_back(directions_in_bytes(part.normals));
  if (has_picture(part)) packed.push_back(uvs_in_steps(part.uvs, *part.texture));
  return packed;
}

void bound(PackedStream& positions) {
  StreamBounds bounds;
  bounds.least.fill(std::numeric_limits<double>::infinity());
  bounds.most.fill(-std::numeric_limits<double>::infinity());
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
      bounds.least[k] = std::min(bounds.least[k], value);
      bounds.most[k] = std::max(bounds.most[k], value);
    }
  }
  positions.bounds = bounds;
}

bool is_cards(const MeshPart& part) { return part.kind == PartKind::kFoliage && has_picture(part); }

/// Normals as meshoptimizer compresses them best.
void filter_normals(PackedStream& stream, const MeshPart& part) {
  // The normals of cards are those of the crown, more or less, and bark is rough: a few degrees do
  // not matter.
  const int of_textured = is_cards(part) ? 4 : 5;
  const int bits = has_picture(part) ? of_textured : 8;
  stream.bytes = octahedral(part.normals, 3, bits);
  stream.octahedral = true;
}

/// Triangles of equal color follow one another, in the same order as before.
std::vector<std::uint32_t> by_color(const MeshPart& part) {
  std::vector<std::uint32_t> order(part.triangle_count());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) {
    return part.colors[4 * std::size_t{part.indices[3 * i]}];
  });
  std::vector<std::uint32_t> indices;
  indices.reserve(part.indices.size());
  for (const std::uint32_t i : order) {
    for (std::size_t k = 0; k < 3; ++k) indices.push_back(part.indices[3 * std::size_t{i} + k]);
  }
  return indices;
}

/// Orders triangles and vertices for better compression.
MeshPart reordered(const MeshPart& part) {
  MeshPart result = part;
  const std::size_t vertices = part.vertex_count();
  if (is_cards(part) && !part.colors.empty()) {
    result.indices = by_color(part);
  } else {
    meshopt_optimizeVertexCache(
        result.indices.data(), part.indices.data(), part.indices.size(), vertices);
  }
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

/// The versions are global settings of the library; the format requires 1 and 0.
void set_versions() {
  static std::once_flag once;
  std::call_once(once, [] {
    meshopt_encodeIndexVersion(1);
    meshopt_encodeVertexVersion(0);
  });
}

std::vector<std::uint8_t> compressed_indices(const PackedStream& format,
                                             const std::vector<std::uint8_t>& bytes) {
  const std::vector<std::uint32_t> indices = indices_of(Rows{format.stride, bytes});
  const std::size_t vertices = indices.empty() ? 0 : std::ranges::max(indices) + std::size_t{1};
  std::vector<std::uint8_t> packed(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  packed.resize(
      meshopt_encodeIndexBuffer(packed.data(), packed.size(), indices.data(), indices.size()));
  return packed;
}

PackedPart packed_as_is(const MeshPart& part, const PackOptions& options) {
  PackedPart packed = options.quantize ? quantized(part, options.step_m) : plain(part);
  bound(packed.front());
  if (!part.colors.empty()) {
    packed.push_back(copied("COLOR_0", ComponentType::kUbyte, 4, part.colors));
    packed.back().normalized = true;
  }
  packed.push_back(indices_of(part.indices, part.vertex_count()));
  return packed;
}

}  // namespace

bool has_normal_map(const MeshPart& part, bool is_packed) {
  return !is_packed && has_picture(part) && part.normal_texture != nullptr;
}

std::array<std::size_t, 2> texture_steps(const Texture& texture) {
  // Whole numbers for rings of 3, 4, 6 and 12 sides, and for cards that bend in as many rows, so
  // that a byte holds their differences.
  constexpr std::size_t kAround = 12;
  if (texture.pictures > 0) return {kAround * texture.pictures, kAround * texture.pictures};
  constexpr std::size_t kAlong = 16;
  return {kAround, kAlong};
}

double quantization_step_m(const std::vector<const MeshPart*>& parts) {
  double farthest = 1e-6;
  for (const MeshPart* part : parts) {
    for (const float value : part->positions)
      farthest = std::max(farthest, std::abs(double{value}));
  }
  // Finer steps would only make files larger.
  constexpr double kFinest = 0.0015;
  return std::max(farthest / kLargestShort, kFinest);
}

PackedPart pack(const MeshPart& part, const PackOptions& options) {
  if (!options.compress) return packed_as_is(part, options);
  const MeshPart ordered = reordered(part);
  PackedPart packed = packed_as_is(ordered, options);
  for (PackedStream& stream : packed) {
    if (stream.attribute == "NORMAL") filter_normals(stream, ordered);
  }
  return packed;
}

std::vector<std::uint8_t> compressed(const PackedStream& format,
                                     const std::vector<std::uint8_t>& bytes) {
  set_versions();
  if (format.attribute.empty()) return compressed_indices(format, bytes);
  const std::size_t count = bytes.size() / format.stride;
  std::vector<std::uint8_t> packed(meshopt_encodeVertexBufferBound(count, format.stride));
  packed.resize(
      meshopt_encodeVertexBuffer(packed.data(), packed.size(), bytes.data(), count, format.stride));
  return packed;
}

}  // namespace silvafit::tree
