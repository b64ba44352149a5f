// SPDX-License-Identifier: MIT
#include "silvafit/tree/texture_library.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "pictures/shoot_canvas.hpp"

namespace silvafit::tree {
namespace {

constexpr std::size_t kBarkSide = 256;
// Room for the contrast between ridges and furrows.
constexpr double kMean = 0.6;

/// A hash in [0, 1) of a lattice point (the finalizer of MurmurHash3).
double lattice(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  std::uint32_t h = x * 0x9e3779b1U + y * 0x85ebca77U + seed * 0xc2b2ae3dU;
  h = (h ^ h >> 16U) * 0x85ebca6bU;
  h = (h ^ h >> 13U) * 0xc2b2ae35U;
  h ^= h >> 16U;
  return h / 4294967296.0;
}

/// Seamless smooth noise in [0, 1] on the unit square: a lattice with this number of cells,
/// interpolated cubically.
double noise(double x, double y, int across, int along, std::uint32_t seed) {
  const auto wrapped = [](double value, int cells) {
    const double at = (value - std::floor(value)) * cells;
    const int below = std::min(static_cast<int>(at), cells - 1);
    const double t = at - below;
    return std::pair{below, t * t * (3.0 - 2.0 * t)};
  };
  const auto [left, s] = wrapped(x, across);
  const auto [low, t] = wrapped(y, along);
  const auto corner = [&, from_x = left, from_y = low](int dx, int dy) {
    return lattice(static_cast<std::uint32_t>((from_x + dx) % across),
                   static_cast<std::uint32_t>((from_y + dy) % along),
                   seed);
  };
  const double below = corner(0, 0) + s * (corner(1, 0) - corner(0, 0));
  const double above = corner(0, 1) + s * (corner(1, 1) - corner(0, 1));
  return below + t * (above - below);
}

/// Noise of several wavelengths, each half as long as the previous one.
double rough(double x, double y, int across, int along, int octaves, std::uint32_t seed) {
  double sum = 0.0;
  double weight = 0.0;
  double share = 1.0;
  for (int i = 0; i < octaves; ++i) {
    sum += share * noise(x, y, across << i, along << i, seed + static_cast<std::uint32_t>(i));
    weight += share;
    share *= 0.5;
  }
  return sum / weight;
}

/// A point of bark: its height relative to that of the ridges, and the color of its surface
/// relative to the others.
struct BarkPoint {
  double height = 1.0;
  Tint color{1.0, 1.0, 1.0};
};

Tint mixed(const Tint& a, const Tint& b, double share) {
  Tint result{};
  for (std::size_t k = 0; k < 3; ++k) result[k] = a[k] + share * (b[k] - a[k]);
  return result;
}

BarkPoint furrowed(double u, double v) {
  // Irregular ridges run along the stem; there is a furrow where the noise crosses its middle.
  const double swerve = 0.1 * (rough(u, v, 3, 3, 3, 11) - 0.5);
  const double ridge = std::abs(2.0 * rough(u + swerve, v, 11, 2, 3, 23) - 1.0);
  const double depth = std::clamp(ridge / 0.3, 0.0, 1.0);
  // Cracks across divide the ridges into plates; fibres are the finer scale.
  const double across = std::abs(2.0 * rough(u + swerve, v, 8, 7, 2, 37) - 1.0);
  const double crack = 0.5 * (1.0 - std::clamp(across / 0.16, 0.0, 1.0));
  const double fibres = rough(u, v, 56, 9, 2, 31);
  const double height = depth * depth * (3.0 - 2.0 * depth) * (1.0 - crack) + 0.3 * (fibres - 0.5);
  // Weathered plates are gray, the inner bark of the furrows is red-brown.
  const double weather = std::clamp(height + 0.9 * (rough(u, v, 5, 5, 3, 43) - 0.5), 0.0, 1.0);
  const double light = 0.2 + 0.75 * std::clamp(height, 0.0, 1.1) + 0.3 * (fibres - 0.5);
  return {height,
          mixed({1.3 * light, 0.88 * light, 0.65 * light},
                {0.93 * light, 1.0 * light, 1.08 * light},
                weather)};
}

BarkPoint smooth(double u, double v) {
  const double spots = rough(u, v, 5, 5, 4, 41);
  const double wrinkles = rough(u, v, 3, 26, 3, 53);
  const double crease = std::clamp((wrinkles - 0.58) / 0.16, 0.0, 1.0);
  const double grains = rough(u, v, 40, 40, 2, 57);
  const double height = 1.0 - 0.5 * crease + 0.35 * (spots - 0.5) + 0.12 * (grains - 0.5);
  // Lichens are pale and greenish.
  const double lichen = std::clamp((rough(u, v, 4, 4, 4, 67) - 0.56) / 0.08, 0.0, 1.0);
  const double light = 0.82 + 0.5 * (spots - 0.5) - 0.25 * crease + 0.2 * (grains - 0.5);
  return {height + 0.1 * lichen,
          mixed({1.05 * light, 0.98 * light, 0.92 * light},
                {1.1 * light, 1.24 * light, 1.12 * light},
                0.7 * lichen)};
}

BarkPoint culm(double u, double v) {
  const double lines = rough(u, v, 64, 1, 2, 61);
  const double bloom = rough(u, v, 5, 3, 3, 71);
  const double light = 0.8 + 0.16 * (lines - 0.5) + 0.2 * (bloom - 0.5);
  // The bloom is a white powder.
  return {1.0 + 0.1 * (lines - 0.5),
          mixed({light, light, light}, {1.15 * light, 1.1 * light, 1.3 * light}, bloom)};
}

using Bark = BarkPoint (*)(double, double);

struct BarkPictures {
  std::shared_ptr<const Texture> color{};
  std::shared_ptr<const Texture> normals{};
};

/// Normals of the heights, on a square that repeats.
/// \param relief  height of the ridges relative to the width of the picture
Texture normals_of(const std::string& name, const std::vector<BarkPoint>& points, double relief) {
  Texture texture{.name = name, .width = kBarkSide, .height = kBarkSide};
  texture.rgba.reserve(4 * points.size());
  const auto height = [&](std::size_t x, std::size_t y) {
    return points[y % kBarkSide * kBarkSide + x % kBarkSide].height;
  };
  const auto stored = [](double value) {
    return static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * value));
  };
  const double steep = 0.5 * relief * static_cast<double>(kBarkSide);
  for (std::size_t y = 0; y < kBarkSide; ++y) {
    for (std::size_t x = 0; x < kBarkSide; ++x) {
      const double right = steep * (height(x + 1, y) - height(x + kBarkSide - 1, y));
      const double up = steep * (height(x, y + kBarkSide - 1) - height(x, y + 1));
      const double size = std::sqrt(1.0 + right * right + up * up);
      texture.rgba.insert(texture.rgba.end(),
                          {stored(-right / size), stored(-up / size), stored(1.0 / size), 255});
    }
  }
  return texture;
}

/// Each channel is scaled to the common mean, so that the material keeps its color.
BarkPictures pictures_of(const std::string& name, Bark bark, double relief) {
  std::vector<BarkPoint> points;
  points.reserve(kBarkSide * kBarkSide);
  Tint sum{};
  for (std::size_t y = 0; y < kBarkSide; ++y) {
    for (std::size_t x = 0; x < kBarkSide; ++x) {
      points.push_back(bark((static_cast<double>(x) + 0.5) / kBarkSide,
                            (static_cast<double>(y) + 0.5) / kBarkSide));
      for (std::size_t k = 0; k < 3; ++k) sum[k] += points.back().color[k];
    }
  }
  Texture color{.name = name, .width = kBarkSide, .height = kBarkSide};
  color.rgba.reserve(4 * points.size());
  for (const BarkPoint& point : points) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double scale = kMean * static_cast<double>(points.size()) / sum[k];
      color.rgba.push_back(srgb_byte(scale * point.color[k]));
    }
    color.rgba.push_back(255);
  }
  return {std::make_shared<const Texture>(std::move(color)),
          std::make_shared<const Texture>(normals_of(name + "-normal", points, relief))};
}

BarkPictures drawn_bark(BarkKind kind) {
  switch (kind) {
    case BarkKind::kFurrowed:
      return pictures_of("bark-furrowed", furrowed, 0.035);
    case BarkKind::kSmooth:
      return pictures_of("bark-smooth", smooth, 0.008);
    case BarkKind::kCulm:
      return pictures_of("bark-culm", culm, 0.004);
  }
  return {};
}

const BarkPictures& bark_pictures(BarkKind kind) {
  static std::array<std::once_flag, 3> once;
  static std::array<BarkPictures, 3> pictures;
  const auto at = static_cast<std::size_t>(kind);
  std::call_once(once.at(at), [&] { pictures.at(at) = drawn_bark(kind); });
  return pictures.at(at);
}

}  // namespace

std::shared_ptr<const Texture> bark_texture(BarkKind kind) { return bark_pictures(kind).color; }

std::shared_ptr<const Texture> bark_normals(BarkKind kind) { return bark_pictures(kind).normals; }

}  // namespace silvafit::tree
