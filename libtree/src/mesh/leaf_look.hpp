// SPDX-License-Identifier: MIT
// Fields of presets for the appearance of leaves without pictures.
#pragma once

#include "silvafit/data/json_reader.hpp"
#include "silvafit/tree/smooth_mesh.hpp"

namespace silvafit::tree {

/// A leaf without an image: form (five-polygons or needle-fan), aspect, color, color_variation and
/// optionally outline.
/// \throws InputError naming file and field
LeafLook leaf_look_of(const data::JsonReader& entry);

}  // namespace silvafit::tree
