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

constexpr std::size_t kWidth = 256;
constexpr std::size_t kHeight = 2 * kWidth;
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

/// Short lines around the stem: at most one in each cell.
/// \returns the closeness to its middle line, 1 on it
double dashes(double u, double v, const BarkLayer& layer, std::uint32_t seed) {
  const double x = u * layer.across;
  const double y = v * layer.along;
  double nearest = 0.0;
  for (const int row : {-1, 0, 1}) {
    for (const int column : {-1, 0, 1}) {
      const int cell_x = static_cast<int>(std::floor(x)) + column;
      const int cell_y = static_cast<int>(std::floor(y)) + row;
      const auto random = [&](std::uint32_t which) {
        return lattice(static_cast<std::uint32_t>((cell_x + layer.across) % layer.across),
                       static_cast<std::uint32_t>((cell_y + layer.along) % layer.along),
                       seed + which);
      };
      // Lengths differ, and many cells are empty.
      const double half = 0.75 * random(2) - 0.1;
      if (half <= 0.0) continue;
      const double along = (x - cell_x - random(0)) / half;
      const double off = (y - cell_y - random(1)) / (0.12 + 0.2 * random(3) * half);
      nearest = std::max(nearest, 1.0 - std::hypot(along, off));
    }
  }
  return nearest;
}

double pattern_at(double u, double v, const BarkLayer& layer, std::uint32_t seed) {
  if (layer.pattern == BarkLayer::Pattern::kDashes) return dashes(u, v, layer, seed);
  const double swerve = layer.swerve * (rough(u, v, 3, 5, 3, seed + 50) - 0.5);
  const double value = rough(u + swerve, v, layer.across, layer.along, layer.octaves, seed);
  return layer.pattern == BarkLayer::Pattern::kRidges ? std::abs(2.0 * value - 1.0) : value;
}

BarkPoint bark_at(double u, double v, const std::vector<BarkLayer>& layers) {
  BarkPoint point{.height = 0.0};
  std::uint32_t seed = 11;
  for (const BarkLayer& layer : layers) {
    const double value = pattern_at(u, v, layer, seed);
    const double t = std::clamp((value - layer.from) / (layer.to - layer.from), 0.0, 1.0);
    const double share = t * t * (3.0 - 2.0 * t);
    point.height += share * layer.height;
    for (std::size_t k = 0; k < 3; ++k) point.color[k] *= 1.0 + share * (layer.tint[k] - 1.0);
    seed += 100;
  }
  return point;
}

/// Normals of the heights, on a picture that repeats.
/// \param relief  height of the ridges relative to the width of the picture
Texture normals_of(const std::string& name, const std::vector<BarkPoint>& points, double relief) {
  Texture texture{.name = name, .width = kWidth, .height = kHeight};
  texture.rgba.reserve(4 * points.size());
  const auto height = [&](std::size_t x, std::size_t y) {
    return points[y % kHeight * kWidth + x % kWidth].height;
  };
  const auto stored = [](double value) {
    return static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * value));
  };
  const double steep = 0.5 * relief * static_cast<double>(kWidth);
  for (std::size_t y = 0; y < kHeight; ++y) {
    for (std::size_t x = 0; x < kWidth; ++x) {
      const double right = steep * (height(x + 1, y) - height(x + kWidth - 1, y));
      const double up = steep * (height(x, y + kHeight - 1) - height(x, y + 1));
      const double size = std::sqrt(1.0 + right * right + up * up);
      texture.rgba.insert(texture.rgba.end(),
                          {stored(-right / size), stored(-up / size), stored(1.0 / size), 255});
    }
  }
  return texture;
}

}  // namespace

/// Each channel is scaled to the common mean, so that the material keeps its color.
const std::array<std::shared_ptr<const Texture>, 2>& BarkPicture::drawn() const {
  std::call_once(once_, [this] {
    std::vector<BarkPoint> points;
    points.reserve(kWidth * kHeight);
    Tint sum{};
    for (std::size_t y = 0; y < kHeight; ++y) {
      for (std::size_t x = 0; x < kWidth; ++x) {
        points.push_back(bark_at((static_cast<double>(x) + 0.5) / kWidth,
                                 (static_cast<double>(y) + 0.5) / kHeight,
                                 plan_.layers));
        for (std::size_t k = 0; k < 3; ++k) sum[k] += points.back().color[k];
      }
    }
    Texture color{.name = "bark-" + plan_.name, .width = kWidth, .height = kHeight};
    color.rgba.reserve(4 * points.size());
    for (const BarkPoint& point : points) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double scale = kMean * static_cast<double>(points.size()) / sum[k];
        color.rgba.push_back(srgb_byte(scale * point.color[k]));
      }
      color.rgba.push_back(255);
    }
    pictures_ = {std::make_shared<const Texture>(std::move(color)),
                 std::make_shared<const Texture>(
                     normals_of("bark-" + plan_.name + "-normal", points, plan_.relief))};
  });
  return pictures_;
}

}  // namespace silvafit::tree
