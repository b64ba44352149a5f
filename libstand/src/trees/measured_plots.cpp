// SPDX-License-Identifier: MIT
#include "trees/measured_plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "trees/measurement_time.hpp"

namespace silvafit::stand {
namespace {

double time_in(const std::string& text, const Place& place) {
  const std::optional<double> years = years_of(text);
  if (years) return *years;
  throw InputError(text.empty()
                       ? std::string("the year or date is missing")
                       : fmt::format("'{}' is not a year or date, such as 2019, 2019-06-30 or "
                                     "30.06.2019",
                                     text),
                   place);
}

void add_occasion(MeasuredPlot& plot, double years, const std::string& text) {
  const auto is_same = [years](const Occasion& one) { return is_same_time(one.years, years); };
  if (std::ranges::any_of(plot.occasions, is_same)) return;
  plot.occasions.push_back({.years = years, .text = text});
}

double between(double first, double second, double share) {
  return first + share * (second - first);
}

}  // namespace

std::optional<std::size_t> occasion_at(const MeasuredPlot& plot, const std::string& time) {
  const std::optional<double> years = years_of(time);
  if (!years) return std::nullopt;
  std::vector<double> occasions;
  for (const Occasion& one : plot.occasions) occasions.push_back(one.years);
  return same_time(occasions, *years);
}

std::vector<MeasuredPlot> measured_plots(const Inventory& inventory, const PlotTable* plots) {
  if (inventory.time.size() == 0) {
    throw InputError(
        "growth needs the year or date of each row; name its column with `columns=year=COLUMN`",
        {.file = inventory.file});
  }
  std::vector<MeasuredPlot> result;
  std::unordered_map<std::string, std::size_t> number_of_plot;
  const auto plot_named = [&](const std::string& name) -> MeasuredPlot& {
    const auto [found, is_new] = number_of_plot.try_emplace(name, result.size());
    if (is_new) result.push_back({.plot = name});
    return result[found->second];
  };
  std::vector<double> years;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    const std::string text(inventory.time[row]);
    Place place = inventory.place(row);
    place.column = "year";
    years.push_back(time_in(text, place));
    add_occasion(plot_named(std::string(inventory.plot[row])), years.back(), text);
  }
  if (plots != nullptr && plots->has_time) {
    for (const PlotRecord& record : plots->plots) {
      const Place place{
          .file = plots->file, .line = record.line, .column = "year", .plot = record.plot};
      const double time = time_in(record.time, place);
      MeasuredPlot& plot = plot_named(record.plot);
      if (!occasion_at(plot, record.time)) add_occasion(plot, time, record.time);
    }
  }
  for (MeasuredPlot& plot : result) std::ranges::sort(plot.occasions, {}, &Occasion::years);
  std::map<std::pair<std::size_t, std::string>, std::size_t> number_of_tree;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    const std::size_t number = number_of_plot.at(std::string(inventory.plot[row]));
    MeasuredPlot& plot = result[number];
    const std::string name(inventory.tree[row]);
    const auto [found, is_new] = number_of_tree.try_emplace({number, name}, plot.trees.size());
    if (is_new) {
      plot.trees.push_back({.tree = name});
      plot.trees.back().rows.resize(plot.occasions.size());
    }
    plot.trees[found->second].rows[*occasion_at(plot, std::string(inventory.time[row]))] = row;
  }
  return result;
}

std::size_t LivingTrees::add(std::size_t row, const std::string& label) {
  return add_between(row, row, 0.0, label);
}

std::size_t LivingTrees::add_between(std::size_t first,
                                     std::size_t second,
                                     double share,
                                     const std::string& label) {
  rows_.push_back(first);
  result_.plot.append(label);
  result_.tree.append(source_.tree[first]);
  source_.species.is_missing(first) ? result_.species.append_missing()
                                    : result_.species.append(source_.species[first]);
  const auto copy = [&](const std::vector<double>& from, std::vector<double>& to) {
    if (!from.empty()) to.push_back(between(from[first], from[second], share));
  };
  copy(source_.x, result_.x);
  copy(source_.y, result_.y);
  copy(source_.dbh_cm, result_.dbh_cm);
  copy(source_.h_m, result_.h_m);
  result_.quantities.resize(source_.quantities.size());
  for (std::size_t i = 0; i < source_.quantities.size(); ++i) {
    result_.quantities[i].name = source_.quantities[i].name;
    result_.quantities[i].unit = source_.quantities[i].unit;
    copy(source_.quantities[i].values, result_.quantities[i].values);
  }
  if (first < source_.lines.size()) result_.lines.push_back(source_.lines[first]);
  result_.neighbor_only.push_back(std::isnan(result_.dbh_cm.back()) ? 1 : 0);
  return rows_.size() - 1;
}

Inventory LivingTrees::finish() && {
  result_.file = source_.file;
  result_.expansion = source_.expansion;
  result_.trusts_units = source_.trusts_units;
  result_.other = source_.other.select(rows_);
  return std::move(result_);
}

}  // namespace silvafit::stand
