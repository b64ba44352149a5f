// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "growth/growth_maker.hpp"
#include "sampling/plot_areas.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/table.hpp"
#include "trees/measurement_time.hpp"
#include "units/density_indices.hpp"

namespace silvafit::stand {
namespace {

double& part_of(GrowthParts& parts, GrowthPart part) {
  return parts[static_cast<std::size_t>(part)];
}

/// Whether a period has living trees at its start or its end.
bool has_trees(const Period& period, std::size_t TreeInPeriod::*row) {
  return std::ranges::any_of(period.trees,
                             [row](const TreeInPeriod& tree) { return tree.*row != kNoTreeRow; });
}

/// The table of plots, and those that have a window of their own: one without trees was empty.
std::optional<PlotTable> listed_plots(const std::optional<PlotTable>& table,
                                      const std::vector<NamedWindow>& windows) {
  std::optional<PlotTable> result = table;
  for (const NamedWindow& one : windows) {
    if (!one.plot || one.plot == kEveryPlot) continue;
    if (!result) result.emplace();
    const bool is_known =
        std::ranges::find(result->plots, *one.plot, &PlotRecord::plot) != result->plots.end();
    if (!is_known) result->plots.push_back({.plot = *one.plot});
  }
  return result;
}

/// A plot's name at a time, also for messages.
std::string label_of(const MeasuredPlot& plot, std::size_t occasion) {
  return label_at_time(plot.plot, plot.occasions[occasion].text);
}

}  // namespace

/// The rows of living trees at the occasions between which a tree was alive; none if it never was.
std::vector<std::size_t> GrowthMaker::living_rows(const MeasuredPlot& plot,
                                                  const MeasuredTree& tree,
                                                  LivingTrees& living) {
  const auto alive_at = [&](std::size_t k) { return tree.rows[k] && is_alive(*tree.rows[k]); };
  std::size_t end = tree.rows.size();
  while (end > 0 && !alive_at(end - 1)) --end;
  std::vector<std::size_t> alive;
  for (std::size_t k = 0; k < end; ++k) {
    if (!tree.rows[k]) continue;
    const std::size_t row = *tree.rows[k];
    // A tree that is alive later was not dead; its row counts, unless others tell more.
    if (!is_alive(row) && revived_++ == 0) {
      first_revived_ = describe(inventory_.place(row), "dead or cut, but alive later");
    }
    if (is_alive(row) || alive.empty() || !std::isnan(inventory_.dbh_cm[row])) alive.push_back(k);
  }
  std::vector<std::size_t> rows(tree.rows.size(), kNoTreeRow);
  if (alive.empty()) return rows;
  std::vector<std::size_t> followed;
  std::vector<double> years;
  std::size_t own = alive.front();  // the last one with a row
  std::size_t measured = own;       // ... with a dbh
  for (std::size_t k = own; k <= alive.back(); ++k) {
    const bool has_row = std::ranges::binary_search(alive, k);
    if (has_row) own = k;
    if (has_row && !std::isnan(inventory_.dbh_cm[*tree.rows[k]])) measured = k;
    rows[k] = living.add(*tree.rows[own], label_of(plot, k), has_row);
    followed.push_back(rows[k]);
    years.push_back(plot.occasions[k].years);
  }
  const bool has_ended = end < tree.rows.size();
  for (const std::size_t row : living.complete(followed, years, has_ended)) {
    if (row > rows[measured])
      ++carried_;
    else
      interpolated_.insert(row);
  }
  return rows;
}

TreeFate GrowthMaker::fate_at_end(const MeasuredTree& tree, std::size_t occasion) const {
  std::optional<std::size_t> row = tree.rows[occasion];
  const auto has_row = [](const std::optional<std::size_t>& one) { return one.has_value(); };
  // The status of the last visit is in every row. A tree that was missed and is dead later died.
  const auto from =
      tree.rows.begin() + (is_status_of_last_visit_ ? 0 : static_cast<std::ptrdiff_t>(occasion));
  if (const auto known = std::find_if(from, tree.rows.end(), has_row);
      !row && known != tree.rows.end()) {
    row = *known;
  }
  if (!row || inventory_.status.empty() || inventory_.status[*row] == TreeStatus::kAlive) {
    return TreeFate::kNotFound;
  }
  return inventory_.status[*row] == TreeStatus::kDead ? TreeFate::kMortality : TreeFate::kCut;
}

void GrowthMaker::follow_plot(std::size_t number, LivingTrees& living) {
  const MeasuredPlot& plot = plots_[number];
  const std::size_t first_period = periods_.size();
  for (std::size_t k = 0; k + 1 < plot.occasions.size(); ++k) {
    periods_.push_back({.plot = number, .occasion = k});
  }
  for (const MeasuredTree& tree : plot.trees) {
    const std::vector<std::size_t> rows = living_rows(plot, tree, living);
    const auto is_alive_ever = [](std::size_t row) { return row != kNoTreeRow; };
    if (std::ranges::none_of(rows, is_alive_ever)) ++never_alive_;
    rows_of_trees_.push_back(rows);
    for (std::size_t k = 0; k + 1 < rows.size(); ++k) {
      if (rows[k] == kNoTreeRow && rows[k + 1] == kNoTreeRow) continue;
      TreeInPeriod one{.start = rows[k], .end = rows[k + 1]};
      if (one.start == kNoTreeRow) one.fate = TreeFate::kIngrowth;
      if (one.end == kNoTreeRow) one.fate = fate_at_end(tree, k + 1);
      periods_[first_period + k].trees.push_back(one);
    }
  }
}

void GrowthMaker::follow_trees() {
  check_visits(plots_, inventory_.file);
  refuse_new_numbers(plots_, inventory_);
  LivingTrees living(inventory_);
  std::vector<std::string> once;
  for (std::size_t i = 0; i < plots_.size(); ++i) {
    if (plots_[i].occasions.size() < 2) once.push_back(plots_[i].plot);
    follow_plot(i, living);
  }
  living_ = std::move(living).finish();
  if (periods_.empty()) {
    throw InputError("no plot was measured twice; growth needs two years or dates of a plot",
                     {.file = inventory_.file});
  }
  if (once.empty()) return;
  report_.notes.push_back(fmt::format("{}: {}",
                                      counted(once.size(),
                                              "plot was measured once and has no growth",
                                              "plots were measured once and have no growth"),
                                      data::list_of(once)));
}

std::vector<PlotAtTime> GrowthMaker::plots_at_occasions() const {
  std::vector<PlotAtTime> plots;
  for (const MeasuredPlot& plot : plots_) {
    for (const Occasion& one : plot.occasions) {
      plots.push_back({.plot = plot.plot, .time = one.text});
    }
  }
  return plots;
}

/// A tree stands where it was first seen: it is inside of its plot or outside at all times.
void GrowthMaker::place_trees() {
  if (!living_.has_coordinates()) return;
  for (const std::vector<std::size_t>& rows : rows_of_trees_) {
    const auto is_placed = [this](std::size_t row) {
      return row != kNoTreeRow && std::isfinite(living_.x[row]) && std::isfinite(living_.y[row]);
    };
    const auto first = std::ranges::find_if(rows, is_placed);
    if (first == rows.end()) continue;
    for (const std::size_t row : rows) {
      if (row == kNoTreeRow) continue;
      living_.x[row] = living_.x[*first];
      living_.y[row] = living_.y[*first];
    }
  }
}

void GrowthMaker::find_areas() {
  std::vector<SampledArea> areas;
  // A tree is counted without a dbh, unless the design chooses trees by it.
  const bool needs_dbh =
      !options_.design.circles.empty() || options_.design.basal_area_factor > 0.0;
  if (!needs_dbh) living_.neighbor_only.clear();
  if (options_.plot_area_m2 || !options_.units.windows.empty()) refuse_unused_factors(inventory_);
  if (options_.plot_area_m2) {
    areas = sampled_areas(living_, *options_.plot_area_m2);
  } else if (!options_.units.windows.empty()) {
    const std::vector<NamedWindow> given =
        windows_at_times(options_.units.windows, plots_at_occasions());
    areas = sampled_areas(living_, plot_windows(living_, given, SearchScope::kPlot), given);
    take_unknown_plots(living_, true, areas);
  } else if (design_.is_given()) {
    DesignedSample sample = sample_of(living_, design_at_times(design_, plots_at_occasions()));
    living_.represented = std::move(sample.represented);
    areas = std::move(sample.areas);
    report_.notes.insert(report_.notes.end(), sample.notes.begin(), sample.notes.end());
  } else {
    areas = plots_of_unknown_area(living_);
    report_.notes.emplace_back(
        "areas are unknown, so there are no values per hectare; give `plot_area`, `window`, "
        "`circle`, `plots` or a sampling design" +
        offer_of_area_column(inventory_));
  }
  const bool are_given = options_.plot_area_m2 || !options_.units.windows.empty();
  if (are_given && design_.plots) {
    check_table_beside_areas(*design_at_times(design_, plots_at_occasions()).plots, areas);
  }
  is_counted_.assign(living_.size(), 0);
  for (SampledArea& area : areas) {
    for (const std::size_t tree : area.trees) is_counted_[tree] = 1;
    areas_.emplace(area.name, std::move(area));
  }
  // Plots without living trees have no rows from which their areas could be known.
  const double every_m2 = area_of_every_plot_m2(options_.plot_area_m2, options_.units.windows);
  for (const MeasuredPlot& plot : plots_) {
    for (std::size_t k = 0; every_m2 > 0.0 && k < plot.occasions.size(); ++k) {
      const std::string label = label_of(plot, k);
      areas_.try_emplace(label, SampledArea{.name = label, .area_m2 = every_m2});
    }
  }
  if (!options_.units.windows.empty()) note_uncounted();
}

void GrowthMaker::add_tree(const Period& period, const TreeInPeriod& tree) {
  const MeasuredPlot& plot = plots_[period.plot];
  const Occasion& from = plot.occasions[period.occasion];
  const Occasion& to = plot.occasions[period.occasion + 1];
  const std::size_t any = tree.start == kNoTreeRow ? tree.end : tree.start;
  const auto at = [](const std::vector<double>& values, std::size_t row) {
    return values.empty() || row == kNoTreeRow ? data::kMissing : values[row];
  };
  const double years = to.years - from.years;
  TreeGrowth growth{.plot = plot.plot,
                    .tree = std::string(living_.tree[any]),
                    .species = std::string(living_.species[any]),
                    .from = from.text,
                    .to = to.text,
                    .years = years,
                    .fate = tree.fate,
                    .dbh_start_cm = at(living_.dbh_cm, tree.start),
                    .dbh_end_cm = at(living_.dbh_cm, tree.end),
                    .h_start_m = at(living_.h_m, tree.start),
                    .h_end_m = at(living_.h_m, tree.end)};
  growth.dbh_cm_per_year = (growth.dbh_end_cm - growth.dbh_start_cm) / years;
  growth.h_m_per_year = (growth.h_end_m - growth.h_start_m) / years;
  constexpr double kSquareCentimeters = 1e4;
  growth.basal_area_cm2_per_year =
      kSquareCentimeters * (basal_area_m2(growth.dbh_end_cm) - basal_area_m2(growth.dbh_start_cm)) /
      years;
  for (const TreeQuantity& quantity : living_.quantities) {
    growth.quantities_per_year.push_back(
        (at(quantity.values, tree.end) - at(quantity.values, tree.start)) / years);
  }
  const auto has_species = [this](std::size_t row) {
    return row != kNoTreeRow && !living_.species.is_missing(row);
  };
  const bool is_in_both = has_species(tree.start) && has_species(tree.end);
  if (is_in_both && living_.species[tree.start] != living_.species[tree.end]) {
    growth.is_renamed = true;
    renamed_.push_back(fmt::format("plot {}, tree {} ({} in {}, {} in {})",
                                   plot.plot,
                                   growth.tree,
                                   growth.species,
                                   from.text,
                                   living_.species[tree.end],
                                   to.text));
  }
  growth.is_interpolated = interpolated_.contains(tree.start) || interpolated_.contains(tree.end);
  report_.trees.push_back(std::move(growth));
}

void GrowthMaker::add_trees() {
  for (const Period& period : periods_) {
    for (const TreeInPeriod& tree : period.trees) add_tree(period, tree);
  }
}

std::vector<TreeValue> GrowthMaker::values() const {
  std::vector<TreeValue> values{
      [](std::size_t) { return 1.0; },
      [this](std::size_t row) { return basal_area_m2(living_.dbh_cm[row]); }};
  for (const TreeQuantity& quantity : living_.quantities) {
    values.emplace_back([&quantity](std::size_t row) { return quantity.values[row]; });
  }
  return values;
}

/// Whether a tree is left out of both sums, because its value, or its dbh where the design needs
/// it, is not known at one of them.
bool GrowthMaker::is_value_missing(const TreeInPeriod& tree, const TreeValue& value) const {
  const auto is_missing = [&](std::size_t row) {
    return row != kNoTreeRow && (living_.is_neighbor_only(row) || std::isnan(value(row)));
  };
  return is_missing(tree.start) || is_missing(tree.end);
}

void GrowthMaker::find_missing(const Period& period,
                               const TreeValue& value,
                               std::vector<std::string>& places) const {
  const MeasuredPlot& plot = plots_[period.plot];
  for (const TreeInPeriod& tree : period.trees) {
    if (!is_value_missing(tree, value)) continue;
    places.push_back(fmt::format("plot {}, tree {} ({} to {})",
                                 plot.plot,
                                 living_.tree[tree.start == kNoTreeRow ? tree.end : tree.start],
                                 plot.occasions[period.occasion].text,
                                 plot.occasions[period.occasion + 1].text));
  }
}

GrowthParts GrowthMaker::parts_of_value(const Period& period,
                                        const TreeValue& value,
                                        const SampledArea& start,
                                        const SampledArea& end,
                                        double years) const {
  GrowthParts parts{};
  const auto per_ha = [&](std::size_t row, const SampledArea& area) {
    return living_.trees_represented(row) / (area.area_m2 / kSquareMetersPerHectare);
  };
  const auto is_unknown = [&](const TreeInPeriod& tree) { return is_value_missing(tree, value); };
  if (!period.trees.empty() && std::ranges::all_of(period.trees, is_unknown)) {
    parts.fill(data::kMissing);
    return parts;
  }
  for (const TreeInPeriod& tree : period.trees) {
    if (is_unknown(tree)) continue;
    const bool at_start = tree.start != kNoTreeRow && is_counted_[tree.start] != 0;
    const bool at_end = tree.end != kNoTreeRow && is_counted_[tree.end] != 0;
    const double before = at_start ? per_ha(tree.start, start) * value(tree.start) : 0.0;
    const double after = at_end ? per_ha(tree.end, end) * value(tree.end) : 0.0;
    part_of(parts, GrowthPart::kStart) += before;
    part_of(parts, GrowthPart::kEnd) += after;
    switch (tree.fate) {
      case TreeFate::kSurvivor:
        if (at_start) {
          part_of(parts, GrowthPart::kSurvivorGrowth) +=
              per_ha(tree.start, start) * (value(tree.end) - value(tree.start)) / years;
        }
        break;
      case TreeFate::kIngrowth:
        part_of(parts, GrowthPart::kIngrowth) += after / years;
        break;
      case TreeFate::kMortality:
        part_of(parts, GrowthPart::kMortality) += before / years;
        break;
      case TreeFate::kCut:
        part_of(parts, GrowthPart::kCut) += before / years;
        break;
      case TreeFate::kNotFound:
        part_of(parts, GrowthPart::kNotFound) += before / years;
        break;
    }
  }
  const auto get = [&parts](GrowthPart part) { return parts[static_cast<std::size_t>(part)]; };
  part_of(parts, GrowthPart::kNetChange) =
      (get(GrowthPart::kEnd) - get(GrowthPart::kStart)) / years;
  const double factor_change =
      get(GrowthPart::kNetChange) -
      (get(GrowthPart::kSurvivorGrowth) + get(GrowthPart::kIngrowth) - get(GrowthPart::kMortality) -
       get(GrowthPart::kCut) - get(GrowthPart::kNotFound));
  // The difference of equal sums is rounding error.
  const double rounding = 1e-12 * (get(GrowthPart::kStart) + get(GrowthPart::kEnd)) / years;
  part_of(parts, GrowthPart::kFactorChange) =
      std::abs(factor_change) <= rounding ? 0.0 : factor_change;
  return parts;
}

void GrowthMaker::add_plots() {
  const std::vector<TreeValue> of_tree = values();
  missing_.resize(of_tree.size());
  std::vector<std::string> changed;
  for (const Period& period : periods_) {
    const MeasuredPlot& plot = plots_[period.plot];
    const Occasion& from = plot.occasions[period.occasion];
    const Occasion& to = plot.occasions[period.occasion + 1];
    PlotGrowth growth{.plot = plot.plot,
                      .from = from.text,
                      .to = to.text,
                      .period = period.occasion + 1,
                      .years = to.years - from.years,
                      .area_ha = data::kMissing};
    auto start = areas_.find(label_of(plot, period.occasion));
    auto end = areas_.find(label_of(plot, period.occasion + 1));
    // Without living trees a plot keeps its area.
    if (start == areas_.end() && !has_trees(period, &TreeInPeriod::start)) start = end;
    if (end == areas_.end() && !has_trees(period, &TreeInPeriod::end)) end = start;
    const bool is_known = start != areas_.end() && end != areas_.end() &&
                          !std::isnan(start->second.area_m2) && !std::isnan(end->second.area_m2);
    double area_ha = data::kMissing;
    if (is_known) {
      area_ha = start->second.area_m2 / kSquareMetersPerHectare;
      if (start->second.has_area) growth.area_ha = area_ha;
      if (!is_same_area(start->second.area_m2, end->second.area_m2)) {
        changed.push_back(fmt::format("{} ({:.6g} m2 {}, {:.6g} m2 {})",
                                      plot.plot,
                                      start->second.area_m2,
                                      from.text,
                                      end->second.area_m2,
                                      to.text));
      }
    }
    for (std::size_t i = 0; i < of_tree.size(); ++i) {
      GrowthParts parts;
      parts.fill(data::kMissing);
      if (is_known && area_ha > 0.0) {
        parts = parts_of_value(period, of_tree[i], start->second, end->second, growth.years);
        find_missing(period, of_tree[i], missing_[i]);
      }
      growth.values.push_back(parts);
    }
    areas_ha_.push_back(area_ha);
    const bool is_part = is_known && !std::isnan(start->second.whole_m2);
    whole_ha_.push_back(is_part ? start->second.whole_m2 / kSquareMetersPerHectare : area_ha);
    report_.plots.push_back(std::move(growth));
  }
  note_if(changed.size(),
          fmt::format("{} another area at the end of a period, which changes values per hectare "
                      "without growth (factor change, a part of the net change): {}",
                      counted(changed.size(), "plot has", "plots have"),
                      data::list_of(changed)));
}

void GrowthMaker::check_density() const {
  if (options_.trust_units) return;
  check_increments(report_, inventory_.file);
  refuse_other_trees(report_, inventory_.file);
  constexpr std::size_t kNumber = 0;  // of GrowthReport::values
  constexpr std::size_t kBasalArea = 1;
  const Place place{.file = inventory_.file,
                    .column = options_.plot_area_m2 ? "`plot_area`" : "area"};
  double start_m2 = 0.0;
  double end_m2 = 0.0;
  double area_ha = 0.0;
  for (std::size_t i = 0; i < areas_ha_.size(); ++i) {
    if (!(areas_ha_[i] > 0.0)) continue;
    GrowthParts parts = report_.plots[i].values[kBasalArea];
    start_m2 += part_of(parts, GrowthPart::kStart) * areas_ha_[i];
    end_m2 += part_of(parts, GrowthPart::kEnd) * areas_ha_[i];
    area_ha += areas_ha_[i];
    if (!living_.represented.empty()) continue;
    GrowthParts numbers = report_.plots[i].values[kNumber];
    check_plot_density(report_.plots[i].plot,
                       std::round(part_of(numbers, GrowthPart::kStart) * areas_ha_[i]),
                       part_of(parts, GrowthPart::kStart) * areas_ha_[i],
                       areas_ha_[i] * kSquareMetersPerHectare,
                       place);
  }
  check_density_is_possible(start_m2 / area_ha, place);
  check_density_is_possible(end_m2 / area_ha, place);
}

GrowthReport GrowthMaker::run() {
  if (design_.plots) design_.plots = with_times_read(*std::move(design_.plots), report_.notes);
  const std::optional<PlotTable> plots = listed_plots(design_.plots, options_.units.windows);
  plots_ = measured_plots(inventory_, plots ? &*plots : nullptr, report_.notes);
  read_status();
  report_.values = {"stems", "basal_area_m2"};
  for (const TreeQuantity& quantity : inventory_.quantities) {
    report_.quantities.push_back(label_of(quantity));
    report_.values.push_back(report_.quantities.back());
  }
  follow_trees();
  note_moved();
  place_trees();
  find_areas();
  add_trees();
  add_plots();
  check_density();
  find_strata();
  add_strata();
  add_notes();
  return std::move(report_);
}

GrowthReport growth_report(const Inventory& inventory, const StandReportOptions& options) {
  return GrowthMaker(inventory, options).run();
}

}  // namespace silvafit::stand
