// SPDX-License-Identifier: MIT
// Results on standard output: that they arrive, and as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

namespace silvafit::cli {

/// Prints what the streams still hold. A result that did not arrive is no success, even where the
/// disk filled up in its last lines.
/// \throws IoError if standard output could not be written
void finish_standard_output();

/// Prints a value and a line end.
/// \param indent  blanks a level; -1: all in one line
void print_json_value(const nlohmann::ordered_json& value, int indent = 2);

/// The number, or null if it is not finite.
nlohmann::ordered_json number_or_null(double value);

/// The text, or null if it is empty.
nlohmann::ordered_json text_or_null(std::string_view text);

}  // namespace silvafit::cli
