// SPDX-License-Identifier: MIT
// The container of a GLB file: a header, the description and the buffer.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace silvafit::tree {

struct GlbParts {
  nlohmann::json description{};              ///< an object
  std::optional<std::string_view> buffer{};  ///< in the bytes that were read
};

/// \throws InputError if the bytes are no GLB file, or fewer than its header says
GlbParts glb_parts(std::string_view bytes);

/// A JSON object. \throws InputError
nlohmann::json gltf_description(std::string_view text);

/// The bytes of a GLB file with parts of these sizes [bytes], both multiples of four.
std::size_t glb_size(std::size_t description, std::size_t buffer);
/// What precedes the description.
std::string glb_head(std::size_t description, std::size_t buffer);
/// What follows the description and precedes the buffer.
std::string glb_buffer_head(std::size_t buffer);

}  // namespace silvafit::tree
