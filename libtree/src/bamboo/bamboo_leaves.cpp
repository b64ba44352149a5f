// SPDX-License-Identifier: MIT
#include "bamboo/bamboo_leaves.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "pictures/shoot_canvas.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

constexpr std::uint8_t kOpaque = 255;

/// A leaf in the picture's unit square, y up: a lens from its base to its tip.
struct SprayLeaf {
  double x = 0.0;
  double y = 0.0;
  double angle_rad = 0.0;  ///< from upward to the right
  double length = 0.4;
  double width = 0.07;
  double shade = 1.0;
};

/// A leafy twig: side twigs to both sides in turn, each with a fan of leaves at its end.
std::vector<SprayLeaf> spray(int number) {
  constexpr int kFans = 6;
  constexpr double kTwig = 0.2;
  constexpr double kTwigWidth = 0.012;
  constexpr double kLeaf = 0.25;
  constexpr double kLeafWidth = 0.036;
  std::vector<SprayLeaf> leaves{{.x = 0.5, .length = 0.8, .width = kTwigWidth, .shade = 0.7}};
  for (int i = 0; i < kFans; ++i) {
    const double share = static_cast<double>(i) / (kFans - 1);
    // The number of the image shifts the order.
    const double side = i + 1 == kFans ? 0.0 : (i + number) % 2 == 0 ? 1.0 : -1.0;
    const double wave = std::sin(1.7 * number + 2.3 * i);
    const double turn = side * (64.0 - 26.0 * share + 9.0 * wave) * kRadian;
    const double y = 0.06 + 0.52 * share;
    leaves.push_back({0.5, y, turn, kTwig, kTwigWidth, 0.7});
    for (int k = -2; k <= 2; ++k) {
      const double along = kTwig * (1.0 - 0.28 * std::abs(k));
      const double shade = 0.88 + 0.1 * std::sin(5.0 * wave + 2.0 * k);
      leaves.push_back({0.5 + along * std::sin(turn),
                        y + along * std::cos(turn),
                        turn + (27.0 * k + 6.0 * wave) * kRadian,
                        kLeaf * (1.0 - 0.06 * std::abs(k)),
                        kLeafWidth,
                        shade});
    }
  }
  return leaves;
}

/// Brightness of a leaf at a point, or below 0 outside the leaf.
double brightness(const SprayLeaf& leaf, double x, double y) {
  const double s = std::sin(leaf.angle_rad);
  const double c = std::cos(leaf.angle_rad);
  const double along = ((x - leaf.x) * s + (y - leaf.y) * c) / leaf.length;
  const double across = ((x - leaf.x) * c - (y - leaf.y) * s) / leaf.width;
  constexpr double kWidest = 0.6;
  if (along < 0.0 || along > 1.0 || std::abs(across) > kWidest) return -1.0;
  // Widest at a third, with a long tip.
  const double half = 0.5 * std::pow(along, 0.45) * (1.0 - along) * 2.1;
  if (std::abs(across) > half) return -1.0;
  const double rib = std::abs(across) < 0.08 ? 1.18 : 1.0;
  return leaf.shade * rib * (0.9 + 0.1 * along);
}

}  // namespace

Texture bamboo_leaf_picture(std::size_t size, const Color& color, int number) {
  const std::vector<SprayLeaf> leaves = spray(number);
  Texture picture{.name = "bamboo-leaf-" + std::to_string(number), .width = size, .height = size};
  // Transparent pixels have the leaves' color too, so that interpolation shows no other color at
  // the edges.
  picture.rgba.reserve(4 * size * size);
  const auto width = static_cast<double>(size);
  for (std::size_t row = 0; row < size; ++row) {
    const double y = 1.0 - (static_cast<double>(row) + 0.5) / width;
    for (std::size_t column = 0; column < size; ++column) {
      const double x = (static_cast<double>(column) + 0.5) / width;
      double light = -1.0;
      for (const SprayLeaf& leaf : leaves) light = std::max(light, brightness(leaf, x, y));
      const double shade = light < 0.0 ? 0.9 : light;
      for (const double channel : color) picture.rgba.push_back(exact_srgb_byte(shade * channel));
      picture.rgba.push_back(light < 0.0 ? std::uint8_t{0} : kOpaque);
    }
  }
  return picture;
}

double color_weight(const Texture& picture) {
  double sum = 0.0;
  std::size_t drawn = 0;
  for (std::size_t i = 0; i + 3 < picture.rgba.size(); i += 4) {
    if (picture.rgba[i + 3] < 128) continue;
    const double r = picture.rgba[i];
    const double g = picture.rgba[i + 1];
    const double b = picture.rgba[i + 2];
    sum += std::sqrt(r * r + g * g + b * b);
    ++drawn;
  }
  return drawn == 0 ? 0.0 : sum / static_cast<double>(drawn);
}

std::vector<std::shared_ptr<const Texture>> ranked_by_color(
    std::vector<std::shared_ptr<const Texture>> pictures) {
  std::stable_sort(pictures.begin(), pictures.end(), [](const auto& a, const auto& b) {
    return color_weight(*a) < color_weight(*b);
  });
  return pictures;
}

PictureRow side_by_side(const std::vector<std::shared_ptr<const Texture>>& pictures,
                        std::size_t size,
                        const std::string& name) {
  Texture whole{.name = name, .width = std::bit_ceil(pictures.size()) * size, .height = size};
  whole.rgba.assign(4 * whole.width * whole.height, 0);
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    const Texture& picture = *pictures[k];
    for (std::size_t y = 0; y < size; ++y) {
      for (std::size_t x = 0; x < size; ++x) {
        const std::size_t from =
            4 * ((y * picture.height / size) * picture.width + x * picture.width / size);
        const std::size_t to = 4 * (y * whole.width + k * size + x);
        std::copy_n(picture.rgba.begin() + static_cast<std::ptrdiff_t>(from),
                    4,
                    whole.rgba.begin() + static_cast<std::ptrdiff_t>(to));
      }
    }
  }
  const double share = static_cast<double>(size) / static_cast<double>(whole.width);
  return {std::make_shared<const Texture>(std::move(whole)), share};
}

Color mean_color(const Texture& picture) {
  Color sum{};
  double drawn = 0.0;
  for (std::size_t i = 0; i + 3 < picture.rgba.size(); i += 4) {
    if (picture.rgba[i + 3] < 128) continue;
    for (std::size_t k = 0; k < 3; ++k) sum[k] += linear_light(picture.rgba[i + k]);
    drawn += 1.0;
  }
  for (double& channel : sum) channel = drawn > 0.0 ? channel / drawn : 0.0;
  return sum;
}

}  // namespace silvafit::tree
