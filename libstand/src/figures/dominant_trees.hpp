// SPDX-License-Identifier: MIT
// The thickest of more trees than memory holds.
#pragma once

#include <cstddef>
#include <vector>

#include "figures/figure_sums.hpp"
#include "silvafit/base/external_sort.hpp"
#include "silvafit/stand/stand_summary.hpp"

namespace silvafit::stand {

/// Dominant heights, as set_dominant_height() has them, of all trees and of each species. Trees
/// are sorted on disk by diameter and height; all have the weight 1.
class DominantTrees {
 public:
  void add(double dbh_cm, double h_m, std::size_t species);
  /// Sorts the trees and finds the means; not more than once.
  /// \param wanted  number of trees
  void find(double wanted);
  void set_of_all(StandFigures& figures) const { all_.dominant.set(figures); }
  void set_of_species(std::size_t species, StandFigures& figures) const;

 private:
  /// Trees of one group; of the thickest only sums are kept.
  struct Group {
    std::size_t trees = 0;
    DominantSums dominant{};
  };

  ExternalSort sorted_{std::size_t{16} << 20U};
  Group all_{};
  std::vector<Group> by_species_{};
};

}  // namespace silvafit::stand
