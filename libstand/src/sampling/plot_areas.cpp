// SPDX-License-Identifier: MIT
#include "sampling/plot_areas.hpp"

#include <fmt/format.h>

#include <algorithm>
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

double area_of_every_plot_m2(const std::optional<double>& plot_area_m2,
                             const std::vector<NamedWindow>& windows) {
  const auto every = std::ranges::find(windows, kEveryPlot, &NamedWindow::plot);
  return every != windows.end() ? every->window.area_m2() : plot_area_m2.value_or(0.0);
}

void check_table_beside_areas(const PlotTable& table, const std::vector<SampledArea>& areas) {
  for (const PlotRecord& record : table.plots) {
    const Place place{.file = table.file, .line = record.line, .plot = record.plot};
    if (!std::isnan(record.share) && record.share != 1.0) {
      Place of_share = place;
      of_share.column = "share";
      throw UsageError(
          "the column share of the table of plots is not applied to areas of `plot_area`, `window` "
          "or `circle`; give the areas in the table instead",
          of_share);
    }
    const auto area = std::ranges::find(areas, record.plot, &SampledArea::name);
    const double area_m2 = recorded_area_m2(record, 1, table.file);
    if (area == areas.end() || std::isnan(area_m2) || is_same_area(area_m2, area->area_m2)) {
      continue;
    }
    throw InputError(
        fmt::format("the plot has {:.6g} m2 in the table of plots, and {:.6g} m2 by `plot_area`, "
                    "`window` or `circle`; omit one of them",
                    area_m2,
                    area->area_m2),
        place);
  }
}

}  // namespace silvafit::stand
