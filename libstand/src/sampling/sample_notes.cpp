// SPDX-License-Identifier: MIT
// What a sample leaves out, and what was assumed.
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "sampling/plot_areas.hpp"
#include "sampling/sample_maker.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/similar_plots.hpp"

namespace silvafit::stand {
namespace {

/// The labels of a list, and a remark on almost equal labels of another list.
std::string with_similar(const std::vector<std::string>& names,
                         const std::vector<std::string>& others) {
  data::TextColumn both;
  for (const std::string& name : names) both.append(name);
  for (const std::string& other : others) both.append(other);
  const std::string similar = describe_similar_labels(both);
  return data::list_of(names) + (similar.empty() ? "" : " (" + similar + ")");
}

bool has_partial_plots(const PlotTable& plots) {
  return std::ranges::any_of(plots.plots, [](const PlotRecord& record) {
    return !std::isnan(record.share) && record.share != 1.0 && record.share != 0.0;
  });
}

}  // namespace

/// Areas of the table of plots beside circles, which have areas of their own.
void SampleMaker::note_unused_areas() {
  if (design_.circles.empty()) return;
  std::size_t others = 0;
  std::string first;
  for (std::size_t code = 0; code < records_.size(); ++code) {
    const PlotRecord* const record = records_[code];
    if (record == nullptr) continue;
    const double recorded = recorded_area_m2(*record, design_.subplots, design_.plots->file);
    const double area = plot_area_m2(record);
    const bool is_same =
        is_same_area(recorded, area) || is_same_area(recorded, area * slope_cosine(record));
    if (std::isnan(recorded) || is_same || others++ > 0) continue;
    first = fmt::format("plot {}: {:.6g} m2, its largest circle {:.6g} m2",
                        inventory_.plot.levels()[code],
                        recorded,
                        area);
  }
  if (others == 0) return;
  sample_.notes.push_back(
      fmt::format("areas of the table of plots are not used: the circles have others for {}, the "
                  "first: {}; parts of plots are the column share",
                  counted(others, "plot", "plots"),
                  first));
}

void SampleMaker::note_unmatched() {
  std::vector<std::string> without_row;
  std::vector<std::string> without_trees;
  for (std::size_t code = 0; code < records_.size(); ++code) {
    if (records_[code] == nullptr) without_row.push_back(inventory_.plot.levels()[code]);
  }
  std::vector<std::string> outside;
  for (const PlotRecord& record : design_.plots->plots) {
    if (record.share == 0.0) outside.push_back(record.plot);
    const bool has_trees = inventory_.plot.code_of(record.plot) != data::TextColumn::kMissingCode;
    const auto& left_out = inventory_.plots_left_out;
    const bool is_unknown = std::ranges::find(left_out, record.plot) != left_out.end();
    if (!has_trees && !is_unknown && record.share != 0.0) without_trees.push_back(record.plot);
  }
  if (without_row.size() == records_.size() && !records_.empty()) {
    std::vector<std::string> of_table;
    for (const PlotRecord& record : design_.plots->plots) of_table.push_back(record.plot);
    throw InputError(
        fmt::format(
            "no plot of the inventory is in the table of plots; the inventory has {}; the "
            "table has {}; name the column of the label with `plots_columns=plot=COLUMN` or "
            "`columns=plot=COLUMN`",
            data::list_of(without_row),
            with_similar(of_table, without_row)),
        {.file = design_.plots->file, .column = "plot"});
  }
  data::TextColumn unmatched;
  for (const auto* const names : {&without_row, &without_trees}) {
    for (const std::string& name : *names) unmatched.append(name);
  }
  if (const std::string similar = describe_similar_labels(unmatched); !similar.empty()) {
    throw InputError("the plots of the inventory and of the table have other labels: " + similar +
                         "; write them alike",
                     {.file = design_.plots->file, .column = "plot"});
  }
  if (!without_row.empty()) {
    sample_.notes.push_back(
        fmt::format("{} not in the table of plots{}: {}",
                    counted(without_row.size(), "plot is", "plots are"),
                    uses_table_areas() ? " and not counted, because the area is unknown" : "",
                    data::list_of(without_row)));
  }
  if (!without_trees.empty()) {
    sample_.notes.push_back(
        fmt::format("{}: {}",
                    counted(without_trees.size(),
                            "plot of the table has no tree and is counted as empty",
                            "plots of the table have no tree and are counted as empty"),
                    data::list_of(without_trees)));
  }
  note_gaps();
  if (!outside.empty()) {
    sample_.notes.push_back(
        fmt::format("{} share 0, no part in the population, and {} with area 0: {}",
                    counted(outside.size(), "plot of the table has", "plots of the table have"),
                    outside.size() == 1 ? "counts" : "count",
                    data::list_of(outside)));
  }
}

/// Plots of the table without a number that is needed.
void SampleMaker::note_gaps() {
  std::vector<std::string> without_area;
  std::vector<std::string> without_slope;
  for (const PlotRecord& record : design_.plots->plots) {
    if (uses_table_areas() && std::isnan(plot_area_m2(&record))) {
      without_area.push_back(record.plot);
    }
    if (design_.corrects_slope && std::isnan(record.slope_deg)) {
      without_slope.push_back(record.plot);
    }
  }
  // If none has an area, that is an error elsewhere.
  if (!without_area.empty() && without_area.size() < design_.plots->plots.size()) {
    sample_.notes.push_back(
        fmt::format("{} in the table and not counted: {}",
                    counted(without_area.size(), "plot has no area", "plots have no area"),
                    data::list_of(without_area)));
  }
  if (!without_slope.empty()) {
    sample_.notes.push_back(
        fmt::format("{} in the table and taken as level: {}",
                    counted(without_slope.size(), "plot has no slope", "plots have no slope"),
                    data::list_of(without_slope)));
  }
}

void SampleMaker::note_counts() {
  if (below_smallest_ > 0) {
    sample_.notes.push_back(
        fmt::format("{} below dbh {} cm, the smallest that is counted",
                    counted(below_smallest_, "tree is not counted:", "trees are not counted:"),
                    smallest_dbh_cm_));
  }
  if (outside_ > 0) {
    sample_.notes.push_back(
        fmt::format("{} farther from the center than trees of this dbh are counted, the first: {}",
                    counted(outside_, "tree is not counted:", "trees are not counted:"),
                    first_outside_));
  }
  if (outside_population_ > 0) {
    sample_.notes.push_back(
        fmt::format("{} outside the population, the first: {}",
                    counted(outside_population_, "tree is not counted:", "trees are not counted:"),
                    first_outside_population_));
  }
  if (without_factor_ > 0) {
    sample_.notes.push_back(fmt::format("{} no expansion factor and {} not counted",
                                        counted(without_factor_, "tree has", "trees have"),
                                        without_factor_ == 1 ? "is" : "are"));
  }
  if (!design_.expansion.empty() && design_.plots && has_partial_plots(*design_.plots)) {
    sample_.notes.emplace_back(
        design_.is_expansion_of_part
            ? "expansion factors are per hectare of the part of a plot in the population"
            : "expansion factors are per hectare of whole plots, so values of plots with a share "
              "are divided by it; if factors are per hectare of that part already, use "
              "`expansion_area=part`");
  }
  if (design_.plots && design_.plots->slope_lacks_unit && design_.corrects_slope) {
    sample_.notes.emplace_back(
        "the column slope is read in degrees; if it is in percent, name it slope_percent");
  }
  if (design_.plots && design_.plots->has_slope && !design_.corrects_slope) {
    sample_.notes.emplace_back(
        "the column slope is not used: distances are taken as horizontal; with `slope_correction`, "
        "areas are those along the slope");
  }
}

}  // namespace silvafit::stand
