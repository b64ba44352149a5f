// SPDX-License-Identifier: MIT
// Stand and growth reports as text tables on standard output.
#pragma once

#include "silvafit/stand/growth.hpp"
#include "silvafit/study/stand_summary.hpp"

namespace silvafit::cli {

void print_stand(const study::StandSummary& summary);

void print_growth(const stand::GrowthReport& report);

}  // namespace silvafit::cli
