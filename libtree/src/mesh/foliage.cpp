// SPDX-License-Identifier: MIT
#include "mesh/foliage.hpp"

namespace silvafit::tree {

void add_foliage(const Skeleton& skeleton,
                 const Crown& crown,
                 const Foliage& foliage,
                 Random& random,
                 const MeshOptions& options,
                 PartBuilder& build) {
  if (foliage.kind == FoliageKind::kNeedles) {
    add_needles(skeleton, crown, foliage, random, options, build);
  } else {
    add_leaves(skeleton, crown, foliage, random, options, build);
  }
}

}  // namespace silvafit::tree
