// SPDX-License-Identifier: MIT
// Computed textures of bark and of leafy shoots.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {

enum class BarkKind {
  kFurrowed,  ///< long ridges with deep furrows between, as of conifers
  kSmooth,    ///< faint spots and wrinkles, as of beeches
  kCulm,      ///< fine lines along a bamboo's culm
};

/// Leafy shoots, by the arrangement and form of their leaves.
enum class ShootKind {
  kAlternate,    ///< egg-shaped leaves that alternate along the twigs, as of Schima
  kOpposite,     ///< the same in pairs
  kLobed,        ///< lobed leaves in pairs, as of maples
  kCrowded,      ///< narrow leaves crowded towards the ends of the twigs, as of Machilus
  kFlatNeedles,  ///< long flat needles in two ranks, as of Chinese fir
  kNeedles,      ///< short needles on dense drooping sprays, as of spruces
  kFrond,        ///< a frond, as of ferns
};

/// Names of the kinds in presets.
const std::vector<std::pair<const char*, ShootKind>>& shoot_kinds();

/// Shoots in an atlas, side by side in two rows.
inline constexpr std::size_t kShootsPerAtlas = 4;

/// Pictures of shoots. The base of each is in the middle of its lower edge, and its tip near the
/// upper edge.
struct ShootAtlas {
  /// 1024 by 1024 pixels, transparent around the leaves. To be multiplied with the leaves' color:
  /// their mean is 0.8 in linear light. Transparent pixels have the color of leaves, so that
  /// interpolation gives no other color at the edges.
  std::shared_ptr<const Texture> color{};
  std::shared_ptr<const Texture> normals{};  ///< inclination of the leaves, as glTF's normal maps
  double covered = 0.0;                      ///< area of all leaves by that of the pictures
};

/// Drawn once and shared.
const ShootAtlas& shoot_atlas(ShootKind kind);

/// Width and height of the pictured bark [m].
inline constexpr double kBarkPictureWidth = 0.7;

/// 256 by 256 pixels, seamless at all edges. To be multiplied with the bark's color: the mean of
/// each channel is 0.8 in linear light. Computed once and shared.
std::shared_ptr<const Texture> bark_texture(BarkKind kind);
/// The normal map that goes with it.
std::shared_ptr<const Texture> bark_normals(BarkKind kind);

}  // namespace silvafit::tree
