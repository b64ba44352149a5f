// SPDX-License-Identifier: MIT
// Stand and growth reports as text tables on standard output.
#pragma once

#include "silvafit/stand/growth.hpp"
#include "silvafit/stand/stand_report.hpp"

namespace silvafit::cli {

void print_stand(const stand::StandReport& report);

void print_growth(const stand::GrowthReport& report);

}  // namespace silvafit::cli
