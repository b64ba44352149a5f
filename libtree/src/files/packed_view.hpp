// SPDX-License-Identifier: MIT
// Buffer views compressed by meshoptimizer (EXT_meshopt_compression).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace silvafit::tree {

struct PackedView {
  std::string mode{};    ///< ATTRIBUTES, TRIANGLES or INDICES
  std::string filter{};  ///< NONE or empty, OCTAHEDRAL, QUATERNION, EXPONENTIAL
  std::size_t count = 0;
  std::size_t stride = 0;  ///< bytes per element
};

/// Bytes of a decompressed view: `count` times `stride`, as declared in the file, if the compressed
/// bytes can contain so many.
/// \throws InputError if they cannot, or a size is not valid for the mode
std::size_t unpacked_size(const PackedView& view, std::string_view source);

/// The elements, with filters reversed.
/// \throws InputError as unpacked_size, and if the bytes are damaged
std::string unpacked(const PackedView& view, std::string_view source);

}  // namespace silvafit::tree
