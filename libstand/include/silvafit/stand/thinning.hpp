// SPDX-License-Identifier: MIT
// Thinning by a rule: the stand before, what is removed, and the stand after.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "silvafit/stand/stand_report.hpp"

namespace silvafit::stand {

/// Which trees of a plot are removed.
struct ThinningRule {
  enum class Kind {
    kBelow,   ///< the thinnest, as long as the target basal area remains
    kAbove,   ///< the thickest
    kMarked,  ///< those with a number other than 0 in a column
  };
  Kind kind = Kind::kBelow;
  double basal_area_m2_per_ha = 0.0;  ///< that remains, or more by less than the next tree
  std::string column{};               ///< of Inventory::other
};

/// Reads `below=20`, `above=20` or `marked=COLUMN`.
/// \throws UsageError if it is none of these
ThinningRule parse_thinning(std::string_view text);

/// A plot, or all plots together.
struct ThinningFigures {
  std::string name{};
  StandFigures before{};
  StandFigures removed{};
  StandFigures after{};
};

struct Thinning {
  std::vector<char> is_removed{};  ///< by tree of the inventory
  std::vector<ThinningFigures> plots{};
  ThinningFigures all{};
};

/// \param report  of the inventory, not read in parts
/// \throws InputError if the column of marked trees has no numbers
Thinning thin(const Inventory& inventory, const StandReport& report, const ThinningRule& rule);

}  // namespace silvafit::stand
