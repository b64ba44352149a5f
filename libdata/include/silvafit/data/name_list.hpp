// SPDX-License-Identifier: MIT
// Names in messages.
#pragma once

#include <string>
#include <string_view>

namespace silvafit::data {

/// A name in a list of names: in single quotes if it has a comma.
std::string in_list(std::string_view name);

}  // namespace silvafit::data
