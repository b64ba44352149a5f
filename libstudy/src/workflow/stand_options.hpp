// SPDX-License-Identifier: MIT
// The settings of stand tables and of growth as options of libstand.
#pragma once

#include <string>
#include <vector>

#include "silvafit/study/stand_summary.hpp"

namespace silvafit::study {

/// With windows and the table of plots read.
/// \throws UsageError if settings cannot be used
stand::StandReportOptions report_options(const StandOptions& options);

/// Columns of the inventory that are needed besides ours.
std::vector<std::string> columns_of(const StandOptions& options);

/// Adds the quantities of the equations to the trees.
/// \return notes
std::vector<std::string> add_quantities(const StandOptions& options, stand::Inventory& inventory);

/// Adds which columns of the table of plots were recognized, as the first note.
void add_note_on_plots(const stand::StandReportOptions& options, std::vector<std::string>& notes);

}  // namespace silvafit::study
