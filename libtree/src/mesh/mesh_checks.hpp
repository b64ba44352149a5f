// SPDX-License-Identifier: MIT
// Checks of options and results that all mesh functions share.
#pragma once

#include <initializer_list>

#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// \throws UsageError if an option is out of range
void check_options(const MeshOptions& options);

/// \throws GeometryError if a coordinate is not finite
void check_finite(const MeshPart& part);

/// Moves the parts that have triangles into the mesh.
/// \throws as check_finite()
void take_parts(Mesh& mesh, std::initializer_list<MeshPart*> parts);

}  // namespace silvafit::tree
