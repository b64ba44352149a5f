// SPDX-License-Identifier: MIT
// Interpolation of textures.
#pragma once

#include <Eigen/Core>

#include "silvafit/tree/texture.hpp"

namespace silvafit::render {

/// The color in linear light and the opacity at a point, bilinear between the centers of pixels;
/// the texture repeats. Colors are weighted by their opacity.
/// \param u, v  from the upper left corner, in sizes of the image
Eigen::Vector4f sampled(const tree::Texture& texture, float u, float v);

/// The four channels as they are stored, from 0 to 1, bilinear: for normal maps.
Eigen::Vector4f sampled_as_stored(const tree::Texture& texture, float u, float v);

/// The opacity alone, as in sampled().
float opacity(const tree::Texture& texture, float u, float v);

}  // namespace silvafit::render
