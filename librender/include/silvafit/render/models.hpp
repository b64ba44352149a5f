// SPDX-License-Identifier: MIT
// Ray tracing of scenes of grown trees.
#pragma once

#include "silvafit/render/ray_tracer.hpp"
#include "silvafit/tree/scene_reader.hpp"

namespace silvafit::render {

/// The materials of a file of trees: bark and ground are diffuse, leaves reflect a little and let
/// light through. Parts are identified by the material names of silvafit; in other files,
/// double-sided open surfaces are treated as leaves.
/// \throws InputError naming the file if it has nothing to draw, or a transform flattens an object
Scene scene_of(const tree::ReadScene& read);

}  // namespace silvafit::render
