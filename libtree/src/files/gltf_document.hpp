// SPDX-License-Identifier: MIT
// The contents of a glTF description and its buffers, for any kind of file.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/tree/scene_reader.hpp"

namespace silvafit::tree {

/// \throws InputError with the reason
[[noreturn]] void refuse_gltf(const std::string& what);

/// The string with this name; empty if there is none.
std::string gltf_text(const nlohmann::json& in, const char* name);

/// The bytes of a component of an accessor; 0 if the type is unknown.
std::size_t component_size(std::size_t type);
/// The components of a row of an accessor; 0 for matrices and unknown types.
std::size_t component_count(std::string_view type);
/// Whether a view of so many bytes has the rows of an accessor.
bool has_rows(
    std::size_t bytes, std::size_t from, std::size_t row, std::size_t stride, std::size_t count);

/// The default scene, decompressed. Sizes, indices and references are checked before they are used.
/// \throws InputError; nlohmann::json::exception if a value has another type than glTF requires
ReadScene read_document(nlohmann::json description, std::vector<std::string> buffers);

}  // namespace silvafit::tree
