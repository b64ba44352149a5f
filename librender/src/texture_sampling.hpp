// SPDX-License-Identifier: MIT
// Colors of pictures between their pixels.
#pragma once

#include <Eigen/Core>

#include "silvafit/tree/texture.hpp"

namespace silvafit::render {

/// The color in linear light and the opacity at a place, bilinear between the middles of pixels;
/// the picture repeats. Colors count by their opacity.
/// \param u, v  from the upper left corner, in sizes of the picture
Eigen::Vector4f sampled(const tree::Texture& texture, float u, float v);

/// The opacity alone, as sampled() has it.
float opacity(const tree::Texture& texture, float u, float v);

}  // namespace silvafit::render
