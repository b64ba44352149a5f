// SPDX-License-Identifier: MIT
// Parsing of JSON documents in linear time.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace silvafit::data {

/// The value of a text, the members of objects in their order.
///
/// nlohmann-json's own reader compares each key with those before it, which takes seconds for an
/// object with a member for each of ten thousand plots; this one compares keys when the object is
/// complete.
/// \param comments  whether `//` and `/* */` may explain the values
/// \throws InputError with file and line if this is no JSON, a number in it is too large, or an
///   object has a key twice
nlohmann::ordered_json parse_document(std::string_view text,
                                      const std::string& file,
                                      bool comments);

}  // namespace silvafit::data
