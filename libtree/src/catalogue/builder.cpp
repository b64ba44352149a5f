// SPDX-License-Identifier: MIT
#include "silvafit/tree/builder.hpp"

#include <algorithm>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {

const std::vector<BuilderKind>& builder_kinds() {
  static const std::vector<BuilderKind> kinds{
      BuilderKind::kSegment, BuilderKind::kLsystem, BuilderKind::kIfs, BuilderKind::kBamboo};
  return kinds;
}

const char* builder_name(BuilderKind kind) {
  switch (kind) {
    case BuilderKind::kSegment:
      return "segment";
    case BuilderKind::kLsystem:
      return "lsystem";
    case BuilderKind::kIfs:
      return "ifs";
    case BuilderKind::kBamboo:
      return "bamboo";
  }
  return "";
}

BuilderKind builder_from_text(std::string_view text) {
  std::string names;
  for (const BuilderKind kind : builder_kinds()) {
    if (text == builder_name(kind)) return kind;
    names += (names.empty() ? "" : ", ") + std::string(builder_name(kind));
  }
  throw UsageError("unknown builder '" + std::string(text) + "'; available: " + names);
}

Builder::Builder(BuilderKind kind, PresetHead preset) : kind_(kind), preset_(std::move(preset)) {}

Skeleton Builder::grow_skeleton_for(const MeshOptions& /*mesh*/,
                                    const TreeShape& shape,
                                    const Crown& crown,
                                    Random& random) const {
  return grow_skeleton(shape, crown, random);
}

Skeleton Builder::grow_freely(double /*h_m*/, Random& /*random*/) const {
  throw UsageError(
      "the builder " + std::string(builder_name(kind_)) +
      " places branches by the measurements; trees without them need the `builder` lsystem or ifs");
}

TreeShape Builder::shape_of(const Morphology& morphology) const {
  return complete(morphology, preset_.relative_hc, "preset " + preset_.name);
}

namespace {

Color middle_of(const Color& a, const Color& b) {
  return {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])};
}

}  // namespace

SegmentBuilder::SegmentBuilder(const Preset& preset)
    : Builder(BuilderKind::kSegment,
              {.name = preset.name,
               .title = preset.title,
               .species = preset.species,
               .crown_index = preset.crown_index,
               .relative_hc = preset.relative_hc,
               .taper = preset.taper,
               .bark = preset.bark.color,
               .leaf = middle_of(preset.foliage.inner, preset.foliage.outer)}),
      segments_(preset) {}

Skeleton SegmentBuilder::grow_skeleton(const TreeShape& shape,
                                       const Crown& crown,
                                       Random& random) const {
  return tree::grow_skeleton(shape, crown, segments_, random);
}

Mesh SegmentBuilder::build_mesh(const Skeleton& skeleton,
                                const Crown& crown,
                                Random& random,
                                const MeshOptions& options) const {
  return tree::build_mesh(skeleton, crown, segments_, random, options);
}

}  // namespace silvafit::tree
