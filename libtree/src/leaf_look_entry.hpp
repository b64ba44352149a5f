// SPDX-License-Identifier: MIT
// What leaves look like, as presets say it.
#pragma once

#include <vector>

#include "json_entry.hpp"
#include "silvafit/tree/smooth_mesh.hpp"

namespace silvafit::tree {

/// The looks in the list `leaves` of a preset, by grade; none if the list is empty.
/// \throws InputError naming file and field
std::vector<LeafLook> leaf_looks_of(const JsonEntry& preset);

}  // namespace silvafit::tree
