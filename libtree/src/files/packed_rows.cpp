// SPDX-License-Identifier: MIT
#include "files/packed_rows.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "files/gltf_buffers.hpp"

namespace silvafit::tree {
namespace {

constexpr int kMantissaBits = 23;  // beside the sign, of the filter EXPONENTIAL

std::int32_t steps_of(float value, int exponent) {
  constexpr double kMost = (1 << kMantissaBits) - 1;
  const double steps = std::round(std::ldexp(double{value}, -exponent));
  return static_cast<std::int32_t>(std::clamp(steps, -kMost, kMost));
}

}  // namespace

std::vector<float> floats_of(const Rows& rows) {
  std::vector<float> values(rows.bytes.size() / sizeof(float));
  std::memcpy(values.data(), rows.bytes.data(), rows.bytes.size());
  return values;
}

int exponent_for(double length, const std::vector<float>& values) {
  double largest = 1e-30;
  for (const float value : values) largest = std::max(largest, std::abs(double{value}));
  const int least = std::ilogb(largest) + 1 - kMantissaBits;
  return std::clamp(std::max(std::ilogb(std::max(length, 1e-30)), least), -100, 100);
}

Bytes in_steps(const std::vector<float>& values, int exponent) {
  std::vector<std::uint32_t> words;
  words.reserve(values.size());
  for (const float value : values) {
    const auto mantissa = static_cast<std::uint32_t>(steps_of(value, exponent));
    words.push_back((mantissa & 0xFFFFFFU) | static_cast<std::uint32_t>(exponent) << 24U);
  }
  Bytes bytes(words.size() * sizeof(words[0]));
  std::memcpy(bytes.data(), words.data(), bytes.size());
  return bytes;
}

double largest_extent(const std::vector<float>& positions) {
  double most = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto [low, high] = std::pair{positions[axis], positions[axis]};
    for (std::size_t i = axis; i < positions.size(); i += 3) {
      low = std::min(low, positions[i]);
      high = std::max(high, positions[i]);
    }
    most = std::max(most, double{high} - double{low});
  }
  return most;
}

double from_steps(float value, int exponent) {
  return std::ldexp(static_cast<double>(steps_of(value, exponent)), exponent);
}

Bytes octahedral(const std::vector<float>& values, std::size_t width, int bits) {
  constexpr std::size_t kStride = 4;
  const std::size_t count = values.size() / width;
  std::vector<float> four(kStride * count, 0.0F);
  for (std::size_t i = 0; i < values.size(); ++i) {
    four[i / width * kStride + i % width] = values[i];
  }
  Bytes bytes(kStride * count);
  meshopt_encodeFilterOct(bytes.data(), count, kStride, bits, four.data());
  return bytes;
}

Rows padded(const Rows& rows) {
  Rows result{.each = aligned_to_word(rows.each)};
  result.bytes.resize(result.each * rows.count());
  for (std::size_t i = 0; i < rows.count(); ++i) {
    std::memcpy(&result.bytes[i * result.each], &rows.bytes[i * rows.each], rows.each);
  }
  return result;
}

std::vector<std::uint32_t> indices_of(const Rows& rows) {
  std::vector<std::uint32_t> indices(rows.count());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    std::memcpy(&indices[i], &rows.bytes[i * rows.each], rows.each);  // little endian, as glTF
  }
  return indices;
}

Rows rows_of(const std::vector<std::uint32_t>& indices, std::size_t each) {
  Rows rows{.each = each, .bytes = Bytes(each * indices.size())};
  for (std::size_t i = 0; i < indices.size(); ++i) {
    std::memcpy(&rows.bytes[i * each], &indices[i], each);
  }
  return rows;
}

}  // namespace silvafit::tree
