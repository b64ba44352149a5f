// SPDX-License-Identifier: MIT
#include "silvafit/tree/bamboo.hpp"

#include "bamboo_skeleton.hpp"

namespace silvafit::tree {

BambooBuilder::BambooBuilder(BambooPreset preset)
    : Builder(BuilderKind::kBamboo, preset.head), style_(std::move(preset)) {}

Skeleton BambooBuilder::grow_skeleton(const TreeShape& shape,
                                      const Crown& crown,
                                      Random& random) const {
  return grow_bamboo(shape, crown, style_, random);
}

Mesh BambooBuilder::build_mesh(const Skeleton& skeleton,
                               const Crown& crown,
                               Random& random,
                               const MeshOptions& options) const {
  SmoothStyle style{.bark = style_.culm_color};
  for (const auto& picture : style_.leaves.pictures) {
    style.leaves.push_back({.form = style_.leaves.form,
                            .aspect = style_.leaves.aspect,
                            .color = {1.0, 1.0, 1.0},
                            .color_variation = 0.0,
                            .texture = picture});
  }
  return build_smooth_mesh(skeleton, crown, style, random, options);
}

}  // namespace silvafit::tree
