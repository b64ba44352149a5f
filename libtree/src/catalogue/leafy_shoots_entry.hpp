// SPDX-License-Identifier: MIT
// The fields `leafy_shoots` and `bark` of presets.
#pragma once

#include "silvafit/data/json_reader.hpp"
#include "silvafit/tree/leafy_shoots.hpp"

namespace silvafit::tree {

/// \throws InputError naming file and field
LeafyShoots leafy_shoots_of(const data::JsonReader& entry);

/// The field `bark`: smooth (default) or furrowed.
/// \throws InputError naming file and field
BarkKind bark_kind_of(const data::JsonReader& entry);

}  // namespace silvafit::tree
