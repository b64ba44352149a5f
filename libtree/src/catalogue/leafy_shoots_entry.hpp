// SPDX-License-Identifier: MIT
// The fields of presets that name pictures of shoots and of bark.
#pragma once

#include <filesystem>

#include "silvafit/data/json_reader.hpp"
#include "silvafit/tree/preset.hpp"

namespace silvafit::tree {

/// The picture of models/shoots/. Presets that name the same one share it.
/// \throws InputError naming file and field
std::shared_ptr<const ShootPicture> shoot_picture(const std::filesystem::path& file);

/// The picture of models/bark/. Presets that name the same one share it.
/// \throws InputError naming file and field
std::shared_ptr<const BarkPicture> bark_picture(const std::filesystem::path& file);

/// \param models  the folder with shoots/
/// \throws InputError naming file and field
LeafyShoots leafy_shoots_of(const std::filesystem::path& models, const data::JsonReader& entry);

/// The fields `bark_color`, `bark` and `bark_by_diameter` of a preset.
/// \param models  the folder with bark/
/// \throws InputError naming file and field
Bark bark_of(const std::filesystem::path& models, const data::JsonReader& entry);

}  // namespace silvafit::tree
