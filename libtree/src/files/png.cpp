// SPDX-License-Identifier: MIT
#include <png.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include "files/palette.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {
namespace {

constexpr std::size_t kLongestSide = 8192;

std::string encoded(std::size_t width,
                    std::size_t height,
                    std::span<const std::uint8_t> pixels,
                    std::uint32_t format,
                    const std::vector<Rgba>& palette = {}) {
  if (width == 0 || height == 0 || pixels.size() / PNG_IMAGE_PIXEL_SIZE(format) / width != height ||
      pixels.size() % (width * PNG_IMAGE_PIXEL_SIZE(format)) != 0) {
    throw UsageError("the number of pixels of a texture must be width times height");
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = format;
  image.colormap_entries = static_cast<png_uint_32>(palette.size());
  // Room for the largest file, because libpng measures a size by compressing the whole image.
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, palette.data()) ==
      0) {
    throw UsageError(std::string("cannot write the image (") + image.message + ")");
  }
  bytes.resize(size);
  bytes.shrink_to_fit();
  return bytes;
}

/// Frees libpng's memory, also after errors.
struct PngImage : png_image {
  PngImage() : png_image{} { version = PNG_IMAGE_VERSION; }
  ~PngImage() { png_image_free(this); }
  PngImage(const PngImage&) = delete;
  PngImage& operator=(const PngImage&) = delete;
};

}  // namespace

bool has_transparency(const Texture& texture) {
  for (std::size_t i = 3; i < texture.rgba.size(); i += 4) {
    if (texture.rgba[i] != 255) return true;
  }
  return false;
}

std::string png_bytes(const Texture& texture) {
  return encoded(texture.width, texture.height, texture.rgba, PNG_FORMAT_RGBA);
}

std::string palette_png_bytes(const Texture& texture) {
  const PaletteImage image = with_palette(texture);
  return encoded(
      texture.width, texture.height, image.numbers, PNG_FORMAT_RGBA_COLORMAP, image.palette);
}

std::string png_bytes(std::size_t width, std::size_t height, std::span<const std::uint8_t> rgb) {
  return encoded(width, height, rgb, PNG_FORMAT_RGB);
}

Texture texture_from_png(std::string_view bytes, std::string name) {
  const auto refuse = [&](const char* why) {
    throw InputError("cannot read the image " + name + ": " + why);
  };
  PngImage image;
  if (png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) == 0) {
    refuse(image.message);
  }
  if (std::max(image.width, image.height) > kLongestSide) refuse("it is too large");
  image.format = PNG_FORMAT_RGBA;
  Texture texture{.name = name, .width = image.width, .height = image.height};
  texture.rgba.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, texture.rgba.data(), 0, nullptr) == 0) {
    refuse(image.message);
  }
  return texture;
}

namespace {

struct Known {
  std::weak_ptr<const Texture> texture{};  ///< expired if another texture is at its address now
  std::once_flag once{};
  std::shared_ptr<const std::string> bytes{};
};

}  // namespace

std::shared_ptr<const std::string> png_file(const std::shared_ptr<const Texture>& texture,
                                            bool has_palette) {
  static std::mutex mutex;
  static std::map<std::pair<const Texture*, bool>, std::shared_ptr<Known>> files;
  std::shared_ptr<Known> known;
  {
    const std::scoped_lock lock(mutex);
    std::erase_if(files, [](const auto& file) { return file.second->texture.expired(); });
    std::shared_ptr<Known>& entry = files[{texture.get(), has_palette}];
    if (entry == nullptr) {
      entry = std::make_shared<Known>();
      entry->texture = texture;
    }
    known = entry;
  }
  // Without the lock, so that several pictures can be encoded at the same time.
  std::call_once(known->once, [&] {
    known->bytes = std::make_shared<const std::string>(has_palette ? palette_png_bytes(*texture)
                                                                   : png_bytes(*texture));
  });
  return known->bytes;
}

}  // namespace silvafit::tree
