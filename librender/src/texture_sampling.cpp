// SPDX-License-Identifier: MIT
#include "texture_sampling.hpp"

#include <array>
#include <cmath>
#include <cstdint>

namespace silvafit::render {
namespace {

using Eigen::Vector4f;

/// Linear light of all sRGB bytes (IEC 61966-2-1).
std::array<float, 256> linear_table() {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double c = static_cast<double>(i) / 255.0;
    table[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return table;
}

/// The four pixels around a point and their weights.
struct Around {
  std::array<const std::uint8_t*, 4> pixels{};
  std::array<float, 4> weights{};
};

Around around(const tree::Texture& texture, float u, float v) {
  const auto split = [](float value, std::size_t size) {
    const float at = (value - std::floor(value)) * static_cast<float>(size) - 0.5F;
    const float below = std::floor(at);
    const auto first = static_cast<std::size_t>(below + static_cast<float>(size)) % size;
    return std::pair{first, at - below};
  };
  const auto [x, s] = split(u, texture.width);
  const auto [y, t] = split(v, texture.height);
  const std::size_t right = (x + 1) % texture.width;
  const std::size_t lower = (y + 1) % texture.height;
  const auto pixel = [&texture](std::size_t column, std::size_t row) {
    return texture.rgba.data() + 4 * (row * texture.width + column);
  };
  return {{pixel(x, y), pixel(right, y), pixel(x, lower), pixel(right, lower)},
          {(1.0F - s) * (1.0F - t), s * (1.0F - t), (1.0F - s) * t, s * t}};
}

}  // namespace

Vector4f sampled(const tree::Texture& texture, float u, float v) {
  static const std::array<float, 256> kLinear = linear_table();
  const Around at = around(texture, u, v);
  Vector4f sum = Vector4f::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const std::uint8_t* p = at.pixels[i];
    const float alpha = at.weights[i] * static_cast<float>(p[3]) / 255.0F;
    sum += Vector4f(alpha * kLinear[p[0]], alpha * kLinear[p[1]], alpha * kLinear[p[2]], alpha);
  }
  if (sum[3] > 0.0F) sum.head<3>() /= sum[3];
  return sum;
}

Vector4f sampled_as_stored(const tree::Texture& texture, float u, float v) {
  const Around at = around(texture, u, v);
  Vector4f sum = Vector4f::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const std::uint8_t* p = at.pixels[i];
    sum += at.weights[i] / 255.0F * Vector4f(p[0], p[1], p[2], p[3]);
  }
  return sum;
}

float opacity(const tree::Texture& texture, float u, float v) {
  const Around at = around(texture, u, v);
  float sum = 0.0F;
  for (std::size_t i = 0; i < 4; ++i) {
    sum += at.weights[i] * static_cast<float>(at.pixels[i][3]) / 255.0F;
  }
  return sum;
}

}  // namespace silvafit::render
