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

std::vector<SprayLeaf> spray(int number) {
  constexpr int kPairs = 4;
  std::vector<SprayLeaf> leaves;
  for (int i = 0; i < kPairs; ++i) {
    for (const int side : {-1, 1}) {
      // Leaves of a twig grow alternately on both sides; the number of the image shifts the order.
      const double turn = 0.5 * ((side > 0) == (number % 2 == 0) ? 1 : 0);
      const double share = (i + turn) / kPairs;
      const double wave = std::sin(1.7 * number + 2.3 * i + side);
      leaves.push_back({.x = 0.5,
                        .y = 0.04 + 0.52 * share,
                        .angle_rad = side * (76.0 - 44.0 * share + 7.0 * wave) * kRadian,
                        .length = 0.43 - 0.05 * share,
                        .width = 0.085,
                        .shade = 0.86 + 0.1 * wave});
    }
  }
  leaves.push_back({.x = 0.5, .y = 0.55, .length = 0.43, .width = 0.085, .shade = 1.0});
  return leaves;
}

/// Brightness of a leaf at a point, or below 0 outside the leaf.
double brightness(const SprayLeaf& leaf, double x, double y) {
  const double s = std::sin(leaf.angle_rad);
  const double c = std::cos(leaf.angle_rad);
  const double along = ((x - leaf.x) * s + (y - leaf.y) * c) / leaf.length;
  const double across = ((x - leaf.x) * c - (y - leaf.y) * s) / leaf.width;
  if (along < 0.0 || along > 1.0) return -1.0;
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
      const bool is_twig = std::abs(x - 0.5) < 0.6 / width && y < 0.56;
      if (light < 0.0 && is_twig) light = 0.7;
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
