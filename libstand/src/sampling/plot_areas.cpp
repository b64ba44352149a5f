// SPDX-License-Identifier: MIT
#include "sampling/plot_areas.hpp"

#include <fmt/format.h>

#include <array>

#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"
#include "units/density_indices.hpp"

namespace silvafit::stand {

double recorded_area_m2(const PlotRecord& record, std::size_t subplots, const std::string& file) {
  const std::array areas{record.area_m2,
                         static_cast<double>(subplots) * circle_area_m2(record.radius_m),
                         kSquareMetersPerHectare / record.expansion};
  double result = data::kMissing;
  for (const double area_m2 : areas) {
    if (std::isnan(area_m2)) continue;
    if (std::isnan(result)) result = area_m2;
    if (is_same_area(area_m2, result)) continue;
    throw InputError(
        fmt::format("area, radius and expansion of the plot do not agree: {:.6g} m2 or {:.6g} m2; "
                    "name the right one, such as `plots_columns=area=COLUMN`",
                    result,
                    area_m2),
        {.file = file, .line = record.line, .plot = record.plot});
  }
  return result;
}

}  // namespace silvafit::stand
