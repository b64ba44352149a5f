// SPDX-License-Identifier: MIT
// Neighboring trees for the tests of stands.
#pragma once

#include <vector>

#include "test_support/tree_test_support.hpp"

namespace silvafit::test {

/// Trees 10 and 13 of the Chinese fir plot in the segment-model paper (tables 3 and 4).
inline tree::Morphology paper_tree_10() {
  return {.plot = "paper",
          .tree = "10",
          .species = "Cunninghamia lanceolata",
          .position = {4252.617, 70207.551, -4.304},
          .dbh_cm = 24.0,
          .h_m = 19.1,
          .hcb_m = 8.0,
          .hc_m = 14.0,
          .radii = tree::CrownRadii{1.6, 1.2, 1.7, 1.4}};
}
inline tree::Morphology paper_tree_13() {
  return {.plot = "paper",
          .tree = "13",
          .species = "Cunninghamia lanceolata",
          .position = {4252.891, 70204.877, -3.589},
          .dbh_cm = 25.0,
          .h_m = 21.0,
          .hcb_m = 5.2,
          .hc_m = 14.5,
          .radii = tree::CrownRadii{1.4, 1.9, 2.8, 1.7}};
}

}  // namespace silvafit::test
