// SPDX-License-Identifier: MIT
#include "noise.hpp"

#include <cmath>
#include <cstdint>

namespace silvafit::render {
namespace {

/// A number in [0, 1] for a corner of the grid: the mixing steps of MurmurHash3's finalizer.
float corner(std::int32_t x, std::int32_t y) {
  std::uint32_t bits =
      static_cast<std::uint32_t>(x) * 0x9E3779B1U ^ static_cast<std::uint32_t>(y) * 0x85EBCA77U;
  bits = (bits ^ (bits >> 16U)) * 0x85EBCA6BU;
  bits = (bits ^ (bits >> 13U)) * 0xC2B2AE35U;
  bits ^= bits >> 16U;
  return static_cast<float>(bits >> 8U) / 16777215.0F;
}

float smooth(float share) { return share * share * (3.0F - 2.0F * share); }

}  // namespace

float value_noise(float x, float y) {
  // Beyond this, floats have no fractions worth mixing.
  constexpr float kFarthest = 1e7F;
  if (!(std::abs(x) < kFarthest && std::abs(y) < kFarthest)) return 0.5F;
  const auto column = static_cast<std::int32_t>(std::floor(x));
  const auto row = static_cast<std::int32_t>(std::floor(y));
  const float across = smooth(x - static_cast<float>(column));
  const float up = smooth(y - static_cast<float>(row));
  const float low = std::lerp(corner(column, row), corner(column + 1, row), across);
  const float high = std::lerp(corner(column, row + 1), corner(column + 1, row + 1), across);
  return std::lerp(low, high, up);
}

float fractal_noise(float x, float y, int octaves) {
  float sum = 0.0F;
  float strength = 1.0F;
  float total = 0.0F;
  for (int octave = 0; octave < octaves; ++octave) {
    // An offset, so that the octaves have no common corner.
    sum += strength * value_noise(x + 17.3F * static_cast<float>(octave), y);
    total += strength;
    strength *= 0.5F;
    x *= 2.0F;
    y *= 2.0F;
  }
  return sum / total;
}

}  // namespace silvafit::render
