// SPDX-License-Identifier: MIT
#include "silvafit/stand/plots_at_times.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "silvafit/base/error.hpp"
#include "trees/measurement_time.hpp"

namespace silvafit::stand {
namespace {

using TimesOfPlots = std::map<std::string, std::vector<std::string>>;

TimesOfPlots times_of(const std::vector<PlotAtTime>& plots) {
  TimesOfPlots times;
  for (const PlotAtTime& one : plots) times[one.plot].push_back(one.time);
  return times;
}

/// The time of a plot that a text means, which may be written in another way; else the text.
std::string own_time(const std::vector<std::string>& times, const std::string& text) {
  if (std::ranges::find(times, text) != times.end()) return text;
  const std::optional<std::size_t> same = same_time(times, text);
  return same ? times[*same] : text;
}

/// The labels that a row of a table of plots is for.
std::vector<std::string> labels_of(const PlotRecord& record, const TimesOfPlots& times) {
  const auto found = times.find(record.plot);
  const std::vector<std::string> none;
  const std::vector<std::string>& own = found == times.end() ? none : found->second;
  if (!record.time.empty()) return {label_at_time(record.plot, own_time(own, record.time))};
  if (own.empty()) return {record.plot};
  std::vector<std::string> labels;
  for (const std::string& time : own) labels.push_back(label_at_time(record.plot, time));
  return labels;
}

}  // namespace

std::vector<PlotAtTime> plots_at_times(const Inventory& inventory) {
  std::vector<PlotAtTime> plots;
  std::set<std::uint32_t> seen;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    if (!seen.insert(inventory.plot.code(row)).second) continue;
    plots.push_back({.plot = std::string(inventory.measured_plot[row]),
                     .time = std::string(inventory.time[row])});
  }
  return plots;
}

std::vector<NamedWindow> windows_at_times(const std::vector<NamedWindow>& windows,
                                          const std::vector<PlotAtTime>& plots) {
  const TimesOfPlots times = times_of(plots);
  std::vector<NamedWindow> result;
  for (const NamedWindow& window : windows) {
    if (!window.plot && times.size() > 1) {
      throw UsageError(fmt::format("one window is given for {} plots, each of which needs its own "
                                   "with repeated measurements; give each polygon the property "
                                   "'plot' ('*' for every plot)",
                                   times.size()),
                       {.column = "`window`"});
    }
    if (window.plot == kEveryPlot) result.push_back(window);
    for (const auto& [plot, own_times] : times) {
      if (window.plot && *window.plot != plot) continue;
      for (const std::string& time : own_times) {
        result.push_back({.plot = label_at_time(plot, time), .window = window.window});
      }
    }
  }
  return result;
}

SamplingDesign design_at_times(SamplingDesign design, const std::vector<PlotAtTime>& plots) {
  if (!design.plots) return design;
  const TimesOfPlots times = times_of(plots);
  std::vector<PlotRecord> records;
  for (const PlotRecord& record : design.plots->plots) {
    for (std::string& label : labels_of(record, times)) {
      records.push_back(record);
      records.back().plot = std::move(label);
    }
  }
  design.plots->plots = std::move(records);
  return design;
}

}  // namespace silvafit::stand
