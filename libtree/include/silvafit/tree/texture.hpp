// SPDX-License-Identifier: MIT
// Textures of bark and leaves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::tree {

/// Pixels row by row from the upper left, four bytes each (sRGB and opacity). Sides are powers of
/// two, so that every viewer can repeat it and make mipmaps.
struct Texture {
  std::string name{};  ///< textures of the same name are stored once in a file
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<std::uint8_t> rgba{};
  /// If all texture coordinates are corners of pictures of the same size: their number in a row
  /// and in a column.
  std::size_t pictures = 0;
};

/// Whether any pixel is not opaque.
bool has_transparency(const Texture& texture);

/// The texture as a PNG file; the same texture gives the same bytes.
/// \throws UsageError if the number of pixels is not width times height
std::string png_bytes(const Texture& texture);

/// The same for pixels without opacity, three bytes each.
/// \throws UsageError if the number of pixels is not width times height
std::string png_bytes(std::size_t width, std::size_t height, std::span<const std::uint8_t> rgb);

/// A PNG file of any kind as a texture.
/// \throws InputError if it cannot be read, or a side is longer than 8192 pixels
Texture texture_from_png(std::string_view bytes, std::string name);

}  // namespace silvafit::tree
