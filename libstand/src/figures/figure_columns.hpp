// SPDX-License-Identifier: MIT
// The values of stands and strata with their names in tables and JSON.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "silvafit/stand/stand_summary.hpp"

namespace silvafit::stand {

/// A value of StandFigures with its name.
struct FigureColumn {
  std::string_view name{};
  double StandFigures::*value = nullptr;
};

/// From the area to the crown cover; numbers of trees and quantities are not among them.
inline constexpr std::array<FigureColumn, 13> kFigureColumns{
    {{"area_ha", &StandFigures::area_ha},
     {"stems_per_ha", &StandFigures::stems_per_ha},
     {"basal_area_m2_per_ha", &StandFigures::basal_area_m2_per_ha},
     {"mean_dbh_cm", &StandFigures::mean_dbh_cm},
     {"sd_dbh_cm", &StandFigures::sd_dbh_cm},
     {"quadratic_mean_dbh_cm", &StandFigures::quadratic_mean_dbh_cm},
     {"mean_height_m", &StandFigures::mean_height_m},
     {"sd_height_m", &StandFigures::sd_height_m},
     {"lorey_height_m", &StandFigures::lorey_height_m},
     {"dominant_height_m", &StandFigures::dominant_height_m},
     {"dominant_lorey_height_m", &StandFigures::dominant_lorey_height_m},
     {"dominant_dbh_cm", &StandFigures::dominant_dbh_cm},
     {"crown_cover_percent", &StandFigures::crown_cover_percent}}};

nlohmann::ordered_json json_of(const Estimate& estimate);

}  // namespace silvafit::stand
