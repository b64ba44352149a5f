// SPDX-License-Identifier: MIT
// Stem volume by a taper equation.
#pragma once

#include "silvafit/tree/taper.hpp"

namespace silvafit::tree {

/// Volume of the stem from the ground to the tip [m3]: the integral of the cross section
/// pi/4 d(x)^2 by Gauss and Legendre's rule of 5 points on 4 parts below breast height and 12
/// above.
/// \param h_m     > 1.3
/// \param dbh_cm  > 0
/// \throws NumericalError as Taper::diameters_cm
double stem_volume_m3(const Taper& taper, double h_m, double dbh_cm);

}  // namespace silvafit::tree
