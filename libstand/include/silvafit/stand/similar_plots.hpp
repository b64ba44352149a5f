// SPDX-License-Identifier: MIT
// Different labels that are probably meant as one, and labels that are codes of missing values.
#pragma once

#include <string>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {

/// A note on labels that differ only in case, accents, blanks, leading zeros or needless decimals,
/// such as `001`, `1` and `1.0`: labels are compared as text. Also on -9999 and n/a, codes
/// of missing values in columns of numbers. Empty if there are none.
/// \param of  what the labels name
std::string describe_similar_labels(const data::TextColumn& labels, const std::string& of = "plot");

}  // namespace silvafit::stand
