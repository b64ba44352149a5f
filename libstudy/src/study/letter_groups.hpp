// SPDX-License-Identifier: MIT
// Letters that show which of several models differ.
#pragma once

#include <string>
#include <vector>

namespace silvafit::study {

/// Letters of models in an order: two share one if and only if they do not differ.
/// \param differs  (n x n) symmetric
/// Source: Piepho 2004, J. Comput. Graph. Stat. 13, 456-466.
std::vector<std::string> letter_groups(const std::vector<std::vector<bool>>& differs);

}  // namespace silvafit::study
