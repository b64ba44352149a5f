// SPDX-License-Identifier: MIT
// The writers behind open_scene().
#pragma once

#include <filesystem>
#include <memory>

#include "silvafit/tree/scene_writer.hpp"

namespace silvafit::tree {

std::unique_ptr<SceneWriter> make_gltf_writer(const std::filesystem::path& path,
                                              bool binary,
                                              const SceneOptions& options);
std::unique_ptr<SceneWriter> make_obj_writer(const std::filesystem::path& path,
                                             const SceneOptions& options);
std::unique_ptr<SceneWriter> make_ply_writer(const std::filesystem::path& path,
                                             const SceneOptions& options);

}  // namespace silvafit::tree
