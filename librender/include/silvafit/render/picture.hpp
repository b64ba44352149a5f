// SPDX-License-Identifier: MIT
// Images of 8 bits per channel, and their PNG files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace silvafit::render {

/// Pixels row by row from the upper left, three bytes each (sRGB), and a byte of opacity if the
/// background is transparent.
struct Picture {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<std::uint8_t> rgb{};
  std::vector<std::uint8_t> opacity{};  ///< none: all are opaque

  std::uint8_t* pixel(std::size_t x, std::size_t y) { return rgb.data() + 3 * (y * width + x); }
  const std::uint8_t* pixel(std::size_t x, std::size_t y) const {
    return rgb.data() + 3 * (y * width + x);
  }
};

/// Images of one size side by side, row by row, with a gap between, white or transparent.
/// \throws UsageError if there is none, their sizes or kinds differ, or columns is 0
Picture contact_sheet(const std::vector<Picture>& pictures,
                      std::size_t columns,
                      std::size_t gap = 4);

/// Writes a PNG file, completely or not at all; the same image gives the same bytes.
/// \throws IoError if it cannot be written
void write_png(const Picture& picture, const std::filesystem::path& path);

}  // namespace silvafit::render
