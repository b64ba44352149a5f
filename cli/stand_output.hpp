// SPDX-License-Identifier: MIT
// Stand and growth reports as text tables on standard output.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/stand/growth.hpp"
#include "silvafit/study/stand_summary.hpp"

namespace silvafit::cli {

using Tables = std::vector<std::pair<std::string, data::Table>>;

/// \param tables  of the summary
void print_stand(const study::StandSummary& summary, const Tables& tables);

/// \param tables  of the report
void print_growth(const stand::GrowthReport& report, const Tables& tables);

}  // namespace silvafit::cli
