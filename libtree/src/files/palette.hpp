// SPDX-License-Identifier: MIT
// Pictures with few colors, and PNG files of textures that are encoded once.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {

using Rgba = std::array<std::uint8_t, 4>;

struct PaletteImage {
  std::vector<Rgba> palette{};          ///< at most 96 colors
  std::vector<std::uint8_t> numbers{};  ///< of each pixel's color
};

/// Median cut of the colors and opacities of a picture (Heckbert 1982, Color image quantization for
/// frame buffer display, SIGGRAPH 16, 297-307); exact if there are at most 96. Opaque pixels stay
/// opaque. All pixels without opacity have one color, the mean of all others, so that interpolation
/// at the edges gives no other color.
PaletteImage with_palette(const Texture& texture);

/// The texture as a PNG file with such a palette: a third of the size of png_bytes() or less.
/// \throws UsageError if the number of pixels is not width times height
std::string palette_png_bytes(const Texture& texture);

/// The PNG file of a texture, with a palette or all colors. Many trees in files of
/// their own share a texture, and its encoding takes longer than a tree: it is kept as long as the
/// texture lives. Several threads may call this at the same time.
std::shared_ptr<const std::string> png_file(const std::shared_ptr<const Texture>& texture,
                                            bool has_palette = false);

}  // namespace silvafit::tree
