// SPDX-License-Identifier: MIT
// Computed textures of bark and of leafy shoots.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {

/// Color relative to that of the material, linear.
using Tint = std::array<double, 3>;

/// The form of a blade between its base (0) and its tip (1).
struct Blade {
  /// Half width at a share of the length: (share / peak)^rise ((1 - share) / (1 - peak))^fall,
  /// which is 1 at the peak.
  double rise = 0.7;
  double fall = 0.9;
  /// Or an outline on one side, (half width, share), from the base to the tip; then the above is
  /// not used.
  std::vector<std::array<double, 2>> outline{};
  double veins = 7.0;      ///< side veins on each side; 0 for none
  double vein_rise = 0.5;  ///< how far they run towards the tip, relative to the half width
};

/// How a leafy shoot is drawn (models/shoots/*.json). Lengths are relative to the picture.
struct ShootPlan {
  std::string name{};
  int seed = 0;
  Blade blade{};
  double leaf_length = 0.17;
  double leaf_aspect = 0.45;
  double spacing = 0.05;     ///< between leaves, between pairs, or between whorls
  bool is_opposite = false;  ///< pairs instead of alternating leaves
  int whorl = 0;  ///< leaves of a node all around the twig, seen from the side; 0: two ranks
  double angle_deg = 55.0;  ///< between leaf and twig at its base; half of that at the tip
  double angle_sd_deg = 9.0;
  double bare = 0.12;  ///< proportion of a twig without leaves
  int side_twigs = 8;
  double side_length = 0.5;
  double side_angle_deg = 47.0;
  double droop = 0.0;  ///< how far side twigs and leaves turn down, radians a length
  double bend = 0.05;  ///< standard deviation of the bend of leaves, relative to their length
  double twig_width = 0.011;
  double shade_sd = 0.11;
  double warmth_sd = 0.16;
  double shadow = 0.3;
  Tint twig{0.85, 0.5, 0.75};
};

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

/// A picture of shoots, drawn when it is first needed.
class ShootPicture {
 public:
  explicit ShootPicture(ShootPlan plan) : plan_(std::move(plan)) {}

  const std::string& name() const { return plan_.name; }
  const ShootAtlas& leafy() const;
  /// The same twigs without leaves, as in winter. To be multiplied with the color of bark.
  const ShootAtlas& bare() const;

 private:
  ShootPlan plan_;
  mutable std::array<std::once_flag, 2> once_{};
  mutable std::array<ShootAtlas, 2> atlases_{};
};

/// A layer of bark: where its pattern is, it changes height and color.
struct BarkLayer {
  enum class Pattern {
    kNoise,   ///< spots of smooth noise
    kRidges,  ///< lines along which noise crosses its mean
    kDashes,  ///< short lines around the stem
  };
  Pattern pattern = Pattern::kNoise;
  int across = 8;  ///< cells of the pattern around the picture
  int along = 4;
  int octaves = 3;
  double swerve = 0.0;  ///< how far lines wander sideways
  /// The layer has no effect where the pattern's value is `from`, and its full effect at `to`.
  double from = 0.3;
  double to = 0.7;
  double height = 0.0;  ///< added, relative to the ridges' height
  Tint tint{1.0, 1.0, 1.0};
};

/// How bark is drawn (models/bark/*.json): layers from the inside to the outside.
struct BarkPlan {
  std::string name{};
  double width_m = 0.7;  ///< of the picture, which is twice as high
  double relief = 0.02;  ///< height of the ridges relative to the picture's width
  bool has_roots = true;
  std::vector<BarkLayer> layers{};
};

/// Bark in a picture of 256 by 512 pixels, seamless at all edges, drawn when it is first needed. To
/// be multiplied with the bark's color: the mean of each channel is 0.6 in linear light.
class BarkPicture {
 public:
  explicit BarkPicture(BarkPlan plan) : plan_(std::move(plan)) {}

  const std::string& name() const { return plan_.name; }
  double width_m() const { return plan_.width_m; }
  /// Whether the stem widens at its foot into roots.
  bool has_roots() const { return plan_.has_roots; }
  std::shared_ptr<const Texture> color() const { return drawn().front(); }
  std::shared_ptr<const Texture> normals() const { return drawn().back(); }

 private:
  const std::array<std::shared_ptr<const Texture>, 2>& drawn() const;

  BarkPlan plan_;
  mutable std::once_flag once_{};
  mutable std::array<std::shared_ptr<const Texture>, 2> pictures_{};
};

}  // namespace silvafit::tree
