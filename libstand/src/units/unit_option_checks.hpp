// SPDX-License-Identifier: MIT
// Checks that the options of structural units are in range and suit the inventory.
#pragma once

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/structural_units.hpp"

namespace silvafit::stand {

/// \throws UsageError if an option is out of range, or the inventory lacks a needed column
void check_unit_options(const Inventory& inventory, const StructuralUnitOptions& options);

}  // namespace silvafit::stand
