// SPDX-License-Identifier: MIT
#include "silvafit/tree/texture_library.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace silvafit::tree {
namespace {

constexpr std::size_t kBarkSide = 256;
constexpr std::size_t kLeafSide = 128;
constexpr double kMean = 0.8;

/// Linear light as sRGB (IEC 61966-2-1).
std::uint8_t encoded(double linear) {
  const double c = std::clamp(linear, 0.0, 1.0);
  const double srgb = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * srgb));
}

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

double furrowed(double u, double v) {
  // Irregular ridges run along the stem; there is a furrow where the noise crosses its middle.
  const double swerve = 0.06 * (rough(u, v, 4, 4, 3, 11) - 0.5);
  const double ridge = std::abs(2.0 * rough(u + swerve, v, 12, 3, 3, 23) - 1.0);
  const double plates = rough(u, v, 24, 12, 3, 31);
  const double depth = std::clamp(ridge / 0.25, 0.0, 1.0);
  return 0.35 + 0.5 * depth + 0.3 * (plates - 0.5);
}

double smooth(double u, double v) {
  const double spots = rough(u, v, 6, 6, 4, 41);
  const double wrinkles = rough(u, v, 4, 32, 2, 53);
  return 0.8 + 0.3 * (spots - 0.5) - 0.25 * std::clamp((wrinkles - 0.62) / 0.2, 0.0, 1.0);
}

double culm(double u, double v) {
  const double lines = rough(u, v, 64, 1, 2, 61);
  const double bloom = rough(u, v, 5, 3, 3, 71);
  return 0.8 + 0.16 * (lines - 0.5) + 0.2 * (bloom - 0.5);
}

/// A gray texture, scaled to the common mean.
Texture gray(std::string name, const std::function<double(double, double)>& brightness) {
  std::vector<double> values;
  values.reserve(kBarkSide * kBarkSide);
  double sum = 0.0;
  for (std::size_t y = 0; y < kBarkSide; ++y) {
    for (std::size_t x = 0; x < kBarkSide; ++x) {
      values.push_back(brightness((static_cast<double>(x) + 0.5) / kBarkSide,
                                  (static_cast<double>(y) + 0.5) / kBarkSide));
      sum += values.back();
    }
  }
  const double scale = kMean * static_cast<double>(values.size()) / sum;
  Texture texture{.name = std::move(name), .width = kBarkSide, .height = kBarkSide};
  texture.rgba.reserve(4 * values.size());
  for (const double value : values) {
    const std::uint8_t level = encoded(scale * value);
    texture.rgba.insert(texture.rgba.end(), {level, level, level, 255});
  }
  return texture;
}

/// The image of a card at a point: x from -1 to 1, y from the base up to 1; brightness, or none if
/// it is transparent.
using Card = std::function<double(double x, double y)>;

Texture leaf(std::string name, const Card& card) {
  // Subsamples of each pixel, for smooth edges.
  constexpr int kFine = 4;
  Texture texture{.name = std::move(name), .width = kLeafSide, .height = kLeafSide};
  std::vector<double> light(kLeafSide * kLeafSide, 0.0);
  std::vector<double> cover(light.size(), 0.0);
  for (std::size_t i = 0; i < light.size(); ++i) {
    const std::size_t row = i / kLeafSide;
    for (int k = 0; k < kFine * kFine; ++k) {
      const double x = static_cast<double>(i % kLeafSide) + (k % kFine + 0.5) / kFine;
      const int fine_row = k / kFine;
      const double y = static_cast<double>(row) + (fine_row + 0.5) / kFine;
      const double value = card(2.0 * x / kLeafSide - 1.0, 1.0 - y / kLeafSide);
      if (value <= 0.0) continue;
      light[i] += value;
      cover[i] += 1.0;
    }
  }
  double sum = 0.0;
  double covered = 0.0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    sum += light[i];
    covered += cover[i];
  }
  const double scale = kMean * covered / sum;
  texture.rgba.reserve(4 * light.size());
  for (std::size_t i = 0; i < light.size(); ++i) {
    const double mean = cover[i] > 0.0 ? scale * light[i] / cover[i] : kMean;
    // Red and blue vary slightly more than green: veins and dry edges are yellower.
    const std::uint8_t green = encoded(mean);
    const std::uint8_t other = encoded(mean * (0.97 + 0.03 * mean / kMean));
    texture.rgba.insert(texture.rgba.end(),
                        {other,
                         green,
                         other,
                         static_cast<std::uint8_t>(
                             std::lround(255.0 * cover[i] / static_cast<double>(kFine * kFine)))});
  }
  return texture;
}

double broadleaf(double x, double y) {
  if (y < 0.1) return std::abs(x) < 0.03 ? 0.9 : 0.0;
  // Egg-shaped: widest at two fifths, with a long tip.
  const double along = (y - 0.1) / 0.9;
  const double half = 2.45 * std::pow(along, 0.62) * std::pow(1.0 - along, 0.9) * 0.78;
  if (std::abs(x) > half) return 0.0;
  // Side veins branch off the midrib at 45 degrees, eight on each side.
  constexpr double kVeins = 8.0;
  const double turn = kVeins * (along - 0.45 * std::abs(x));
  const double vein = std::abs(turn - std::round(turn));
  const bool is_vein = std::abs(x) < 0.035 || vein < 0.07;
  return (is_vein ? 1.15 : 0.85) - 0.2 * std::abs(x);
}

double needles(double x, double y) {
  if (std::abs(x) < 0.035 && y < 0.9) return 0.7;
  // Needles branch off the shoot at 55 degrees; each is a stripe of its own brightness.
  constexpr double kNeedles = 22.0;
  const double base = y - 0.5 * std::abs(x) * std::tan(35.0 * std::numbers::pi / 180.0);
  if (base < 0.02 || base > 0.9) return 0.0;
  const double number = kNeedles * base + (x < 0.0 ? 0.5 : 0.0);
  const double within = std::abs(number - std::floor(number) - 0.5);
  const double reach =
      (0.95 - 0.35 * base) * (0.9 + 0.1 * lattice(static_cast<std::uint32_t>(number), x < 0.0, 81));
  const double width = 0.44 * (1.0 - std::abs(x) / reach * 0.45);
  if (std::abs(x) > reach || within > width) return 0.0;
  return 0.7 + 0.5 * lattice(static_cast<std::uint32_t>(number), x < 0.0, 91) - 0.25 * within;
}

std::shared_ptr<const Texture> shared(Texture texture) {
  return std::make_shared<const Texture>(std::move(texture));
}

}  // namespace

std::shared_ptr<const Texture> bark_texture(BarkKind kind) {
  static const std::array<std::shared_ptr<const Texture>, 3> textures{
      shared(gray("bark-furrowed", furrowed)),
      shared(gray("bark-smooth", smooth)),
      shared(gray("bark-culm", culm))};
  return textures.at(static_cast<std::size_t>(kind));
}

std::shared_ptr<const Texture> leaf_texture(LeafKind kind) {
  static const std::array<std::shared_ptr<const Texture>, 2> textures{
      shared(leaf("leaf-broadleaf", broadleaf)), shared(leaf("leaf-needles", needles))};
  return textures.at(static_cast<std::size_t>(kind));
}

}  // namespace silvafit::tree
