// SPDX-License-Identifier: MIT
// From the expression graph back to text.
#pragma once

#include <string>

#include "expression/expression_node.hpp"

namespace silvafit::data {

/// Text with no more parentheses than needed, which parses to the same graph.
std::string text_of(const NodePointer& node);

}  // namespace silvafit::data
