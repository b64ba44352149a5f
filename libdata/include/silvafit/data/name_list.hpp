// SPDX-License-Identifier: MIT
// Names in messages.
#pragma once

#include <string>
#include <string_view>

namespace silvafit::data {

/// A name as an item of a list: in single quotes if it contains a comma.
std::string in_list(std::string_view name);

}  // namespace silvafit::data
