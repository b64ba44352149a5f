// SPDX-License-Identifier: MIT
// Rows of vertex attributes and indices in the formats that meshoptimizer compresses well.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace silvafit::tree {

using Bytes = std::vector<std::uint8_t>;

/// The values of an accessor, row by row without gaps.
struct Rows {
  std::size_t each = 0;  ///< bytes of a row
  Bytes bytes{};

  std::size_t count() const { return bytes.size() / each; }
};

std::vector<float> floats_of(const Rows& rows);

/// The largest extent of positions, x y z, along an axis.
double largest_extent(const std::vector<float>& positions);

/// The exponent of steps, a power of two, that are not longer than a length unless the largest
/// value has more of them than in_steps() can count.
int exponent_for(double length, const std::vector<float>& values);

/// Numbers of steps, with the exponent in the last byte of each: meshoptimizer's filter
/// EXPONENTIAL, with one exponent for all values, so that errors are equal everywhere.
Bytes in_steps(const std::vector<float>& values, int exponent);

/// The value that a reader finds.
double from_steps(float value, int exponent);

/// Unit vectors in signed bytes: meshoptimizer's filter OCTAHEDRAL.
/// \param width  3, or 4 for tangents
/// \param bits   of each of the two coordinates
Bytes octahedral(const std::vector<float>& values, std::size_t width, int bits);

/// Rows whose size is a multiple of four bytes.
Rows padded(const Rows& rows);

/// Indices of one, two or four bytes.
std::vector<std::uint32_t> indices_of(const Rows& rows);
Rows rows_of(const std::vector<std::uint32_t>& indices, std::size_t each);

}  // namespace silvafit::tree
