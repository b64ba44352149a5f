// SPDX-License-Identifier: MIT
#include "silvafit/render/picture.hpp"

#include <png.h>

#include <catch2/catch.hpp>

#include "scratch_file.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"

using namespace silvafit;
using namespace silvafit::render;

namespace {

Picture filled(std::size_t width, std::size_t height, std::uint8_t value) {
  return {.width = width,
          .height = height,
          .rgb = std::vector<std::uint8_t>(3 * width * height, value)};
}

}  // namespace

TEST_CASE("a PNG file has the pixels, and equal images have equal bytes") {
  Picture picture = filled(5, 3, 0);
  for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
    picture.rgb[i] = static_cast<std::uint8_t>(7 * i);
  }
  const test::ScratchFile file("", ".png");
  write_png(picture, file.path());
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_file(&image, file.path().c_str()) != 0);
  CHECK(image.width == 5);
  CHECK(image.height == 3);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> read(PNG_IMAGE_SIZE(image));
  REQUIRE(png_image_finish_read(&image, nullptr, read.data(), 0, nullptr) != 0);
  CHECK(read == picture.rgb);
  const std::string bytes = read_file(file.path());
  write_png(picture, file.path());
  CHECK(read_file(file.path()) == bytes);
}

TEST_CASE("a contact sheet has its pictures row by row with white gaps") {
  const Picture sheet = contact_sheet({filled(2, 1, 10), filled(2, 1, 20), filled(2, 1, 30)}, 2, 1);
  CHECK(sheet.width == 5);
  CHECK(sheet.height == 3);
  CHECK(sheet.pixel(0, 0)[0] == 10);
  CHECK(sheet.pixel(2, 0)[0] == 255);
  CHECK(sheet.pixel(3, 0)[0] == 20);
  CHECK(sheet.pixel(1, 1)[0] == 255);
  CHECK(sheet.pixel(1, 2)[0] == 30);
  CHECK(sheet.pixel(4, 2)[0] == 255);
  CHECK_THROWS_AS(contact_sheet({}, 2), UsageError);
  CHECK_THROWS_AS(contact_sheet({filled(2, 1, 0), filled(1, 2, 0)}, 2), UsageError);
}
