// SPDX-License-Identifier: MIT
// Areas of a window less a margin, for many margins at once.
#pragma once

#include <vector>

#include "silvafit/stand/window.hpp"

namespace silvafit::stand {

/// Window::eroded_area_m2 of each margin, or a parabola between margins with an error of less than
/// 1e-4 of the area.
///
/// The area of a polygon is piecewise a parabola between the margins at which an edge or an arc
/// vanishes, where it has a kink. Panels are halved until the parabola through both ends and the
/// middle is right at the quarter points; a few margins are computed one by one, also where the
/// area is small.
/// \param margins_m  (N) in any order, each >= 0
/// \return           (N) areas [m2], >= 0
/// Cost: some 100 areas and a few more for each kink, for any N.
std::vector<double> eroded_areas_m2(const Window& window, const std::vector<double>& margins_m);

}  // namespace silvafit::stand
