// SPDX-License-Identifier: MIT
#include "bamboo/bamboo.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bamboo/bamboo_leaves.hpp"

namespace silvafit::tree {
namespace {

/// A narrow leaf, widest at a third of its length, with a long tip.
std::vector<std::array<double, 2>> narrow_outline() {
  return {{0.55, 0.08}, {1.0, 0.32}, {0.45, 0.75}};
}

SmoothStyle style_with_pictures(const BambooPreset& preset) {
  const CulmLeaves& leaves = preset.leaves;
  const PictureRow row = side_by_side(
      leaves.pictures, static_cast<std::size_t>(leaves.picture_size), preset.name + "-leaves");
  SmoothStyle style{.bark = preset.bark};
  for (std::size_t i = 0; i < leaves.pictures.size(); ++i) {
    const auto left = static_cast<double>(i);
    style.leaves.push_back({.form = leaves.form,
                            .aspect = leaves.aspect,
                            .color = {1.0, 1.0, 1.0},
                            .color_variation = 0.0,
                            .texture = row.whole,
                            .picture = {left * row.share, 0.0, (left + 1.0) * row.share, 1.0}});
  }
  return style;
}

SmoothStyle style_of_single_leaves(const BambooPreset& preset) {
  SmoothStyle style{.bark = preset.bark};
  for (const auto& picture : preset.leaves.pictures) {
    style.leaves.push_back({.form = LeafForm::kFivePolygons,
                            .aspect = preset.leaves.leaf_aspect,
                            .outline = narrow_outline(),
                            .color = mean_color(*picture)});
  }
  return style;
}

/// The leaves of a spray: alternately on both sides of its twig, the last one straight ahead.
void add_leaves_of(const LeafSite& spray, const CulmLeaves& leaves, std::vector<LeafSite>& to) {
  const Point across = cross(spray.along, spray.facing);
  for (int i = 0; i < leaves.leaves_per_spray; ++i) {
    const double share = (i + 1.0) / leaves.leaves_per_spray;
    const double turn =
        i + 1 == leaves.leaves_per_spray
            ? 0.0
            : (i % 2 == 0 ? 1.0 : -1.0) * (1.25 - 0.8 * share);  // from across to along
    LeafSite leaf = spray;
    leaf.at = spray.at + (1.0 - leaves.leaf_length) * share * spray.length_m * spray.along;
    leaf.along = std::cos(turn) * spray.along + std::sin(turn) * across;
    leaf.length_m = leaves.leaf_length * spray.length_m;
    to.push_back(leaf);
  }
}

}  // namespace

BambooBuilder::BambooBuilder(BambooPreset preset)
    : Builder(BuilderKind::kBamboo),
      preset_(std::move(preset)),
      pictures_(style_with_pictures(preset_)),
      single_leaves_(style_of_single_leaves(preset_)) {}

Mesh BambooBuilder::build_mesh(const Skeleton& skeleton,
                               const Crown& crown,
                               Random& random,
                               const MeshOptions& options) const {
  if (options.textured) {
    // Branches of bamboo are thin; the pictures show the twigs only.
    constexpr double kThinnestBranch = 0.004;
    MeshOptions drawn = options;
    drawn.thinnest_wood_m = std::min(options.thinnest_wood_m, kThinnestBranch);
    // Culms have many rings, because their nodes stand out.
    constexpr int kCulmSides = 8;
    drawn.stem_sides = std::min(options.stem_sides, kCulmSides);
    // Sprays are thinned like a coarser level of detail if there are too many.
    constexpr std::size_t kMostSprays = 1500;
    drawn.foliage_per *= static_cast<int>(1 + skeleton.leaves.size() / kMostSprays);
    return build_smooth_mesh(skeleton, crown, pictures_, random, drawn);
  }
  Skeleton with_leaves = skeleton;
  with_leaves.leaves.clear();
  with_leaves.leaves.reserve(skeleton.leaves.size() *
                             static_cast<std::size_t>(preset_.leaves.leaves_per_spray));
  for (const LeafSite& spray : skeleton.leaves) {
    add_leaves_of(spray, preset_.leaves, with_leaves.leaves);
  }
  return build_smooth_mesh(with_leaves, crown, single_leaves_, random, options);
}

}  // namespace silvafit::tree
