// SPDX-License-Identifier: MIT
// JSON values as text.
#pragma once

#include <string>

namespace silvafit {

/// The text of a JSON value, always UTF-8.
///
/// File names and arguments of the command line may contain any bytes. Bytes that are not UTF-8
/// become U+FFFD, so that a file with such a name can be used. Numbers that are not finite become
/// null.
/// \param value   of a class of nlohmann-json, which this header does not include
/// \param indent  spaces per level; -1: all in one line
template <class Json>
std::string json_text(const Json& value, int indent = -1) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace silvafit
