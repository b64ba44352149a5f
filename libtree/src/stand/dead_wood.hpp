// SPDX-License-Identifier: MIT
// What is left of dead and cut trees: snags, stumps, logs.
#pragma once

#include "silvafit/base/random.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// Height of a stump [m]: one foot, above which FIA counts volumes of stems.
inline constexpr double kStumpHeight = 0.3;

/// Makes the shape of a snag with a broken top that of the tree before it broke, of which the
/// measured height is the lower part. Notes tell what was assumed.
void stand_before_breaking(const Morphology& morphology, TreeShape& shape);

/// The wood that is left of a grown tree: its stem up to the measured height of a snag, up to
/// kStumpHeight, or all of a log; and the branches of a snag by its decay class.
///
/// Decay classes of standing dead trees of FIA, as in Domke, Woodall, Smith 2011 (Carbon Balance
/// and Management 6:14, table 1): 1, all branches, pointed top; 2, few branches and no fine ones,
/// broken top; 3, stubs; 4 and 5, none.
Skeleton remains_of(const Morphology& morphology, const Skeleton& skeleton);

/// Turns a standing stem on its base to the ground, towards a random azimuth.
void lay_down(Mesh& mesh, Random& random);

}  // namespace silvafit::tree
