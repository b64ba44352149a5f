// SPDX-License-Identifier: MIT
// Labels of different plots that are probably meant as one plot.
#pragma once

#include <string>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {

/// A note on labels that differ only in case, accents, blanks or leading zeros, such as `001` and
/// `1`: they name different plots, because labels are compared as text. Empty if there are none.
std::string describe_similar_plots(const data::TextColumn& plot);

}  // namespace silvafit::stand
