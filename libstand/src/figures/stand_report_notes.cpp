// SPDX-License-Identifier: MIT
// The notes of a stand report.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "figures/report_maker.hpp"
#include "sampling/plot_areas.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/stand/similar_plots.hpp"
#include "units/edge.hpp"

namespace silvafit::stand {

void ReportMaker::note_areas() {
  if (sample_ != nullptr) note(sample_->notes);
  if (sample_ == nullptr && !expansion_.empty()) {
    note(
        {"the trees have factors of trees per ha, which are not used: each counts as one tree on "
         "the area of `plot_area`, `window` or `circle`"});
  }
  if (is_hull_) {
    note(
        {"areas are those of convex hulls, which are smaller than the plots, so values per "
         "hectare are too large; give `window`, `circle` or `plot_area`" +
         offered_});
  }
  if (options_.plot_area_m2 && !offered_.empty()) {
    note({fmt::format("every plot counts as {:.10g} m2 by `plot_area`; keep this{}",
                      *options_.plot_area_m2,
                      offered_)});
  }
  if (smaller_than_hull_.plots > 0) {
    note({fmt::format(
        "{} a smaller area than the convex hull of the trees ({}), so values per hectare are too "
        "large, unless trees beside the plot are in the table; check the areas",
        counted(smaller_than_hull_.plots, "plot has", "plots have"),
        smaller_than_hull_.first)});
  }
  if (larger_than_hull_.plots > 0) {
    note({fmt::format("all trees of {} on less than a tenth of the area ({}); check the areas",
                      counted(larger_than_hull_.plots, "plot stand", "plots stand"),
                      larger_than_hull_.first)});
  }
  note_dense_plots();
  // Redwoods and other giants of wet coasts exceed it.
  constexpr double kUsualBasalArea = 120.0;
  const double basal_area = report_.all.basal_area_m2_per_ha;
  if (!options_.trust_units && basal_area > kUsualBasalArea) {
    note({fmt::format(
        "{:.0f} m2 of basal area per hectare are more than nearly all forests have: check {}, and "
        "that dbh is the diameter in cm; of circumferences use `columns=dbh=COLUMN/pi`, of "
        "millimeters `columns=dbh=COLUMN/10`",
        basal_area,
        is_hull_ ? "that positions are in meters and of one plot (`columns=plot=COLUMN`)"
                 : "the areas")});
  }
  if (!plots_of_table_without_trees_.empty()) {
    note({fmt::format("{}: {}",
                      counted(plots_of_table_without_trees_.size(),
                              "plot of the table has no tree and is counted as empty",
                              "plots of the table have no tree and are counted as empty"),
                      data::list_of(plots_of_table_without_trees_))});
  }
  if (!plots_of_table_without_window_.empty()) {
    note({fmt::format("{} neither a tree nor a window and {} not counted: {}",
                      counted(plots_of_table_without_window_.size(),
                              "plot of the table has",
                              "plots of the table have"),
                      plots_of_table_without_window_.size() == 1 ? "is" : "are",
                      data::list_of(plots_of_table_without_window_))});
  }
  if (plots_without_window_.empty()) return;
  note({fmt::format(
      "{} not counted, with {}: plot {}; fewer than three trees, or trees on one line, have no "
      "convex hull and therefore no area; give `window`, `circle` or `plot_area`",
      counted(plots_without_window_count_, "plot is", "plots are"),
      counted(without_window_, "tree", "trees"),
      plots_without_window_.text())});
}

/// A plot may be denser than any forest because it is small, or because its area is wrong.
void ReportMaker::note_dense_plots() {
  if (options_.trust_units) return;
  const auto density = [](const AreaReport& plot) { return plot.figures.basal_area_m2_per_ha; };
  const auto count = std::ranges::count_if(
      report_.areas, [](double value) { return value > kImpossibleBasalArea; }, density);
  if (count == 0) return;
  const auto& densest = *std::ranges::max_element(report_.areas, {}, density);
  note(
      {fmt::format("{} more basal area per hectare than any forest (plot {}: {:.4g} m2 on {:.6g} "
                   "m2); check the areas",
                   counted(static_cast<std::size_t>(count), "plot has", "plots have"),
                   densest.area.name,
                   density(densest),
                   densest.area.area_m2)});
}

/// Plots whose trees are all dead or cut count where their area is known.
void ReportMaker::note_plots_without_trees() {
  std::vector<std::string> unknown;
  std::vector<std::string> counted_ones;
  for (const std::string& plot : plots_without_trees_) {
    const bool is_counted = std::ranges::any_of(
        report_.areas, [&plot](const AreaReport& one) { return one.area.name == plot; });
    (is_counted ? counted_ones : unknown).push_back(plot);
  }
  const auto say = [this](const std::vector<std::string>& plots, std::string_view what) {
    if (plots.empty()) return;
    note({fmt::format("{} no living tree and {}: {}",
                      counted(plots.size(), "plot has", "plots have"),
                      what,
                      data::list_of(plots))});
  };
  say(counted_ones, counted_ones.size() == 1 ? "counts as empty" : "count as empty");
  say(unknown,
      unknown.size() == 1 ? "is not counted, because its area is unknown"
                          : "are not counted, because their areas are unknown");
}

void ReportMaker::note_trees_left_out() {
  outside_ -= without_window_;
  if (without_position_ > 0) {
    note({counted(without_position_,
                  "tree without position is not counted",
                  "trees without position are not counted")});
  }
  if (outside_ > 0) note({outside_text(is_outside_note_of_units())});
  const std::size_t others = plots_of_table_without_trees_.size() + plots_without_trees_.size();
  const std::size_t with_window = options_.plot_area_m2 || empty_ < others ? 0 : empty_ - others;
  if (with_window > 0) {
    note({counted(with_window,
                  "plot with a window has no tree; it is counted as empty",
                  "plots with a window have no tree; they are counted as empty")});
  }
}

/// Their trees are unknown, so they are not plots without trees.
void ReportMaker::note_plots_left_out() {
  const std::vector<std::string>& names = plots_left_out_;
  if (names.empty()) return;
  note({fmt::format(
      "plot {} {} treated as unknown and not counted, because all {} rows were skipped, or lack a "
      "dbh or a position. For an empty plot, remove these rows from the file and list the plot in "
      "a "
      "table of `plots`, or give a window with its name",
      data::list_of(names),
      names.size() == 1 ? "is" : "are",
      names.size() == 1 ? "its" : "their")});
}

/// Whether the structural units have a note on the trees outside and use them as neighbors.
bool ReportMaker::is_outside_note_of_units() const {
  const std::string own = outside_note(outside_, options_.units.edge);
  return std::ranges::find(notes_on_units_, own) != notes_on_units_.end() &&
         options_.units.edge != EdgeCorrection::kTorus;
}

std::string ReportMaker::outside_text(bool are_neighbors) const {
  std::string text = counted(outside_,
                             "tree outside the windows is not counted",
                             "trees outside the windows are not counted");
  if (!are_neighbors) return text;
  return text + (outside_ == 1 ? ", but is used as a neighbor" : ", but are used as neighbors");
}

void ReportMaker::note_strata() {
  note(notes_on_strata_);
  data::TextColumn names;
  for (const StratumFigures& stratum : report_.strata) {
    if (stratum.kind == StratumFigures::Kind::kStratum) names.append(stratum.name);
  }
  if (names.size() > 1) {
    if (std::string similar = describe_similar_labels(names, "stratum"); !similar.empty()) {
      note({std::move(similar)});
    }
    note({stratum_sizes_.empty()
              ? "strata have no areas (column stratum_area of the table of plots): the row of all "
                "takes the plots of all strata as one sample"
              : "tables of species and diameters are means of all plots, without the areas of "
                "strata; `by=species` has estimates with them"});
  }
  if (without_stratum_.empty()) return;
  note({fmt::format(
      "plot {} {} no stratum in the column {}; {} values are in the row '(none)'{}",
      without_stratum_.text(),
      without_stratum_count_ == 1 ? "has" : "have",
      options_.stratum,
      without_stratum_count_ == 1 ? "its" : "their",
      options_.stratum_areas_ha.empty() ? "" : ", which the row of all strata does not include")});
}

void ReportMaker::note_units() {
  // The number of trees outside is in another note, with how they are used.
  const std::string outside = outside_note(outside_, options_.units.edge);
  for (const std::string& text : notes_on_units_) {
    if (text != outside) note({text});
  }
}

/// Why standard errors are missing where a stratum has one plot.
void ReportMaker::note_single_plots() {
  std::vector<std::string> names;
  for (const StratumFigures& stratum : report_.strata) {
    if (stratum.kind == StratumFigures::Kind::kAll || stratum.plots != 1) continue;
    const bool is_stratum = stratum.kind == StratumFigures::Kind::kStratum;
    names.push_back(is_stratum ? stratum.name : "(none)");
  }
  if (names.empty()) return;
  const bool is_one = names.size() == 1;
  const bool has_total = std::isfinite(report_.strata.back().stems.standard_error);
  note(
      {fmt::format("the {} {} {} only one plot; a variance needs two plots, so {} no standard "
                   "error{}",
                   is_one ? "stratum" : "strata",
                   data::list_of(names),
                   is_one ? "has" : "each have",
                   is_one ? "it has" : "they have",
                   has_total ? "" : ", and neither has the total over all strata")});
}

/// If only some trees were measured, the tallest may not be among them.
void ReportMaker::note_dominant_height() {
  std::vector<std::string> names;
  for (const AreaReport& area : report_.areas) {
    const StandFigures& figures = area.figures;
    const bool lacks = figures.dominant_trees_without_height > 0;
    if (!lacks || !std::isfinite(figures.dominant_height_m)) continue;
    names.push_back(fmt::format("{} ({} of {})",
                                area.area.name.empty() ? "stand" : area.area.name,
                                figures.dominant_trees_without_height,
                                figures.dominant_trees));
  }
  if (names.empty()) return;
  note(
      {fmt::format("some of the thickest trees have no height, and dominant height is the mean of "
                   "the others: {}; to impute heights, use `silvafit impute`",
                   data::list_of(names))});
}

void ReportMaker::write_notes() {
  note_areas();
  if (sample_ == nullptr) note_trees_left_out();
  note_plots_left_out();
  note_plots_without_trees();
  note_strata();
  note_units();
  note_single_plots();
  if (std::string text = note_on_crown_cover(report_.all); !text.empty()) note({std::move(text)});
  note_dominant_height();
}

void ReportMaker::note(const std::vector<std::string>& notes) {
  report_.notes.insert(report_.notes.end(), notes.begin(), notes.end());
}

}  // namespace silvafit::stand
