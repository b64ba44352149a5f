// SPDX-License-Identifier: MIT
// Scenes of grown trees as scenes of light.
#pragma once

#include "silvafit/render/ray_tracer.hpp"
#include "silvafit/tree/scene_reader.hpp"

namespace silvafit::render {

/// What a file of trees looks like: bark and ground are dull, leaves shine a little and let light
/// through. Parts are told apart by the names that silvafit gives to materials; of other files,
/// open surfaces that are seen from both sides count as leaves.
/// \throws InputError naming the file if it has nothing to draw, or flattens something to a plane
Scene scene_of(const tree::ReadScene& read);

}  // namespace silvafit::render
