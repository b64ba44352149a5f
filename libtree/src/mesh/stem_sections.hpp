// SPDX-License-Identifier: MIT
// Sections of a mesh's stem.
#pragma once

#include <span>
#include <vector>

#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// Diameters of the circles with the areas of the stem's sections at these heights [cm]; 0 if
/// there is no stem.
/// \param heights_m  in any order
std::vector<double> stem_diameters_cm(const Mesh& mesh, std::span<const double> heights_m);

}  // namespace silvafit::tree
