// SPDX-License-Identifier: MIT
// The buffers of a part for a glTF file.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

enum class ComponentType {
  kByte = 5120,
  kUbyte = 5121,
  kShort = 5122,
  kUshort = 5123,
  kUint = 5125,
  kFloat = 5126
};

/// Least and largest value of each component.
struct StreamBounds {
  std::array<double, 3> least{};
  std::array<double, 3> most{};
};

/// One attribute or the indices: bytes and their format.
struct PackedStream {
  std::string attribute{};  ///< POSITION, ...; empty for indices
  ComponentType component = ComponentType::kFloat;
  int components = 1;
  bool normalized = false;
  std::size_t count = 0;
  std::size_t stride = 0;                ///< stride in bytes, a multiple of 4 for attributes
  std::vector<std::uint8_t> bytes{};     ///< count * stride
  bool octahedral = false;               ///< whether meshoptimizer filtered the bytes
  std::optional<StreamBounds> bounds{};  ///< of positions, which glTF requires

  /// Whether the other stream's bytes can follow in the same view.
  bool has_format_of(const PackedStream& other) const {
    return attribute == other.attribute && component == other.component &&
           components == other.components && normalized == other.normalized &&
           stride == other.stride && octahedral == other.octahedral;
  }
};

/// The attributes and, last, the indices.
using PackedPart = std::vector<PackedStream>;

struct PackOptions {
  bool quantize = false;
  bool compress = false;
  double step_m = 0.0;  ///< of quantized positions; 0: positions are floats
};

/// The step for which the largest coordinate of a model's parts is within signed 16 bits; at least
/// 1.5 mm.
double quantization_step_m(const std::vector<const MeshPart*>& parts);

/// Whether a part has a normal map in the file. Packed files have none, because tangents would be
/// a fifth of their size.
bool has_normal_map(const MeshPart& part, bool is_packed);

/// Texture coordinates of packed files are counted in these steps: twelfths of the pictures of an
/// atlas, or parts of bark that are small beside the picture.
/// \returns the number of steps across and down the texture
std::array<std::size_t, 2> texture_steps(const Texture& texture);

PackedPart pack(const MeshPart& part, const PackOptions& options);

/// Bytes of a view, compressed for EXT_meshopt_compression.
/// \param format  of the bytes
std::vector<std::uint8_t> compressed(const PackedStream& format,
                                     const std::vector<std::uint8_t>& bytes);

}  // namespace silvafit::tree
