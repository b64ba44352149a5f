// SPDX-License-Identifier: MIT
// Computed textures of bark and leaves.
#pragma once

#include <memory>

#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {

enum class BarkKind {
  kFurrowed,  ///< long ridges with deep furrows between, as of conifers
  kSmooth,    ///< faint spots and wrinkles, as of beeches
  kCulm,      ///< fine lines along a bamboo's culm
};

enum class LeafKind {
  kBroadleaf,  ///< one leaf with its veins
  kNeedles,    ///< a shoot with needles on both sides
};

/// 256 by 256 pixels, seamless at all edges. To be multiplied with the bark's color: their mean is
/// 0.8 in linear light. Computed once and shared.
std::shared_ptr<const Texture> bark_texture(BarkKind kind);

/// A card of 128 by 128 pixels, its base in the middle of the lower edge, transparent around the
/// leaf; the leaf's mean is 0.8 in linear light. Transparent pixels have the color of leaves, so
/// that interpolation gives no other color at the edges. Computed once and shared.
std::shared_ptr<const Texture> leaf_texture(LeafKind kind);

}  // namespace silvafit::tree
