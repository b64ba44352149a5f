// SPDX-License-Identifier: MIT
// Pictures of bamboo leaves, and their order from dark to bright.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "silvafit/tree/preset.hpp"
#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {

/// A twig with a spray of narrow leaves on transparent ground, its base at the middle of the lower
/// edge. Pictures of one form and size differ in nothing but their color and their name.
/// \param size    width and height, a power of two
/// \param color   linear RGB of the leaves
/// \param number  of the picture, which changes the order of leaves
Texture bamboo_leaf_picture(std::size_t size, const Color& color, int number);

/// The mean of N = sqrt(R^2 + G^2 + B^2) over the pixels that are drawn (opacity above a half),
/// with R, G, B from 0 to 255 as in the picture; 0 if there are none. Source: Liu et al. 2022,
/// equation 5.
double color_weight(const Texture& picture);

/// The pictures from the darkest to the brightest; equal ones keep their order.
std::vector<std::shared_ptr<const Texture>> ranked_by_color(
    std::vector<std::shared_ptr<const Texture>> pictures);

/// The pictures side by side, each stretched to the same square, as one mesh has one picture for
/// its foliage; what is left over at the right is transparent.
struct PictureRow {
  std::shared_ptr<const Texture> whole{};
  double share = 1.0;  ///< width of each picture as a share of the whole's
};
/// \param pictures  at least one
/// \param size      of each square, a power of two
PictureRow side_by_side(const std::vector<std::shared_ptr<const Texture>>& pictures,
                        std::size_t size,
                        const std::string& name);

/// The mean of the pixels that are drawn, linear RGB.
Color mean_color(const Texture& picture);

}  // namespace silvafit::tree
