// SPDX-License-Identifier: MIT
// What presets say about the looks of bark and leaves.
#pragma once

#include "catalogue/json_entry.hpp"
#include "silvafit/tree/smooth_mesh.hpp"

namespace silvafit::tree {

/// A leaf without a picture: form (five-polygons or needle-fan), aspect, color, color_variation and
/// perhaps outline.
/// \throws InputError naming file and field
LeafLook leaf_look_of(const JsonEntry& entry);

/// The picture of the bark: the field `bark`, smooth (also where it is missing) or furrowed.
/// \throws InputError naming file and field
std::shared_ptr<const Texture> bark_picture_of(const JsonEntry& entry);

}  // namespace silvafit::tree
