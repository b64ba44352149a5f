// SPDX-License-Identifier: MIT
// JSON as text, the same way everywhere.
#pragma once

#include <string>

namespace silvafit {

/// The text of a JSON value, always UTF-8.
///
/// Names of files and words of the command line may hold any bytes. Bytes that are not UTF-8 become
/// U+FFFD, so that a file with such a name can be studied like any other. Numbers that are not
/// finite become null.
/// \param value   of the classes of nlohmann-json, which this header need not know
/// \param indent  blanks a level; -1: all in one line
template <class Json>
std::string json_text(const Json& value, int indent = -1) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace silvafit
