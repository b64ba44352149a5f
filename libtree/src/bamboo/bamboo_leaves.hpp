// SPDX-License-Identifier: MIT
// Images of bamboo leaves, and their order from dark to bright.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "silvafit/tree/preset.hpp"
#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {

/// A twig with a spray of narrow leaves on transparent background, its base at the middle of the
/// lower edge. Images of one form and size differ only in color and name.
/// \param size    width and height, a power of two
/// \param color   linear RGB of the leaves
/// \param number  of the image, which changes the order of leaves
Texture bamboo_leaf_picture(std::size_t size, const Color& color, int number);

/// The mean of N = sqrt(R^2 + G^2 + B^2) over the visible pixels (opacity above a half),
/// with R, G, B from 0 to 255 as in the image; 0 if there are none. Source: Liu et al. 2022,
/// equation 5.
double color_weight(const Texture& picture);

/// The images from the darkest to the brightest; equal ones keep their order.
std::vector<std::shared_ptr<const Texture>> ranked_by_color(
    std::vector<std::shared_ptr<const Texture>> pictures);

/// The images side by side, each scaled to the same square, because a mesh has one texture for its
/// foliage; unused space at the right is transparent.
struct PictureRow {
  std::shared_ptr<const Texture> whole{};
  double share = 1.0;  ///< width of each image relative to the texture's
};
/// \param pictures  at least one
/// \param size      of each square, a power of two
PictureRow side_by_side(const std::vector<std::shared_ptr<const Texture>>& pictures,
                        std::size_t size,
                        const std::string& name);

/// The mean of the visible pixels, linear RGB.
Color mean_color(const Texture& picture);

}  // namespace silvafit::tree
