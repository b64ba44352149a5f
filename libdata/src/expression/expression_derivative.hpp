// SPDX-License-Identifier: MIT
// Symbolic differentiation of expression graphs.
#pragma once

#include <string_view>

#include "expression/expression_node.hpp"

namespace silvafit::data {

/// d node / d variable. Comparisons and sign count as piecewise constant.
NodePointer differentiate(const NodePointer& node, std::string_view variable);

}  // namespace silvafit::data
