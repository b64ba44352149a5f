// SPDX-License-Identifier: MIT
// The axes of a bamboo and the positions of its leaves.
#pragma once

#include "silvafit/tree/bamboo.hpp"

namespace silvafit::tree {

Skeleton grow_bamboo(const TreeShape& shape,
                     const Crown& crown,
                     const BambooPreset& preset,
                     Random& random);

}  // namespace silvafit::tree
