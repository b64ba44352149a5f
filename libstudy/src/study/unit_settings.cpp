// SPDX-License-Identifier: MIT
#include "silvafit/study/unit_settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/study/idle_settings.hpp"
#include "silvafit/study/setting_list.hpp"

namespace silvafit::study {
namespace {

double number_in(std::string_view text, const char* field, std::string_view what) {
  double value = 0.0;
  if (data::parse_number(data::trimmed(text), value)) return value;
  throw UsageError(fmt::format("'{}' is not {}", text, what), {.column = field});
}

void set_limit_angles(const std::vector<std::string>& alpha,
                      stand::StructuralUnitOptions& options) {
  constexpr std::string_view kWhat = "an angle in degrees, or SPECIES=ANGLE";
  for (const std::string& part : alpha) {
    const std::size_t sign = part.rfind('=');
    if (sign == std::string::npos) {
      options.alpha0_deg = number_in(part, "`alpha`", kWhat);
    } else {
      options.alpha0_deg_of_species.emplace_back(
          part.substr(0, sign), number_in(part.substr(sign + 1), "`alpha`", kWhat));
    }
  }
}

/// The same circle for every plot, in the plot's own coordinates.
stand::NamedWindow circle_of_every_plot(const std::string& text) {
  constexpr std::string_view kWhat = "X,Y,RADIUS in m, such as 0,0,12.62";
  std::vector<double> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    numbers.push_back(
        number_in(std::string_view(text).substr(begin, end - begin), "`circle`", kWhat));
    begin = end + 1;
  }
  if (numbers.size() != 3) {
    throw UsageError(fmt::format("'{}' is not {}", text, kWhat), {.column = "`circle`"});
  }
  return {.plot = stand::kEveryPlot,
          .window = stand::Window::circle({numbers[0], numbers[1]}, numbers[2])};
}

std::vector<stand::NamedWindow> given_windows(const UnitSettings& settings) {
  if (!settings.windows.empty()) return settings.windows;
  if (!settings.circle.empty()) return {circle_of_every_plot(settings.circle)};
  if (!settings.window.empty()) return stand::read_windows(settings.window);
  return {};
}

/// The settings that need a design, or that a table of plots must support by its columns.
IdleReasons idle_by_design(const stand::SamplingDesign& design) {
  if (!design.is_given()) {
    return {{"subplot", "without `circles`, `angle_count`, `expansion` or a table of `plots`"}};
  }
  if (!design.plots) return {};
  const auto has_radius = [](const stand::PlotRecord& plot) { return !std::isnan(plot.radius_m); };
  const bool has_circles = !design.circles.empty() || design.basal_area_factor > 0.0 ||
                           std::ranges::any_of(design.plots->plots, has_radius);
  IdleReasons idle;
  if (!design.plots->has_slope) {
    idle["slope_correction"] = "without a column slope in the table of `plots`";
  }
  if (!has_circles) {
    idle["subplots"] = "without `circles`, `angle_count`, or radii in the table of `plots`";
  }
  return idle;
}

}  // namespace

stand::SamplingDesign sampling_design(const SamplingSettings& settings) {
  stand::SamplingDesign design{.basal_area_factor = settings.angle_count,
                               .smallest_dbh_cm = settings.smallest_dbh_cm,
                               .expansion = settings.expansion,
                               .is_expansion_of_part = settings.expansion_area,
                               .subplots = settings.subplots,
                               .subplot = settings.subplot,
                               .corrects_slope = settings.slope_correction};
  constexpr std::string_view kWhat = "DBH=RADIUS, such as 7=4,30=12 (cm and m)";
  for (const std::string& part : settings.circles) {
    const std::size_t sign = part.find('=');
    if (sign == std::string::npos) {
      throw UsageError(fmt::format("'{}' is not {}", part, kWhat), {.column = "`circles`"});
    }
    design.circles.push_back({.from_dbh_cm = number_in(part.substr(0, sign), "`circles`", kWhat),
                              .radius_m = number_in(part.substr(sign + 1), "`circles`", kWhat)});
  }
  if (settings.has_plots()) {
    design.plots = stand::read_plot_table(
        settings.plots ? *settings.plots : data::TableSource(settings.plots_file),
        stand::parse_column_mappings(settings.plots_columns));
  }
  stand::check_design(design);
  refuse_idle_settings(settings, {}, idle_by_design(design));
  return design;
}

std::vector<std::string> columns_of(const SamplingSettings& settings) {
  std::vector<std::string> columns;
  for (const std::string& column : {settings.expansion, settings.subplot}) {
    if (!column.empty()) columns.push_back(column);
  }
  return columns;
}

stand::InventoryOptions inventory_options(const ReadingSettings& settings,
                                          stand::InventoryOptions options) {
  options.columns = stand::parse_column_mappings(settings.columns);
  options.where = settings.rows.where;
  options.visits = stand::parse_column_mappings(settings.rows.visits);
  options.trust_units = settings.trust_units;
  options.missing = settings.missing;
  options.fill_down = settings.fill_down;
  options.dead = settings.dead;
  options.status_codes = {
      .alive = settings.alive_codes, .dead = settings.dead_codes, .cut = settings.cut_codes};
  options.case_sensitive = settings.case_sensitive;
  return options;
}

std::vector<stand::FurtherIndex> further_indices(const UnitSettings& settings) {
  std::vector<stand::FurtherIndex> indices;
  for (const std::string& name : settings.further) {
    if (name == "all") {
      for (const stand::FurtherIndex index : all_values<stand::FurtherIndex>()) {
        const bool needs_crowns = index == stand::FurtherIndex::kCrownCompetition;
        if (!needs_crowns || !settings.open_grown.empty()) indices.push_back(index);
      }
      continue;
    }
    const std::optional<stand::FurtherIndex> index = find_word<stand::FurtherIndex>(name);
    if (!index) {
      throw UsageError(fmt::format("'{}' is not one of CO, T, Hegyi, BAL, CCF, all", name),
                       {.column = "`further`"});
    }
    indices.push_back(*index);
  }
  return indices;
}

stand::StructuralUnitOptions unit_options(const UnitSettings& settings, unsigned threads) {
  stand::StructuralUnitOptions options{.neighbors = settings.neighbors,
                                       .edge = settings.edge,
                                       .buffer_m = settings.buffer_m,
                                       .scope = settings.per,
                                       .windows = given_windows(settings),
                                       .size = settings.dominance,
                                       .reach = settings.crowding,
                                       .further = further_indices(settings),
                                       .competition_radius_m = settings.competition_radius_m,
                                       .open_grown_crown = settings.open_grown,
                                       .threads = threads};
  set_limit_angles(settings.alpha, options);
  return options;
}

}  // namespace silvafit::study
