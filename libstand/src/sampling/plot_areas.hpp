// SPDX-License-Identifier: MIT
// Areas of plots by the table of plots.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/stand/plot_table.hpp"
#include "silvafit/stand/plot_windows.hpp"

namespace silvafit::stand {

/// Basal area per hectare that no forest has [m2]; the densest known ones have about 450.
inline constexpr double kImpossibleBasalArea = 1000.0;

inline double circle_area_m2(double radius_m) { return std::numbers::pi * radius_m * radius_m; }

/// Whether two areas are equal but for rounding: a radius from 2 m on, written with one decimal, is
/// within 2.5 % of the exact one, and its area within 5 %.
inline bool is_same_area(double left_m2, double right_m2) {
  constexpr double kRounded = 0.05;
  return std::abs(left_m2 - right_m2) <= kRounded * right_m2;
}

/// The area of a whole plot by its area, radius or expansion factor; NaN if it has none.
/// \throws InputError if these do not agree
double recorded_area_m2(const PlotRecord& record, std::size_t subplots, const std::string& file);

/// The one area or window that is that of every plot; 0 if there is none.
double area_of_every_plot_m2(const std::optional<double>& plot_area_m2,
                             const std::vector<NamedWindow>& windows);

/// Checks a table of plots beside areas that are given otherwise, by `plot_area` or windows.
/// \throws UsageError if it has shares, which are not applied to these; InputError if it has
///   another area for a plot
void check_table_beside_areas(const PlotTable& table, const std::vector<SampledArea>& areas);

}  // namespace silvafit::stand
