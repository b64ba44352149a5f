// SPDX-License-Identifier: MIT
#include "png_reader.hpp"

#include <png.h>

#include <cstring>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {

Texture read_png(const std::filesystem::path& file) {
  const std::string bytes = read_file(file);
  png_image image;
  std::memset(&image, 0, sizeof(image));
  image.version = PNG_IMAGE_VERSION;
  const auto refuse = [&](const std::string& what) {
    png_image_free(&image);
    throw InputError(what, {.file = file.string()});
  };
  if (png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) == 0) {
    refuse(std::string("is no PNG picture: ") + image.message);
  }
  constexpr png_uint_32 kLargest = 4096;
  if (image.width > kLargest || image.height > kLargest) {
    refuse("has more than 4096 pixels to a side");
  }
  image.format = PNG_FORMAT_RGBA;
  Texture picture{.name = file.filename().string(), .width = image.width, .height = image.height};
  picture.rgba.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, picture.rgba.data(), 0, nullptr) == 0) {
    refuse(std::string("is a broken PNG picture: ") + image.message);
  }
  return picture;
}

}  // namespace silvafit::tree
