// SPDX-License-Identifier: MIT
// The common fields of the preset files of all builders.
#pragma once

#include <filesystem>

#include "catalogue/json_entry.hpp"
#include "silvafit/tree/builder.hpp"

namespace silvafit::tree {

/// \param models  the folder with taper/
/// \throws InputError naming file and field
PresetHead preset_head_of(const std::filesystem::path& models, const JsonEntry& entry);

/// The optional field of the same name, 0 if it is absent: FitOptions.
double largest_gap_of(const JsonEntry& entry);

/// Three numbers in [0, 1].
Color color_of(const JsonEntry& entry, const std::string& field);

/// An integer in [low, high].
int whole_number(const JsonEntry& entry, const std::string& field, int low, int high);

}  // namespace silvafit::tree
