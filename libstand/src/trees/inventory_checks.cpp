// SPDX-License-Identifier: MIT
#include "trees/inventory_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/median.hpp"
#include "silvafit/data/missing_codes.hpp"
#include "silvafit/stand/size_units.hpp"
#include "trees/measurement_time.hpp"

namespace silvafit::stand {
namespace {

// Larger than the coordinates of any map; the cells of the neighbor search are numbered up to it.
constexpr double kFarthestMeters = 1e9;

bool is_known(double value) { return !std::isnan(value); }

using Problems = std::vector<Problem>;

void check_finite(const Measures& row, Problems& problems) {
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    if (std::isinf(row[i])) problems.push_back({i, "the value is not finite"});
  }
  for (const Measure measure : {kX, kY, kZ}) {
    const double value = row[measure];
    if (!std::isfinite(value) || std::abs(value) <= kFarthestMeters) continue;
    problems.push_back(
        {measure,
         fmt::format("{} m is further than {} m from the origin", value, kFarthestMeters)});
  }
}

void check_required(const Measures& row, bool needs_coordinates, Problems& problems) {
  // A tree of known position is a neighbor of others.
  const bool is_placed = is_known(row[kX]) && is_known(row[kY]);
  if (!is_known(row[kDbh]) && !is_placed) {
    problems.push_back({kDbh, "is missing, and a tree without dbh and position cannot be used"});
  }
  for (const Measure measure : {kX, kY}) {
    if (!needs_coordinates || is_known(row[measure])) continue;
    problems.push_back({measure, "is missing, so the tree has no position"});
  }
}

void check_ranges(const Measures& row, bool is_cw_from_radii, Problems& problems) {
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const TreeColumn& column = known_measure(i);
    if (!is_known(row[i]) || column.is_possible(row[i])) continue;
    if (i == kCw && is_cw_from_radii) {
      problems.push_back({kCrE, fmt::format("the four crown radii make a width of {} m", row[i])});
    } else {
      problems.push_back(
          {i, fmt::format("{} {} is not {}", row[i], column.unit, column.range.text)});
    }
  }
  if (!(row[kHcb] >= row[kH])) return;
  problems.push_back({kHcb, fmt::format("{} m is not below h {} m", row[kHcb], row[kH])});
}

/// The median of the positive values; 0 if there are none.
double positive_median(const std::vector<double>& values) {
  std::vector<double> positive;
  std::ranges::copy_if(values, std::back_inserter(positive), [](double v) { return v > 0.0; });
  return positive.empty() ? 0.0 : median(std::move(positive));
}

/// An expression in parentheses or a column in backquotes if necessary, ready for a conversion.
std::string convertible(const Source& source) {
  return source.expression ? "(" + source.text + ")"
                           : data::Expression::variable(source.text).text();
}

/// The measures of sizes that are in the file; cw from radii is not, as these are checked.
void check_sizes(const Inventory& inventory, const ColumnPlan& plan) {
  std::vector<SizeColumn> columns;
  for (std::size_t measure = 0; measure < kMeasureCount; ++measure) {
    const Source& source = plan.measures[measure];
    if (!source.exists() || known_measure(measure).is_position()) continue;
    columns.push_back({.name = known_measure(measure).name,
                       .source = convertible(source),
                       .values = values_of(inventory, measure)});
  }
  check_units_of_trees(
      inventory.plot, inventory.species, columns, inventory.file, [&inventory](std::size_t row) {
        return inventory.place(row);
      });
}

void check_crown_base(const Inventory& inventory,
                      const ColumnPlan& plan,
                      std::size_t crown_base_above_top) {
  const auto usable = static_cast<std::size_t>(
      std::ranges::count_if(inventory.hcb_m, [](double hcb) { return !std::isnan(hcb); }));
  if (crown_base_above_top < kEnoughTrees || crown_base_above_top <= usable) return;
  throw InputError(
      fmt::format("in {} of {} rows the height to crown base is not below the height; are the "
                  "columns {} and {} swapped, or in different units? Convert with `columns`",
                  crown_base_above_top,
                  crown_base_above_top + usable,
                  plan.measures[kH].text,
                  plan.measures[kHcb].text),
      {.file = inventory.file, .column = "hcb"});
}

struct PlotSummary {
  double low_x = std::numeric_limits<double>::infinity();
  double low_y = std::numeric_limits<double>::infinity();
  double high_x = -std::numeric_limits<double>::infinity();
  double high_y = -std::numeric_limits<double>::infinity();
  std::size_t trees = 0;
  double basal_area_m2 = 0.0;

  double size_m() const { return std::hypot(high_x - low_x, high_y - low_y); }
  /// From the box.
  double distance_m(double x, double y) const {
    return std::hypot(x - std::clamp(x, low_x, high_x), y - std::clamp(y, low_y, high_y));
  }
  double area_ha() const { return (high_x - low_x) * (high_y - low_y) / 1e4; }
  void add(double x, double y) {
    low_x = std::min(low_x, x);
    low_y = std::min(low_y, y);
    high_x = std::max(high_x, x);
    high_y = std::max(high_y, y);
    ++trees;
  }
};

bool may_be_position_code(double x, double y) {
  const auto may_be = [](double value) { return value == 0.0 || data::is_all_nines(value); };
  return may_be(x) && may_be(y);
}

std::vector<PlotSummary> summarize_plots(const Inventory& inventory) {
  std::vector<PlotSummary> plots(inventory.plot.levels().size());
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    const double x = inventory.x[i];
    const double y = inventory.y[i];
    if (std::isnan(x) || std::isnan(y)) continue;
    PlotSummary& plot = plots[inventory.plot.code(i)];
    plot.add(x, y);
    if (std::isnan(inventory.dbh_cm[i])) continue;
    const double radius_m = inventory.dbh_cm[i] / 200.0;
    plot.basal_area_m2 += std::numbers::pi * radius_m * radius_m;
  }
  return plots;
}

/// A position of zeros or nines, such as (0, 0) beside UTM coordinates, is a code if its distance
/// from all other trees of the plot is more than these are apart.
void check_position_codes(const Inventory& inventory, const ColumnPlan& plan) {
  if (!inventory.has_coordinates()) return;
  std::vector<PlotSummary> others(inventory.plot.levels().size());
  std::vector<std::size_t> suspects;
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    const double x = inventory.x[i];
    const double y = inventory.y[i];
    if (std::isnan(x) || std::isnan(y)) continue;
    if (may_be_position_code(x, y)) {
      suspects.push_back(i);
    } else {
      others[inventory.plot.code(i)].add(x, y);
    }
  }
  for (const std::size_t tree : suspects) {
    const PlotSummary& plot = others[inventory.plot.code(tree)];
    if (plot.trees < kEnoughTrees) continue;
    const double x = inventory.x[tree];
    const double y = inventory.y[tree];
    const double distance_m = plot.distance_m(x, y);
    const double size_m = plot.size_m();
    if (distance_m <= size_m) continue;
    Place place = inventory.place(tree);
    place.column = fmt::format("{}, {}", plan.measures[kX].text, plan.measures[kY].text);
    throw InputError(
        fmt::format(
            "the position ({}, {}) is {:.3g} m from the other trees of the plot, which are "
            "at most {:.3g} m apart, and may be a code of a missing one: leave it empty; if "
            "it was measured, use `trust_units=true`",
            x,
            y,
            distance_m,
            size_m),
        place);
  }
}

/// A tree that is farther from the box of the other trees of its plot than those are apart.
struct RemoteTree {
  std::size_t tree = 0;
  double distance_m = 0.0;
  double size_m = 0.0;  ///< the diagonal of the box
};

/// Such a tree at an end of x or y, if there are enough others.
std::optional<RemoteTree> remote_tree(const Inventory& inventory,
                                      const std::vector<std::size_t>& trees) {
  if (trees.size() <= kEnoughTrees) return std::nullopt;
  const auto by = [](const std::vector<double>& values) {
    return [&values](std::size_t a, std::size_t b) { return values[a] < values[b]; };
  };
  const auto [west, east] = std::ranges::minmax_element(trees, by(inventory.x));
  const auto [south, north] = std::ranges::minmax_element(trees, by(inventory.y));
  for (const std::size_t tree : {*west, *east, *south, *north}) {
    PlotSummary others;
    // Several trees at the place of a code are as far away.
    for (const std::size_t other : trees) {
      const bool is_there =
          inventory.x[other] == inventory.x[tree] && inventory.y[other] == inventory.y[tree];
      if (!is_there) others.add(inventory.x[other], inventory.y[other]);
    }
    if (others.trees < kEnoughTrees) continue;
    const double distance_m = others.distance_m(inventory.x[tree], inventory.y[tree]);
    if (distance_m > others.size_m()) return RemoteTree{tree, distance_m, others.size_m()};
  }
  return std::nullopt;
}

/// A digit too many in a coordinate stretches the hull, and with it the area, by kilometers.
void check_remote_trees(const Inventory& inventory, const ColumnPlan& plan) {
  if (!inventory.has_coordinates()) return;
  std::vector<std::vector<std::size_t>> trees(inventory.plot.levels().size());
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    const bool is_placed = !std::isnan(inventory.x[i]) && !std::isnan(inventory.y[i]);
    if (is_placed) trees[inventory.plot.code(i)].push_back(i);
  }
  for (const std::vector<std::size_t>& of_plot : trees) {
    const auto remote = remote_tree(inventory, of_plot);
    if (!remote) continue;
    Place place = inventory.place(remote->tree);
    place.column = fmt::format("{}, {}", plan.measures[kX].text, plan.measures[kY].text);
    throw InputError(
        fmt::format("the tree at ({}, {}) is {:.3g} m from the other trees of its plot, which are "
                    "at most {:.3g} m apart; correct the coordinates; if they are right, use "
                    "`trust_units=true`",
                    inventory.x[remote->tree],
                    inventory.y[remote->tree],
                    remote->distance_m,
                    remote->size_m),
        place);
  }
}

/// Medians of plots with enough trees, by their bounding rectangles.
struct PlotDensity {
  double trees_per_ha = 0.0;
  double basal_area_m2 = 0.0;  ///< per ha

  std::string text() const {
    return fmt::format(
        "the positions make {:.3g} trees and {:.3g} m2 of basal area per hectare in the median "
        "plot",
        trees_per_ha,
        basal_area_m2);
  }
};

/// Of plots with several visits each visit is a plot.
Inventory by_visit(Inventory inventory) {
  data::TextColumn visits;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    visits.append(label_at_time(inventory.plot[row], inventory.time[row]));
  }
  inventory.plot = std::move(visits);
  inventory.time = {};
  return inventory;
}

std::optional<PlotDensity> density_of(const Inventory& inventory) {
  if (!inventory.has_coordinates()) return std::nullopt;
  if (inventory.time.size() > 0) return density_of(by_visit(inventory));
  std::vector<double> stems;
  std::vector<double> basal_areas;
  for (const PlotSummary& plot : summarize_plots(inventory)) {
    if (plot.trees < kEnoughTrees) continue;
    stems.push_back(static_cast<double>(plot.trees) / plot.area_ha());
    basal_areas.push_back(plot.basal_area_m2 / plot.area_ha());
  }
  if (stems.empty()) return std::nullopt;
  return PlotDensity{positive_median(stems), positive_median(basal_areas)};
}

/// A stand below 1 m2/ha with fewer than 30 trees/ha has hardly any neighbors.
void check_positions(const Inventory& inventory, const ColumnPlan& plan) {
  const Source& x = plan.measures[kX];
  const Source& y = plan.measures[kY];
  const std::string columns = fmt::format("{}, {}", x.text, y.text);
  check_crowding(inventory, columns);
  const std::optional<PlotDensity> density = density_of(inventory);
  if (!density) return;
  if (std::isinf(density->trees_per_ha)) {
    throw InputError(
        "all trees of a plot stand on one point or line; are these the positions of trees? Name "
        "the right columns with `columns=x=COLUMN,y=COLUMN`; if there are none, use "
        "`columns=x=NA,y=NA`",
        {.file = inventory.file, .column = columns});
  }
  if (density->trees_per_ha >= 30.0 || density->basal_area_m2 >= 1.0) return;
  throw InputError(fmt::format("{}; if they are in decimeters, use `columns=x={}/10,y={}/10`; if "
                               "they are right, use `trust_units=true`",
                               density->text(),
                               convertible(x),
                               convertible(y)),
                   {.file = inventory.file, .column = columns});
}

/// Azimuths in radians are below 2 pi: as degrees, all trees would stand in one narrow sector.
/// Known for positions around the origin, which the source `distance*sin(azimuth*pi/180)` makes.
void check_azimuths(const Inventory& inventory, const ColumnPlan& plan) {
  const std::string_view source = plan.measures[kX].text;
  constexpr std::string_view kSine = "*sin(";
  constexpr std::string_view kEnd = "*pi/180)";
  const std::size_t sine = source.find(kSine);
  const bool is_polar = source.ends_with(kEnd) && sine != std::string_view::npos &&
                        source.find(" + ") == std::string_view::npos;
  if (!is_polar || inventory.size() < kEnoughTrees) return;
  constexpr double kDegree = std::numbers::pi / 180.0;
  bool has_other_than_north = false;
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    const double bearing = std::atan2(inventory.x[tree], inventory.y[tree]) / kDegree;
    if (bearing < 0.0 || bearing > 2.0 * std::numbers::pi) return;
    has_other_than_north = has_other_than_north || bearing > 0.0;
  }
  if (!has_other_than_north) return;
  const std::size_t begin = sine + kSine.size();
  const std::string_view azimuth = source.substr(begin, source.size() - kEnd.size() - begin);
  throw InputError(
      fmt::format("all azimuths are between 0 and 2 pi, so that all trees stand within "
                  "7 degrees of north; if they are in radians, use "
                  "`columns=azimuth={}*180/pi`; if not, use `trust_units=true`",
                  azimuth),
      {.file = inventory.file, .column = std::string(azimuth)});
}

}  // namespace

void check_crowding(const Inventory& inventory, const std::string& columns) {
  const std::optional<PlotDensity> density = density_of(inventory);
  // A row of trees has no area.
  if (!density || std::isinf(density->trees_per_ha)) return;
  if (density->basal_area_m2 <= 1000.0 && density->trees_per_ha <= 1e6) return;
  throw InputError(
      density->text() +
          "; they should be meters (and not in degrees or kilometers), and of one plot "
          "(name its column with `columns=plot=COLUMN`); without positions, use "
          "`columns=x=NA,y=NA`; if they are right, use `trust_units=true`",
      {.file = inventory.file, .column = columns});
}

double crown_width_m(const Measures& row) {
  return ((row[kCrE] + row[kCrW]) + (row[kCrS] + row[kCrN])) / 2.0;
}

std::vector<Problem> problems_of(const Measures& row,
                                 bool needs_coordinates,
                                 bool is_cw_from_radii) {
  Problems problems;
  check_finite(row, problems);
  check_required(row, needs_coordinates, problems);
  check_ranges(row, is_cw_from_radii, problems);
  return problems;
}

void check_units(const Inventory& inventory,
                 const ColumnPlan& plan,
                 std::size_t crown_base_above_top) {
  check_sizes(inventory, plan);
  check_crown_base(inventory, plan, crown_base_above_top);
  check_azimuths(inventory, plan);
  check_position_codes(inventory, plan);
  check_remote_trees(inventory, plan);
  check_positions(inventory, plan);
}

}  // namespace silvafit::stand
