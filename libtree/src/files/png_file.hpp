// SPDX-License-Identifier: MIT
// Textures as PNG files, encoded once.
#pragma once

#include <memory>
#include <string>

#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {

/// The PNG file of a texture, with a palette (palette.hpp) or all colors. Many trees in files of
/// their own share a texture, and its encoding takes longer than a tree: it is kept as long as the
/// texture lives. Several threads may call this at the same time.
std::shared_ptr<const std::string> png_file(const std::shared_ptr<const Texture>& texture,
                                            bool has_palette = false);

}  // namespace silvafit::tree
