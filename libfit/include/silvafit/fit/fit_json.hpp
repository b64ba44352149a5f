// SPDX-License-Identifier: MIT
// Fits as JSON, schema silvafit-fit/1: what the program prints and model libraries hold.
#pragma once

#include <string>
#include <string_view>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// A fit as a JSON object; docs/json.md lists its keys, which always come in the same order.
///
/// Numbers read back as the same doubles; those that are not finite are null.
/// \param indent  blanks a level, or -1 for one line
std::string to_json(const FittedModel& fit, int indent = -1);

/// The fit of a JSON object. Keys that are not known are passed over.
/// \param file  where the text is from, for messages
/// \param key   the object's place in the file, such as `models[2].fit`, for messages
/// \throws InputError that names file and key if the text is no JSON, a key is missing or does not
///   fit to the others, or a newer version of silvafit wrote it
FittedModel from_json(std::string_view text, const std::string& file, const std::string& key = "");

}  // namespace silvafit::fit
