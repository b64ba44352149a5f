// SPDX-License-Identifier: MIT
// Labels of plots that look like those of one plot.
#pragma once

#include <string>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {

/// A note on labels that differ only in capitals, accents, blanks or zeros before a number, such as
/// `001` and `1`: they are those of different plots, since labels are compared as text. Empty if
/// there are none.
std::string describe_similar_plots(const data::TextColumn& plot);

}  // namespace silvafit::stand
