// SPDX-License-Identifier: MIT
#include "silvafit/tree/builder.hpp"

#include "silvafit/base/error.hpp"

namespace silvafit::tree {

Builder::Builder(BuilderKind kind, PresetHead preset) : kind_(kind), preset_(std::move(preset)) {}

Skeleton Builder::grow_freely(double /*h_m*/, Random& /*random*/) const {
  throw UsageError(
      "the builder " + word_of(kind_) +
      " places branches by the measurements; trees without them need the `builder` lsystem or ifs");
}

TreeShape Builder::shape_of(const Morphology& morphology) const {
  return complete(morphology, preset_.relative_hc, "preset " + preset_.name);
}

SegmentBuilder::SegmentBuilder(Preset preset)
    : Builder(BuilderKind::kSegment, preset), segments_(std::move(preset)) {}

Skeleton SegmentBuilder::grow_skeleton(const TreeShape& shape,
                                       const Crown& crown,
                                       Random& random,
                                       const MeshOptions& /*mesh*/) const {
  return tree::grow_skeleton(shape, crown, segments_, random);
}

Mesh SegmentBuilder::build_mesh(const Skeleton& skeleton,
                                const Crown& crown,
                                Random& random,
                                const MeshOptions& options) const {
  return tree::build_mesh(skeleton, crown, segments_, random, options);
}

FreeBuilder::FreeBuilder(BuilderKind kind, const FreePreset& preset)
    : Builder(kind, preset), fit_(preset.fit), style_(preset.style) {}

Skeleton FreeBuilder::grow_skeleton(const TreeShape& shape,
                                    const Crown& crown,
                                    Random& random,
                                    const MeshOptions& mesh) const {
  const Skeleton grown = drawn(shape.h_m, !shows_shoots(style_, mesh), random);
  try {
    return fit_to_measurements(grown, shape, crown, preset().taper, fit_);
  } catch (const GeometryError& error) {
    // The drawing causes the error, not the measurements.
    throw GeometryError(error.message(), {.file = file_of(shape.h_m)});
  }
}

Mesh FreeBuilder::build_mesh(const Skeleton& skeleton,
                             const Crown& crown,
                             Random& random,
                             const MeshOptions& options) const {
  return build_smooth_mesh(skeleton, crown, style_, random, options);
}

}  // namespace silvafit::tree
