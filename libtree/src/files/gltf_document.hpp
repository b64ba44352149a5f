// SPDX-License-Identifier: MIT
// What a glTF description and its buffers say, whatever file they came in.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "silvafit/tree/scene_reader.hpp"

namespace silvafit::tree {

/// \throws InputError that says what is wrong with the file
[[noreturn]] void refuse_gltf(const std::string& what);

/// The text under a name; empty if there is none.
std::string gltf_text(const nlohmann::json& in, const char* name);

/// The default scene, unpacked. Sizes, indices and references are checked before they are used.
/// \throws InputError; nlohmann::json::exception where a value has another type than glTF gives it
ReadScene read_document(nlohmann::json description, std::vector<std::string> buffers);

}  // namespace silvafit::tree
