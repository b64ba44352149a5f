// SPDX-License-Identifier: MIT
// The contents of a glTF description and its buffers, for any kind of file.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "silvafit/tree/scene_reader.hpp"

namespace silvafit::tree {

/// \throws InputError with the reason
[[noreturn]] void refuse_gltf(const std::string& what);

/// The string with this name; empty if there is none.
std::string gltf_text(const nlohmann::json& in, const char* name);

/// The default scene, decompressed. Sizes, indices and references are checked before they are used.
/// \throws InputError; nlohmann::json::exception if a value has another type than glTF requires
ReadScene read_document(nlohmann::json description, std::vector<std::string> buffers);

}  // namespace silvafit::tree
