// SPDX-License-Identifier: MIT
// Whether a whole column is in another unit. The limits are far outside the range of real stands,
// so that giants and saplings pass; a single unusual value gives a note, not an error.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "inventory_checks.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/median.hpp"
#include "silvafit/stand/mixed_units.hpp"

namespace silvafit::stand {
namespace {

constexpr double kHeightOfStandMeters = 130.0;  // the tallest tree known is 116 m
constexpr double kDbhOfStandCentimeters = 250.0;
constexpr double kCrownOfStandMeters = 25.0;
constexpr std::size_t kEnoughTrees = 10;

/// The median of the positive values; 0 if there are none.
double positive_median(const std::vector<double>& values) {
  std::vector<double> positive;
  std::ranges::copy_if(values, std::back_inserter(positive), [](double v) { return v > 0.0; });
  return positive.empty() ? 0.0 : median(std::move(positive));
}

/// Median of h / dbh, both in the same unit; 0 where no tree has both. Stands have 20 to 200.
double median_slenderness(const Inventory& inventory) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < inventory.h_m.size(); ++i) {
    const double ratio = 100.0 * inventory.h_m[i] / inventory.dbh_cm[i];
    if (!std::isnan(ratio)) ratios.push_back(ratio);
  }
  return positive_median(ratios);
}

/// Expressions get parentheses before they are divided, columns get backquotes if necessary.
std::string converted(const Source& source, int divisor, int factor) {
  const std::string text =
      source.expression ? "(" + source.text + ")" : data::Expression::variable(source.text).text();
  return divisor > 1 ? fmt::format("{}/{}", text, divisor) : fmt::format("{}*{}", text, factor);
}

/// A unit that a column may have, by the factor to the standard unit as a divisor or multiplier.
struct OtherUnit {
  std::string_view name{};
  int divisor = 1;
  int factor = 1;

  double in_ours(double value) const { return value / divisor * factor; }
};

/// Whether a stand may have such a median; with the other size known, the ratio of height to dbh
/// decides, which is 20 to 200 in stands.
bool is_plausible(double h_m, double dbh_cm) {
  constexpr double kLowest = 1.3;
  constexpr double kStoutestStand = 20.0;
  constexpr double kSlenderestStand = 200.0;
  if (h_m > 0.0 && (h_m < kLowest || h_m > kHeightOfStandMeters)) return false;
  if (dbh_cm > kDbhOfStandCentimeters) return false;
  if (!(h_m > 0.0) || !(dbh_cm > 0.0)) return true;
  const double slenderness = 100.0 * h_m / dbh_cm;
  return slenderness >= kStoutestStand && slenderness <= kSlenderestStand;
}

/// "if it is in cm, use --columns h=h/100, or in dm, ...": the units that make plausible stands.
std::string advice_on_units(const ColumnPlan& plan,
                            std::size_t measure,
                            const std::vector<OtherUnit>& units) {
  std::string text;
  for (const OtherUnit& unit : units) {
    text += fmt::format("{} {}, use --columns {}={}",
                        text.empty() ? "if it is in" : ", if in",
                        unit.name,
                        known_measure(measure).name,
                        converted(plan.measures[measure], unit.divisor, unit.factor));
  }
  return text;
}

/// \param units  all that are thinkable; those that fit are named, or all if none fits
[[noreturn]] void suspect(const Inventory& inventory,
                          const ColumnPlan& plan,
                          std::size_t measure,
                          double median,
                          const std::vector<OtherUnit>& units) {
  const Source& source = plan.measures[measure];
  const std::string_view name = known_measure(measure).name;
  std::vector<OtherUnit> fitting;
  for (const OtherUnit& unit : units) {
    const double value = unit.in_ours(median);
    const bool is_height = measure == kH || measure == kHcb;
    const bool fits = measure == kDbh ? is_plausible(positive_median(inventory.h_m), value)
                      : is_height     ? is_plausible(value, positive_median(inventory.dbh_cm))
                                      : value >= 0.5 && value <= kCrownOfStandMeters;
    if (fits) fitting.push_back(unit);
  }
  throw InputError(
      fmt::format("{} has the median {:.4g}, which is not a plausible {}; {}; if it is "
                  "correct, use --trust-units",
                  source.exists() ? source.text : std::string(name),
                  median,
                  known_measure(measure).meaning,
                  advice_on_units(plan, measure, fitting.empty() ? units : fitting)),
      {.file = inventory.file, .column = std::string(name)});
}

/// Units of heights and crowns.
const std::vector<OtherUnit> kSmallerUnits{
    {"decimeters", 10}, {"centimeters", 100}, {"millimeters", 1000}};

void check_dbh(const Inventory& inventory, const ColumnPlan& plan) {
  constexpr double kSlenderest = 600.0;
  constexpr double kStoutest = 12.0;
  const double median = positive_median(inventory.dbh_cm);
  const double slenderness = median_slenderness(inventory);
  const double h = positive_median(inventory.h_m);
  const bool h_is_plausible = h > 0.0 && h < kHeightOfStandMeters;
  // Giants are tall, too: known heights decide.
  const bool is_too_thick =
      h_is_plausible ? median > 60.0 && slenderness < kStoutest : median > kDbhOfStandCentimeters;
  if (is_too_thick) {
    suspect(inventory, plan, kDbh, median, {{"millimeters", 10}});
  }
  if (median > 0.0 && median < 0.9 && (h == 0.0 || (h_is_plausible && slenderness > kSlenderest))) {
    suspect(inventory, plan, kDbh, median, {{"meters", 1, 100}, {"decimeters", 1, 10}});
  }
}

void check_heights(const Inventory& inventory,
                   const ColumnPlan& plan,
                   std::size_t crown_base_above_top) {
  for (const Measure measure : {kH, kHcb}) {
    const double median = positive_median(values_of(inventory, measure));
    if (median <= kHeightOfStandMeters) continue;
    suspect(inventory, plan, measure, median, kSmallerUnits);
  }
  constexpr double kSlenderest = 300.0;
  const double h = positive_median(inventory.h_m);
  if (h > 60.0 && median_slenderness(inventory) > kSlenderest) {
    suspect(inventory, plan, kH, h, kSmallerUnits);
  }
  const auto usable = static_cast<std::size_t>(
      std::ranges::count_if(inventory.hcb_m, [](double hcb) { return !std::isnan(hcb); }));
  if (crown_base_above_top >= kEnoughTrees && crown_base_above_top > usable) {
    throw InputError(
        fmt::format("in {} of {} rows the height to crown base is not below the height; are the "
                    "columns {} and {} swapped, or in different units? Convert with --columns",
                    crown_base_above_top,
                    crown_base_above_top + usable,
                    plan.measures[kH].text,
                    plan.measures[kHcb].text),
        {.file = inventory.file, .column = "hcb"});
  }
}

void check_crowns(const Inventory& inventory, const ColumnPlan& plan) {
  for (const Measure measure : {kCw, kCrE, kCrW, kCrS, kCrN}) {
    // Without a column cw, it is computed from the radii, which are checked separately.
    if (!plan.measures[measure].exists()) continue;
    const double limit = measure == kCw ? kCrownOfStandMeters : kCrownOfStandMeters / 2.0;
    const double median = positive_median(values_of(inventory, measure));
    if (median > limit) suspect(inventory, plan, measure, median, kSmallerUnits);
  }
}

struct PlotSummary {
  double low_x = std::numeric_limits<double>::infinity();
  double low_y = std::numeric_limits<double>::infinity();
  double high_x = -std::numeric_limits<double>::infinity();
  double high_y = -std::numeric_limits<double>::infinity();
  std::size_t trees = 0;
  double basal_area_m2 = 0.0;

  double area_ha() const { return (high_x - low_x) * (high_y - low_y) / 1e4; }
};

std::vector<PlotSummary> summarize_plots(const Inventory& inventory) {
  std::vector<PlotSummary> plots(inventory.plot.levels().size());
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    const double x = inventory.x[i];
    const double y = inventory.y[i];
    if (std::isnan(x) || std::isnan(y)) continue;
    PlotSummary& plot = plots[inventory.plot.code(i)];
    plot.low_x = std::min(plot.low_x, x);
    plot.low_y = std::min(plot.low_y, y);
    plot.high_x = std::max(plot.high_x, x);
    plot.high_y = std::max(plot.high_y, y);
    ++plot.trees;
    if (std::isnan(inventory.dbh_cm[i])) continue;
    const double radius_m = inventory.dbh_cm[i] / 200.0;
    plot.basal_area_m2 += std::numbers::pi * radius_m * radius_m;
  }
  return plots;
}

/// Positions in another unit are detected by the basal area in the bounding rectangles. The densest
/// known forests have about 450 m2/ha; a stand below 1 m2/ha with fewer than 30 trees/ha has hardly
/// any neighbors.
void check_positions(const Inventory& inventory, const ColumnPlan& plan) {
  if (!inventory.has_coordinates()) return;
  std::vector<double> stems;
  std::vector<double> basal_areas;
  for (const PlotSummary& plot : summarize_plots(inventory)) {
    if (plot.trees < kEnoughTrees) continue;
    stems.push_back(static_cast<double>(plot.trees) / plot.area_ha());
    basal_areas.push_back(plot.basal_area_m2 / plot.area_ha());
  }
  if (stems.empty()) return;
  const Source& x = plan.measures[kX];
  const Source& y = plan.measures[kY];
  const double trees_per_ha = positive_median(stems);
  const double basal_area = positive_median(basal_areas);
  const auto complain = [&](std::string_view cause) {
    throw InputError(fmt::format("the positions make {:.3g} trees and {:.3g} m2 of basal area per "
                                 "hectare in the median plot; {}; if they are right, --trust-units",
                                 trees_per_ha,
                                 basal_area,
                                 cause),
                     {.file = inventory.file, .column = fmt::format("{}, {}", x.text, y.text)});
  };
  if (std::isinf(trees_per_ha)) {
    throw InputError(
        "all trees of a plot stand on one point or line; are these the positions of trees? Name "
        "the right columns with --columns x=COLUMN,y=COLUMN",
        {.file = inventory.file, .column = fmt::format("{}, {}", x.text, y.text)});
  }
  if (trees_per_ha < 30.0 && basal_area < 1.0) {
    complain(fmt::format("if they are in decimeters, use --columns x={},y={}",
                         converted(x, 10, 1),
                         converted(y, 10, 1)));
  }
  if (basal_area > 1000.0 || trees_per_ha > 1e6) {
    complain("they should be meters (and not in degrees or kilometers)");
  }
}

/// More than any tree has.
struct Limit {
  std::size_t measure = 0;
  double most = 0.0;
  std::string_view unit{};
};
constexpr std::array<Limit, 3> kLimits{{{kDbh, 1000.0, "cm"}, {kH, 120.0, "m"}, {kCw, 60.0, "m"}}};

}  // namespace

void check_units(const Inventory& inventory,
                 const ColumnPlan& plan,
                 std::size_t crown_base_above_top) {
  // First, because messages about whole columns would be wrong for a part of the plots.
  const std::string mixed = describe_mixed_units(find_mixed_units({.plot = inventory.plot,
                                                                   .species = &inventory.species,
                                                                   .dbh_cm = inventory.dbh_cm,
                                                                   .h_m = inventory.h_m}));
  if (!mixed.empty()) throw InputError(mixed, {.file = inventory.file, .column = "dbh, h"});
  check_heights(inventory, plan, crown_base_above_top);
  check_dbh(inventory, plan);
  check_crowns(inventory, plan);
  check_positions(inventory, plan);
}

void OddValues::add(const Inventory& inventory) {
  for (std::size_t i = 0; i < kLimits.size(); ++i) {
    const Limit& limit = kLimits[i];
    const std::vector<double>& values = values_of(inventory, limit.measure);
    for (std::size_t row = 0; row < values.size(); ++row) {
      if (!(values[row] > limit.most)) continue;
      if (beyond_[i].count++ > 0) continue;
      Place place = inventory.place(row);
      place.column = known_measure(limit.measure).name;
      beyond_[i].first = describe(place, fmt::format("{} {} is odd", values[row], limit.unit));
    }
  }
}

std::vector<std::string> OddValues::notes() const {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < kLimits.size(); ++i) {
    const std::size_t count = beyond_[i].count;
    if (count == 0) continue;
    std::string note = beyond_[i].first;
    if (count > 1) {
      note += fmt::format(
          ", and {} more values above {} {}", count - 1, kLimits[i].most, kLimits[i].unit);
    }
    notes.push_back(std::move(note));
  }
  return notes;
}

}  // namespace silvafit::stand
