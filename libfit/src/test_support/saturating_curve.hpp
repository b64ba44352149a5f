// SPDX-License-Identifier: MIT
// Data of a curve whose coefficients are strongly correlated.
#pragma once

#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::fit {

/// Thirty values of the curve 20 (1 - exp(-0.08 x)), simulated far below its asymptote: a ridge of
/// A and k.
inline data::Table saturating() {
  data::Table table;
  table.set("x", std::vector<double>{7.51, 4.79, 6.57, 6.85, 3.85, 6.69, 5.99, 7.13, 5.36, 3.7,
                                     4.63, 9.26, 2.28, 1.91, 0.62, 8.6,  9.89, 2.75, 3.03, 2.38,
                                     6.2,  5.11, 8.3,  2.49, 8.84, 4.91, 8.17, 8.12, 9.15, 5.24});
  table.set("y",
            std::vector<double>{8.6955,  7.2127, 8.6761, 8.4578,  5.8873, 8.7045, 7.5440,  9.2023,
                                7.8742,  5.2885, 5.9415, 10.9685, 4.6651, 2.6866, 0.9032,  9.8529,
                                11.7901, 2.6636, 4.5612, 4.3020,  7.2514, 7.7533, 10.0790, 3.2280,
                                10.2824, 5.4226, 9.2007, 10.8337, 9.7554, 8.1397});
  return table;
}

}  // namespace silvafit::fit
