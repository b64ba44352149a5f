// SPDX-License-Identifier: MIT
#include "silvafit/tree/builder.hpp"

#include "silvafit/base/error.hpp"

namespace silvafit::tree {

Skeleton Builder::grow_freely(double /*h_m*/, Random& /*random*/) const {
  throw UsageError(
      "the builder " + word_of(kind_) +
      " places branches by the measurements; trees without them need the `builder` lsystem or ifs");
}

TreeShape Builder::shape_of(const Morphology& morphology) const {
  return complete(morphology, preset().relative_hc, "preset " + name());
}

Skeleton FreeBuilder::grow_skeleton(const TreeShape& shape,
                                    const Crown& crown,
                                    Random& random,
                                    const MeshOptions& mesh) const {
  const Skeleton grown = drawn(shape.h_m, !shows_shoots(preset().style, mesh), random);
  try {
    return fit_to_measurements(grown, shape, crown, preset().taper, preset().head);
  } catch (const GeometryError& error) {
    // The drawing causes the error, not the measurements.
    throw GeometryError(error.message(), {.file = file_of(shape.h_m)});
  }
}

Mesh FreeBuilder::build_mesh(const Skeleton& skeleton,
                             const Crown& crown,
                             Random& random,
                             const MeshOptions& options) const {
  return build_smooth_mesh(skeleton, crown, preset().style, random, options);
}

}  // namespace silvafit::tree
