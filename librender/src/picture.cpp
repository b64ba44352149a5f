// SPDX-License-Identifier: MIT
#include "silvafit/render/picture.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/texture.hpp"

namespace silvafit::render {

Picture contact_sheet(const std::vector<Picture>& pictures, std::size_t columns, std::size_t gap) {
  if (pictures.empty() || columns == 0) {
    throw UsageError("a contact sheet needs at least one image and one column");
  }
  const std::size_t width = pictures.front().width;
  const std::size_t height = pictures.front().height;
  for (const Picture& picture : pictures) {
    if (picture.width != width || picture.height != height ||
        picture.opacity.empty() != pictures.front().opacity.empty()) {
      throw UsageError("the images of a contact sheet must have the same size and background");
    }
  }
  columns = std::min(columns, pictures.size());
  const std::size_t rows = (pictures.size() + columns - 1) / columns;
  Picture sheet{.width = columns * (width + gap) - gap, .height = rows * (height + gap) - gap};
  sheet.rgb.assign(3 * sheet.width * sheet.height, 255);
  const bool is_transparent = !pictures.front().opacity.empty();
  if (is_transparent) sheet.opacity.assign(sheet.width * sheet.height, 0);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const std::size_t left = i % columns * (width + gap);
    const std::size_t top = i / columns * (height + gap);
    for (std::size_t y = 0; y < height; ++y) {
      std::memcpy(sheet.pixel(left, top + y), pictures[i].pixel(0, y), 3 * width);
      if (!is_transparent) continue;
      std::copy_n(
          pictures[i].opacity.begin() + static_cast<std::ptrdiff_t>(y * width),
          width,
          sheet.opacity.begin() + static_cast<std::ptrdiff_t>((top + y) * sheet.width + left));
    }
  }
  return sheet;
}

void write_png(const Picture& picture, const std::filesystem::path& path) {
  if (picture.opacity.empty()) {
    write_file(path, tree::png_bytes(picture.width, picture.height, picture.rgb));
    return;
  }
  tree::Texture pixels{.width = picture.width, .height = picture.height};
  for (std::size_t i = 0; i < picture.opacity.size(); ++i) {
    const std::uint8_t* const color = picture.rgb.data() + 3 * i;
    pixels.rgba.insert(pixels.rgba.end(), {color[0], color[1], color[2], picture.opacity[i]});
  }
  write_file(path, tree::png_bytes(pixels));
}

}  // namespace silvafit::render
