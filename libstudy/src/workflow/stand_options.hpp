// SPDX-License-Identifier: MIT
// The settings of stand tables and of growth converted to options of libstand.
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

/// Adds columns of the file as quantities.
/// \throws InputError if one is not a column of numbers
void add_totals(const std::vector<std::string>& columns, stand::Inventory& inventory);

/// The numbers of trees without a value.
std::vector<std::string> notes_on_totals(const StandOptions& options,
                                         const stand::StandReport& report);

/// Adds the notes on equations and on the table of plots to those of a report, and passes all
/// to the caller.
/// \return those of the inventory and of the report
std::vector<std::string> complete_notes(const stand::StandReportOptions& options,
                                        const std::vector<std::string>& on_equations,
                                        const std::vector<std::string>& on_inventory,
                                        std::vector<std::string>& notes,
                                        const Callbacks& callbacks);

}  // namespace silvafit::study
