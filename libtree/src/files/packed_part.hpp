// SPDX-License-Identifier: MIT
// The buffers of a part as a glTF file holds them.
#pragma once

#include <array>
#include <cstdint>
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

/// One attribute or the indices: bytes with their meaning.
struct PackedStream {
  std::string attribute{};  ///< POSITION, ...; empty for indices
  ComponentType component = ComponentType::kFloat;
  int components = 1;
  bool normalized = false;
  std::size_t count = 0;
  std::size_t stride = 0;  ///< bytes from one to the next, a multiple of 4 for attributes
  std::vector<std::uint8_t> bytes{};   ///< count * stride
  bool octahedral = false;             ///< `packed` went through meshoptimizer's filter
  std::vector<std::uint8_t> packed{};  ///< compressed, where asked for
};

struct PackedPart {
  std::vector<PackedStream> attributes{};
  PackedStream indices{};
  std::array<double, 3> least{};  ///< of the positions as stored
  std::array<double, 3> most{};
};

struct PackOptions {
  bool quantize = false;
  bool compress = false;
  double step_m = 0.0;  ///< of quantized positions; 0 leaves positions as floats
};

/// The step with which the farthest coordinate of a model's parts is just within 16 bits, signed.
double quantization_step_m(const std::vector<const MeshPart*>& parts);

PackedPart pack(const MeshPart& part, const PackOptions& options);

}  // namespace silvafit::tree
