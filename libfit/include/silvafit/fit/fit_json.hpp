// SPDX-License-Identifier: MIT
// Fits as JSON, schema silvafit-fit/2, in the output of the program and in model libraries.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "silvafit/data/json_reader.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// A fit as a JSON object; docs/json.md lists its keys, which are always in the same order.
///
/// Numbers are read back as the same doubles; those that are not finite are null.
/// \param indent  blanks per level, or -1 for one line
std::string to_json(const FittedModel& fit, int indent = -1);
/// The object itself.
nlohmann::ordered_json json_of(const FittedModel& fit);

/// The fit of a JSON object, schema silvafit-fit/2. Unknown keys are ignored.
/// \throws InputError with file and key if a key is missing or inconsistent with the others, or a
///   newer version of silvafit wrote it
FittedModel from_json(const data::JsonReader& json);

/// The fit of a text.
/// \param file  source of the text, for messages
/// \throws InputError as above, also if the text is not JSON
FittedModel from_json(std::string_view text, const std::string& file);

}  // namespace silvafit::fit
