// SPDX-License-Identifier: MIT
#include "trees/measured_plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/table.hpp"
#include "trees/column_times.hpp"
#include "trees/measurement_time.hpp"

namespace silvafit::stand {
namespace {

void add_occasion(MeasuredPlot& plot, double years, const std::string& text) {
  const auto is_same = [years](const Occasion& one) { return is_same_time(one.years, years); };
  if (std::ranges::any_of(plot.occasions, is_same)) return;
  plot.occasions.push_back({.years = years, .text = text, .first = years, .last = years});
}

/// The plots so far, by their names.
struct PlotList {
  std::vector<MeasuredPlot> plots{};
  std::unordered_map<std::string, std::size_t> number_of{};

  MeasuredPlot& named(const std::string& name) {
    const auto [found, is_new] = number_of.try_emplace(name, plots.size());
    if (is_new) plots.push_back({.plot = name});
    return plots[found->second];
  }
};

/// The times of an inventory's rows, which years_of() can read.
std::vector<std::string> times_of_rows(const Inventory& inventory,
                                       std::vector<std::string>& notes) {
  const auto column = inventory.label_columns.find("time");
  ColumnTimes read(inventory.time.levels());
  std::vector<std::string> times;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    Place place = inventory.place(row);
    place.column = column == inventory.label_columns.end() ? "year" : column->second;
    times.push_back(read.read(inventory.plot[row], inventory.time[row], place));
    required_years_of(times.back(), place);
  }
  if (std::string note = read.note(); !note.empty()) notes.push_back(std::move(note));
  return times;
}

Place place_of_time(const PlotTable& plots, const PlotRecord& record) {
  return {.file = plots.file, .line = record.line, .column = "year or date", .plot = record.plot};
}

/// Plots that have become empty, or were empty, are known by the times of their records.
void add_times_of(const PlotTable& plots, PlotList& list) {
  for (const PlotRecord& record : plots.plots) {
    if (record.time.empty()) continue;
    const double years = required_years_of(record.time, place_of_time(plots, record));
    MeasuredPlot& plot = list.named(record.plot);
    if (!occasion_at(plot, record.time)) add_occasion(plot, years, record.time);
  }
}

std::set<double> calendar_years(const MeasuredPlot& plot) {
  std::set<double> years;
  for (const Occasion& one : plot.occasions) years.insert(std::floor(one.years));
  return years;
}

/// Whether two plots may be of the same campaigns: as many, or one was left out of some.
bool is_of_campaigns(const MeasuredPlot& plot, const MeasuredPlot& all) {
  if (plot.occasions.size() == all.occasions.size()) return true;
  return std::ranges::includes(calendar_years(all), calendar_years(plot));
}

/// The times of all plots: those of the plot with the most. Their days are those of that plot, so
/// that only their years count for others.
/// \throws InputError if plots were measured at other times
std::vector<Occasion> common_occasions(const std::vector<MeasuredPlot>& plots,
                                       const std::string& empty,
                                       const Place& place) {
  const auto count = [](const MeasuredPlot& plot) { return plot.occasions.size(); };
  const MeasuredPlot& most = *std::ranges::max_element(plots, {}, count);
  const auto other = std::ranges::find_if_not(
      plots, [&most](const MeasuredPlot& plot) { return is_of_campaigns(plot, most); });
  if (other != plots.end()) {
    throw InputError(
        fmt::format("plots without trees and without a time are counted as empty at all times, but "
                    "the plots {} and {} were measured at different times; give these the year or "
                    "date of their measurements: {}",
                    most.plot,
                    other->plot,
                    empty),
        place);
  }
  std::vector<Occasion> occasions;
  for (const double year : calendar_years(most)) {
    occasions.push_back(
        {.years = year, .text = fmt::format("{:.0f}", year), .first = year, .last = year});
  }
  const bool has_equal_times = std::ranges::all_of(plots, [&most](const MeasuredPlot& plot) {
    return std::ranges::equal(plot.occasions, most.occasions, {}, &Occasion::text, &Occasion::text);
  });
  const bool has_short_periods = occasions.size() < most.occasions.size();
  return has_equal_times || has_short_periods ? most.occasions : occasions;
}

/// Records without a time hold for all times, so their plots have been empty at all of them.
void add_empty_plots(const PlotTable& plots,
                     const std::vector<std::string>& left_out,
                     PlotList& list) {
  std::vector<std::string> empty;
  for (const PlotRecord& record : plots.plots) {
    const bool is_known = list.number_of.contains(record.plot) ||
                          std::ranges::find(left_out, record.plot) != left_out.end();
    if (!is_known) empty.push_back(record.plot);
  }
  if (empty.empty()) return;
  for (MeasuredPlot& plot : list.plots) std::ranges::sort(plot.occasions, {}, &Occasion::years);
  const std::vector<Occasion> occasions =
      common_occasions(list.plots, data::list_of(empty), {.file = plots.file});
  for (const std::string& plot : empty) list.named(plot).occasions = occasions;
}

void add_trees(const Inventory& inventory, const std::vector<std::string>& times, PlotList& list) {
  std::map<std::pair<std::size_t, std::string>, std::size_t> number_of_tree;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    const std::size_t number = list.number_of.at(std::string(inventory.plot[row]));
    MeasuredPlot& plot = list.plots[number];
    const std::string name(inventory.tree[row]);
    const auto [found, is_new] = number_of_tree.try_emplace({number, name}, plot.trees.size());
    if (is_new) {
      plot.trees.push_back({.tree = name});
      plot.trees.back().rows.resize(plot.occasions.size());
    }
    plot.trees[found->second].rows[*occasion_at(plot, times[row])] = row;
  }
}

std::size_t trees_at(const MeasuredPlot& plot, std::size_t k) {
  return static_cast<std::size_t>(std::ranges::count_if(
      plot.trees, [k](const MeasuredTree& tree) { return tree.rows[k].has_value(); }));
}

/// Whether time k + 1 may be a later day of the visit at time k.
bool may_be_joined(const MeasuredPlot& plot, std::size_t k) {
  const Occasion& one = plot.occasions[k];
  const Occasion& next = plot.occasions[k + 1];
  if (is_year(one.last) || is_year(next.first)) return false;
  const bool is_near =
      next.first - one.last <= kBetweenVisits && next.last - one.first <= kLongestCampaign;
  return is_near && trees_at(plot, k) > 0 && trees_at(plot, k + 1) > 0 &&
         std::ranges::none_of(plot.trees, [k](const MeasuredTree& tree) {
           return tree.rows[k].has_value() && tree.rows[k + 1].has_value();
         });
}

void join(MeasuredPlot& plot, std::size_t k) {
  Occasion& one = plot.occasions[k];
  const Occasion& next = plot.occasions[k + 1];
  const auto trees = static_cast<double>(trees_at(plot, k));
  const auto added = static_cast<double>(trees_at(plot, k + 1));
  one.years = (trees * one.years + added * next.years) / (trees + added);
  one.last = next.last;
  const auto place = static_cast<std::ptrdiff_t>(k) + 1;
  for (MeasuredTree& tree : plot.trees) {
    if (tree.rows[k + 1]) tree.rows[k] = tree.rows[k + 1];
    tree.rows.erase(tree.rows.begin() + place);
  }
  plot.occasions.erase(plot.occasions.begin() + place);
}

/// A large plot takes several days, on which no tree is measured twice.
void join_days(std::vector<MeasuredPlot>& plots, std::vector<std::string>& notes) {
  std::size_t joined = 0;
  std::string first;
  for (MeasuredPlot& plot : plots) {
    for (std::size_t k = 0; k + 1 < plot.occasions.size();) {
      if (!may_be_joined(plot, k)) {
        ++k;
        continue;
      }
      if (first.empty()) {
        first = fmt::format(
            "plot {}: {} and {}", plot.plot, plot.occasions[k].text, plot.occasions[k + 1].text);
      }
      join(plot, k);
      ++joined;
    }
  }
  if (joined == 0) return;
  notes.push_back(fmt::format(
      "{} on which no tree was measured twice {} of the visit that began before {} ({})",
      counted(joined, "day", "days"),
      joined == 1 ? "is" : "are",
      joined == 1 ? "it" : "them",
      first));
}

/// Completes the values of one size; see LivingTrees::complete().
void complete_sizes(const std::vector<std::size_t>& rows,
                    const std::vector<double>& years,
                    bool has_ended,
                    std::vector<double>& sizes) {
  std::optional<std::size_t> known;  // the last one
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (std::isnan(sizes[rows[k]])) continue;
    for (std::size_t i = known ? *known + 1 : k; i < k; ++i) {
      const double share = (years[i] - years[*known]) / (years[k] - years[*known]);
      sizes[rows[i]] = std::lerp(sizes[rows[*known]], sizes[rows[k]], share);
    }
    known = k;
  }
  if (!known || !has_ended) return;
  for (std::size_t i = *known + 1; i < rows.size(); ++i) sizes[rows[i]] = sizes[rows[*known]];
}

}  // namespace

std::optional<std::size_t> occasion_at(const MeasuredPlot& plot, const std::string& time) {
  const std::optional<double> years = years_of(time);
  if (!years) return std::nullopt;
  std::vector<double> occasions;
  for (const Occasion& one : plot.occasions) {
    // A day of a visit is the visit.
    occasions.push_back(std::clamp(*years, one.first, one.last));
  }
  return same_time(occasions, *years);
}

std::vector<MeasuredPlot> measured_plots(const Inventory& inventory,
                                         const PlotTable* plots,
                                         std::vector<std::string>& notes) {
  if (inventory.time.size() == 0) {
    throw InputError(
        "growth needs the year or date of each row; name its column with `columns=year=COLUMN`",
        {.file = inventory.file});
  }
  const std::vector<std::string> times = times_of_rows(inventory, notes);
  PlotList list;
  // A year is that of a date in it, so dates come first.
  for (const bool are_dates : {true, false}) {
    for (std::size_t row = 0; row < inventory.size(); ++row) {
      MeasuredPlot& plot = list.named(std::string(inventory.plot[row]));
      const double years = *years_of(times[row]);
      if (is_year(years) == are_dates) continue;
      if (are_dates || !occasion_at(plot, times[row])) add_occasion(plot, years, times[row]);
    }
  }
  if (plots != nullptr) {
    add_times_of(*plots, list);
    add_empty_plots(*plots, inventory.plots_left_out, list);
  }
  for (MeasuredPlot& plot : list.plots) std::ranges::sort(plot.occasions, {}, &Occasion::years);
  add_trees(inventory, times, list);
  join_days(list.plots, notes);
  return std::move(list.plots);
}

PlotTable with_times_read(PlotTable plots, std::vector<std::string>& notes) {
  std::vector<std::string> texts;
  for (const PlotRecord& record : plots.plots) texts.push_back(record.time);
  ColumnTimes times(texts);
  for (PlotRecord& record : plots.plots) {
    record.time = times.read(record.plot, record.time, place_of_time(plots, record));
  }
  if (std::string note = times.note(); !note.empty()) {
    notes.push_back(fmt::format("in the table of plots, {}", note));
  }
  return plots;
}

std::size_t LivingTrees::add(std::size_t row, const std::string& label, bool is_measured) {
  rows_.push_back(row);
  result_.plot.append(label);
  result_.tree.append(source_.tree[row]);
  source_.species.is_missing(row) ? result_.species.append_missing()
                                  : result_.species.append(source_.species[row]);
  const auto copy = [&](const std::vector<double>& from, std::vector<double>& to, bool is_known) {
    if (!from.empty()) to.push_back(is_known ? from[row] : data::kMissing);
  };
  copy(source_.x, result_.x, true);
  copy(source_.y, result_.y, true);
  copy(source_.dbh_cm, result_.dbh_cm, is_measured);
  copy(source_.h_m, result_.h_m, is_measured);
  result_.quantities.resize(source_.quantities.size());
  for (std::size_t i = 0; i < source_.quantities.size(); ++i) {
    result_.quantities[i].name = source_.quantities[i].name;
    result_.quantities[i].unit = source_.quantities[i].unit;
    copy(source_.quantities[i].values, result_.quantities[i].values, is_measured);
  }
  if (row < source_.lines.size()) result_.lines.push_back(source_.lines[row]);
  result_.neighbor_only.push_back(std::isnan(result_.dbh_cm.back()) ? 1 : 0);
  return rows_.size() - 1;
}

std::vector<std::size_t> LivingTrees::complete(const std::vector<std::size_t>& rows,
                                               const std::vector<double>& years,
                                               bool has_ended) {
  std::vector<std::size_t> without_dbh;
  std::ranges::copy_if(rows, std::back_inserter(without_dbh), [this](std::size_t row) {
    return std::isnan(result_.dbh_cm[row]);
  });
  complete_sizes(rows, years, has_ended, result_.dbh_cm);
  if (!result_.h_m.empty()) complete_sizes(rows, years, has_ended, result_.h_m);
  for (TreeQuantity& quantity : result_.quantities) {
    complete_sizes(rows, years, has_ended, quantity.values);
  }
  std::erase_if(without_dbh, [this](std::size_t row) { return std::isnan(result_.dbh_cm[row]); });
  for (const std::size_t row : without_dbh) result_.neighbor_only[row] = 0;
  return without_dbh;
}

Inventory LivingTrees::finish() && {
  result_.file = source_.file;
  result_.expansion = source_.expansion;
  result_.trusts_units = source_.trusts_units;
  result_.position_unit_m = source_.position_unit_m;
  result_.other = source_.other.select(rows_);
  return std::move(result_);
}

}  // namespace silvafit::stand
