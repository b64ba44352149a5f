// SPDX-License-Identifier: MIT
// A stand report as text tables on standard output.
#pragma once

#include "silvafit/stand/stand_report.hpp"

namespace silvafit::cli {

void print_stand(const stand::StandReport& report);

}  // namespace silvafit::cli
