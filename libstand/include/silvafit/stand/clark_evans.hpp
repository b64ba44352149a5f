// SPDX-License-Identifier: MIT
// The aggregation index of Clark and Evans.
#pragma once

#include <cstddef>
#include <span>

#include "silvafit/stand/window.hpp"

namespace silvafit::stand {

/// R = mean distance to the nearest neighbor / its expectation for random points. Below 1 trees are
/// clustered, above 1 regular.
struct ClarkEvans {
  std::size_t trees = 0;
  double mean_distance_m = 0.0;
  double R = 0.0;           ///< expected 1 / (2 sqrt(density)): without edge correction, too large
  double z = 0.0;           ///< (mean - expected) / standard error, 0.26136 / sqrt(n density)
  double p = 0.0;           ///< two-sided, by the normal distribution
  double R_donnelly = 0.0;  ///< expectation and standard error with Donnelly's edge correction
  double z_donnelly = 0.0;
  double p_donnelly = 0.0;
};

/// Donnelly: expected 0.5 sqrt(A/n) + (0.0514 + 0.0412/sqrt(n)) P/n, variance 0.0703 A/n^2 + 0.037
/// P sqrt(A/n^5), with area A and perimeter P. Derived for rectangles; an approximation for other
/// windows that are not too narrow. All are NaN for fewer than two points.
/// \param points  inside the window
/// Source: Clark and Evans 1954, Ecology 35, 445-453; Donnelly 1978; constants as in Ripley 1981,
/// section 8.2, and spatstat.
ClarkEvans clark_evans(std::span<const Point> points, const Window& window);

}  // namespace silvafit::stand
