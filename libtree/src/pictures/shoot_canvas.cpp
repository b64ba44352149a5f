// SPDX-License-Identifier: MIT
#include "pictures/shoot_canvas.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace silvafit::tree {
namespace {

/// Width of a blade relative to its widest, at a share of its length.
double profile(const Blade& blade, double share) {
  if (share <= 0.0 || share >= 1.0) return 0.0;
  const double peak = blade.rise / (blade.rise + blade.fall);
  return std::pow(share / peak, blade.rise) * std::pow((1.0 - share) / (1.0 - peak), blade.fall);
}

/// Distance from an outline, in the units of its points, positive inside.
double inside_outline(std::span<const std::array<double, 2>> outline, double across, double along) {
  double nearest = 1e9;
  bool is_inside = false;
  std::array<double, 2> a{0.0, 0.0};
  for (std::size_t i = 0; i <= outline.size(); ++i) {
    const std::array<double, 2> b =
        i < outline.size() ? outline[i] : std::array<double, 2>{0.0, 1.0};
    const double dx = b[0] - a[0];
    const double dy = b[1] - a[1];
    const double t = std::clamp(
        ((across - a[0]) * dx + (along - a[1]) * dy) / std::max(dx * dx + dy * dy, 1e-12),
        0.0,
        1.0);
    nearest = std::min(nearest, std::hypot(across - a[0] - t * dx, along - a[1] - t * dy));
    if ((a[1] > along) != (b[1] > along) && across < a[0] + dx * (along - a[1]) / dy) {
      is_inside = !is_inside;
    }
    a = b;
  }
  return is_inside ? nearest : -nearest;
}

/// Ranges of pixels around a piece of the picture.
struct Box {
  std::size_t left, right, top, bottom;

  Box(Spot a, Spot b, double margin, std::size_t size) {
    const auto clamped = [size](double value) {
      return static_cast<std::size_t>(
          std::clamp(value * static_cast<double>(size), 0.0, static_cast<double>(size)));
    };
    left = clamped(std::min(a.x, b.x) - margin);
    right = clamped(std::max(a.x, b.x) + margin);
    top = clamped(1.0 - std::max(a.y, b.y) - margin);
    bottom = clamped(1.0 - std::min(a.y, b.y) + margin);
  }
};

Tint blade_color(const PictureLeaf& leaf, const Blade& blade, double share, double side) {
  // One half of a folded blade faces the light.
  double light = leaf.shade * (0.9 + 0.14 * share) * (side > 0.0 ? 1.05 : 0.95);
  light *= 1.0 - 0.1 * std::abs(side);
  double vein = std::clamp(1.4 - std::abs(side) / 0.06, 0.0, 1.0);
  if (blade.veins > 0.0) {
    const double turn = blade.veins * (share - blade.vein_rise * 0.2 * std::abs(side));
    const double from_vein = std::abs(turn - std::round(turn));
    vein = std::max(vein, 0.6 * std::clamp(1.5 - from_vein / 0.09, 0.0, 1.0));
    // Between the veins the blade bulges.
    light *= 0.94 + 0.12 * from_vein;
  }
  const double warm = leaf.warmth + 0.5 * vein;
  light *= 1.0 + 0.22 * vein;
  return {light * (1.0 + 0.3 * warm), light * (1.0 + 0.05 * warm), light * (1.0 - 0.15 * warm)};
}

}  // namespace

Spot towards(double angle_rad) { return {std::sin(angle_rad), std::cos(angle_rad)}; }

std::uint8_t exact_srgb_byte(double linear) {
  const double c = std::clamp(linear, 0.0, 1.0);
  const double encoded = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * encoded));
}

std::uint8_t srgb_byte(double linear) {
  constexpr std::size_t kSteps = 4096;
  static const std::array<std::uint8_t, kSteps + 1> bytes = [] {
    std::array<std::uint8_t, kSteps + 1> table{};
    for (std::size_t i = 0; i <= kSteps; ++i) {
      table[i] = exact_srgb_byte(static_cast<double>(i) / kSteps);
    }
    return table;
  }();
  return bytes[static_cast<std::size_t>(kSteps * std::clamp(linear, 0.0, 1.0) + 0.5)];
}

double linear_light(std::uint8_t srgb) {
  static const std::array<double, 256> values = [] {
    std::array<double, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
      const double c = static_cast<double>(i) / 255.0;
      table[i] = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    }
    return table;
  }();
  return values[srgb];
}

ShootCanvas::ShootCanvas(std::size_t size) : size_(size), pixels_(size * size) {}

void ShootCanvas::cover(
    Pixel& pixel, double share, const Tint& color, double tilt_x, double tilt_y) {
  const auto part = static_cast<float>(share);
  // Pixels that are not covered yet have no color.
  const float whole = pixel.cover + part * (1.0F - pixel.cover);
  const float weight = whole > 0.0F ? part / whole : 0.0F;
  const std::array<float, 2> tilt{static_cast<float>(tilt_x), static_cast<float>(tilt_y)};
  for (std::size_t k = 0; k < 3; ++k) {
    pixel.color[k] += weight * (static_cast<float>(color[k]) - pixel.color[k]);
  }
  for (std::size_t k = 0; k < 2; ++k) pixel.tilt[k] += weight * (tilt[k] - pixel.tilt[k]);
  pixel.cover = whole;
}

void ShootCanvas::leaf(const PictureLeaf& leaf, const Blade& blade, double shadow) {
  const Spot along = towards(leaf.angle_rad);
  const Spot across{along.y, -along.x};
  const auto size = static_cast<double>(size_);
  const double pixel = 1.0 / size;
  const double reach = 0.5 * leaf.width + std::abs(leaf.bend) * leaf.length;
  constexpr double kShadowWidth = 4.0;  // pixels
  const double shadow_width = kShadowWidth * pixel;
  const Box box(leaf.base, leaf.base + leaf.length * along, reach + shadow_width, size_);
  for (std::size_t row = box.top; row < box.bottom; ++row) {
    for (std::size_t column = box.left; column < box.right; ++column) {
      const Spot at{(static_cast<double>(column) + 0.5) * pixel,
                    1.0 - (static_cast<double>(row) + 0.5) * pixel};
      const Spot from = at - leaf.base;
      const double share = (from.x * along.x + from.y * along.y) / leaf.length;
      if (share < -0.2 || share > 1.05) continue;
      const double off =
          from.x * across.x + from.y * across.y - leaf.bend * leaf.length * share * share;
      const double half_width = 0.5 * leaf.width;
      // No blade is wider than its widest place: beside it there is nothing to draw.
      constexpr double kRounding = 1e-9;
      const bool is_beside = std::abs(off) - half_width > shadow_width + kRounding;
      if (is_beside && blade.outline.empty()) continue;
      double inside = 0.0;  // distance from the edge, positive inside
      double side = 0.0;
      if (blade.outline.empty()) {
        const double half = half_width * profile(blade, share);
        inside = half - std::abs(off);
        side = half > 0.0 ? off / half : 0.0;
      } else {
        inside = inside_outline(blade.outline, std::abs(off) / half_width, share) *
                 std::min(half_width, leaf.length);
        side = off / half_width;
      }
      if (inside <= -shadow_width) continue;
      Pixel& target = pixels_[row * size_ + column];
      if (shadow > 0.0 && inside < 0.0) {
        const double dark = shadow * (1.0 + inside / shadow_width);
        for (float& channel : target.color) channel *= static_cast<float>(1.0 - dark);
      }
      const double share_covered = std::clamp(inside / pixel + 0.5, 0.0, 1.0);
      if (share_covered <= 0.0) continue;
      leaf_area_ += share_covered;
      constexpr double kFold = 0.3;
      cover(target,
            share_covered,
            blade_color(leaf, blade, share, std::clamp(side, -1.0, 1.0)),
            leaf.tilt_x + kFold * (side > 0.0 ? 1.0 : -1.0) * across.x,
            leaf.tilt_y + kFold * (side > 0.0 ? 1.0 : -1.0) * across.y);
    }
  }
}

void ShootCanvas::twig(Spot from, Spot to, double base_width, double tip_width, const Tint& tint) {
  const double pixel = 1.0 / static_cast<double>(size_);
  const Spot line = to - from;
  const double squared = line.x * line.x + line.y * line.y;
  const double long_side = std::sqrt(squared);
  const Spot across{line.y / long_side, -line.x / long_side};
  const Box box(from, to, base_width + pixel, size_);
  for (std::size_t row = box.top; row < box.bottom; ++row) {
    for (std::size_t column = box.left; column < box.right; ++column) {
      const Spot at{(static_cast<double>(column) + 0.5) * pixel,
                    1.0 - (static_cast<double>(row) + 0.5) * pixel};
      const Spot off = at - from;
      const double share = std::clamp((off.x * line.x + off.y * line.y) / squared, 0.0, 1.0);
      const double half = 0.5 * std::max(base_width + share * (tip_width - base_width), pixel);
      const Spot rest = off - share * line;
      const double inside = half - std::hypot(rest.x, rest.y);
      const double share_covered = std::clamp(inside / pixel + 0.5, 0.0, 1.0);
      if (share_covered <= 0.0) continue;
      const double side = std::clamp((rest.x * across.x + rest.y * across.y) / half, -1.0, 1.0);
      const double light = 1.0 - 0.3 * side * side;
      cover(pixels_[row * size_ + column],
            share_covered,
            {light * tint[0], light * tint[1], light * tint[2]},
            0.8 * side * across.x,
            0.8 * side * across.y);
    }
  }
}

double ShootCanvas::covered() const {
  double sum = 0.0;
  for (const Pixel& pixel : pixels_) sum += static_cast<double>(pixel.cover);
  return sum;
}

double ShootCanvas::brightness() const {
  double sum = 0.0;
  for (const Pixel& pixel : pixels_) sum += static_cast<double>(pixel.cover * pixel.color[1]);
  return sum;
}

Tint ShootCanvas::mean_color() const {
  Tint sum{};
  double area = 1e-9;
  for (const Pixel& pixel : pixels_) {
    area += static_cast<double>(pixel.cover);
    for (std::size_t k = 0; k < 3; ++k) {
      sum[k] += static_cast<double>(pixel.cover * pixel.color[k]);
    }
  }
  for (double& channel : sum) channel /= area;
  return sum;
}

void ShootCanvas::copy_to(
    Texture& color, Texture& normals, std::size_t x, std::size_t y, double scale) const {
  const Tint mean = mean_color();
  for (std::size_t row = 0; row < size_; ++row) {
    for (std::size_t column = 0; column < size_; ++column) {
      const Pixel& pixel = pixels_[row * size_ + column];
      const std::size_t at = 4 * ((y + row) * color.width + x + column);
      const bool is_empty = pixel.cover <= 0.0F;
      for (std::size_t k = 0; k < 3; ++k) {
        // Around the leaves the mean color, so that mipmaps have no edges of another color.
        const double value = is_empty ? mean[k] : static_cast<double>(pixel.color[k]);
        color.rgba[at + k] = srgb_byte(scale * value);
      }
      color.rgba[at + 3] =
          static_cast<std::uint8_t>(std::lround(255.0 * static_cast<double>(pixel.cover)));
      const double tilt_x = is_empty ? 0.0 : static_cast<double>(pixel.tilt[0]);
      const double tilt_y = is_empty ? 0.0 : static_cast<double>(pixel.tilt[1]);
      const double long_side = std::sqrt(1.0 + tilt_x * tilt_x + tilt_y * tilt_y);
      const auto stored = [long_side](double value) {
        return static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * value / long_side));
      };
      normals.rgba[at] = stored(tilt_x);
      normals.rgba[at + 1] = stored(tilt_y);
      normals.rgba[at + 2] = stored(1.0);
      normals.rgba[at + 3] = 255;
    }
  }
}

}  // namespace silvafit::tree
