// SPDX-License-Identifier: MIT
// Tables of the USDA Forest Service's Forest Inventory and Analysis (FIA).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {

/// Whether a header is that of FIA's table TREE or of a selection from it: DIA, and either SPCD
/// with HT or ACTUALHT, or two of STATUSCD, SPCD, PLT_CN, SUBP, TPA_UNADJ and DIAHTCD, in any case.
bool is_fia_tree_table(const std::vector<std::string>& header);

/// The sources of standard columns in FIA's table TREE, with FIA's meaning. Units are not part of
/// them: see fia_unit(). None for another table.
///
/// plot: the visit PLT_CN, or the location STATECD+UNITCD+COUNTYCD+PLOT. tree: SUBP+TREE, else CN.
/// species: SPCD. status: STATUSCD. year: INVYR. expansion: TPA_UNADJ per hectare. x and y [m] from
/// the center of the plot: AZIMUTH and DIST from the center of the subplot SUBP or, for trees below
/// 5 in, of its microplot. Subplots 2, 3 and 4 are 120 ft from subplot 1 at 360, 120 and 240
/// degrees, microplots 12 ft east of the center of their subplot.
/// Source: Bechtold and Patterson 2005, GTR SRS-80, chapter 2; FIADB User Guide, table TREE.
/// \param by_location  whether rows of several visits belong to one plot
std::vector<ColumnMapping> fia_columns(const std::vector<std::string>& header, bool by_location);

/// `in` or `ft` for a column of FIA's table TREE that is a length; empty for others.
std::string_view fia_unit(std::string_view column);

/// The column with the label of a plot visit in FIA's tables PLOT, COND and others: PLT_CN, or CN
/// of PLOT itself. None for a table of another kind.
std::optional<std::string> fia_plot_column(const std::vector<std::string>& header);

}  // namespace silvafit::stand
