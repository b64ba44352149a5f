// SPDX-License-Identifier: MIT
// Views of glTF buffers that meshoptimizer packed (EXT_meshopt_compression).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace silvafit::tree {

struct PackedView {
  std::string mode{};    ///< ATTRIBUTES, TRIANGLES or INDICES
  std::string filter{};  ///< NONE or empty, OCTAHEDRAL, QUATERNION, EXPONENTIAL
  std::size_t count = 0;
  std::size_t stride = 0;  ///< bytes of an element
};

/// Bytes that a view has unpacked: `count` times `stride`, which the file says and which the packed
/// bytes must be enough for.
/// \throws InputError if they cannot be, or a size is none of the mode's
std::size_t unpacked_size(const PackedView& view, std::string_view source);

/// The elements, filters undone.
/// \throws InputError as unpacked_size, and if the bytes are damaged
std::string unpacked(const PackedView& view, std::string_view source);

}  // namespace silvafit::tree
