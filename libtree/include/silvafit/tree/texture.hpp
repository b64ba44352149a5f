// SPDX-License-Identifier: MIT
// Pictures that are laid over bark and leaves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace silvafit::tree {

/// Pixels row by row from the upper left, four bytes each (sRGB and opacity). Sides are powers of
/// two, so that every viewer can repeat it and make smaller ones of it.
struct Texture {
  std::string name{};  ///< textures of one name are one picture in a file
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<std::uint8_t> rgba{};
};

/// The picture as a PNG file; the same picture gives the same bytes.
/// \throws UsageError if the pixels do not fill width and height
std::string png_bytes(const Texture& texture);

}  // namespace silvafit::tree
