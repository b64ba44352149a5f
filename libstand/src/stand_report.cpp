// SPDX-License-Identifier: MIT
#include "silvafit/stand/stand_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "edge.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::stand {
namespace {

constexpr double kQuadratMeters = 10.0;

class ReportMaker {
 public:
  /// \param sample  none: the inventory has no sampling design, or its areas are given otherwise
  ReportMaker(const Inventory& inventory,
              const StandReportOptions& options,
              const DesignedSample* sample)
      : inventory_(inventory), options_(options), sample_(sample) {}

  StandReport run();

 private:
  std::vector<SampledArea> find_areas();
  void note_plots_without_window(const PlotWindows& windows);
  void note_plots_left_out();
  void note_trees_left_out(const std::vector<SampledArea>& areas);
  data::TextColumn stratum_column() const;
  void check_one_stratum(const SampledArea& area, const data::TextColumn& column) const;
  std::vector<std::string> strata_of(std::vector<SampledArea>& areas);
  std::vector<std::string> strata_of_table(const std::vector<SampledArea>& areas);
  void add_structure();
  std::string outside_text(bool are_neighbors) const;
  void add_species(const std::vector<SampledArea>& areas);
  void note_single_plots();
  StructuralUnits compute_units() const;
  AreaReport report_on(SampledArea area) const;
  void add_figures(std::vector<SampledArea> areas, const std::vector<std::string>& strata);
  void note_dominant_height();

  const Inventory& inventory_;
  const StandReportOptions& options_;
  const DesignedSample* sample_;
  StandReport report_{};
  std::map<std::string, double> stratum_sizes_{};
  bool are_weights_ = false;
  std::size_t outside_ = 0;         ///< trees with a position that are outside of a window
  std::size_t without_window_ = 0;  ///< trees with a position whose plot has no window
};

std::vector<SampledArea> ReportMaker::find_areas() {
  if (sample_ != nullptr) {
    report_.notes = sample_->notes;
    return sample_->areas;
  }
  const bool has_window = !options_.units.windows.empty();
  if (options_.plot_area_m2 && has_window) {
    throw UsageError("use either --plot-area or windows (--window, --circle), not both",
                     {.column = "--plot-area"});
  }
  if (options_.plot_area_m2) return sampled_areas(inventory_, *options_.plot_area_m2);
  if (!inventory_.has_coordinates()) {
    throw UsageError(
        "the area is unknown, because the inventory has no positions; give the area of a plot in "
        "m2 with --plot-area",
        {.file = inventory_.file});
  }
  const PlotWindows windows =
      plot_windows(inventory_, options_.units.windows, options_.units.scope);
  if (windows.is_assumed) {
    report_.notes.emplace_back(
        "areas are those of convex hulls, which are smaller than the plots, so values per hectare "
        "are too large; give --window, --circle or --plot-area");
  }
  if (!windows.plots_without_window.empty()) note_plots_without_window(windows);
  return sampled_areas(inventory_, windows, options_.units.windows);
}

/// Their trees are neither counted nor outside a window.
void ReportMaker::note_plots_without_window(const PlotWindows& windows) {
  for (std::size_t tree = 0; tree < inventory_.size(); ++tree) {
    const bool has_position = !std::isnan(inventory_.x[tree]) && !std::isnan(inventory_.y[tree]);
    if (has_position && windows.window_of(inventory_, tree) == nullptr) ++without_window_;
  }
  const std::vector<std::string>& names = windows.plots_without_window;
  report_.notes.push_back(fmt::format(
      "{} not counted, with {}: plot {}; fewer than three trees, or trees on one line, have no "
      "convex hull and therefore no area; give --window, --circle or --plot-area",
      counted(names.size(), "plot is", "plots are"),
      counted(without_window_, "tree", "trees"),
      data::list_of(names)));
}

/// Strata are in the table of plots, which plots without trees have, too.
std::vector<std::string> ReportMaker::strata_of_table(const std::vector<SampledArea>& areas) {
  DesignStrata strata = strata_of_plots(*options_.design.plots, areas);
  report_.notes.insert(report_.notes.end(), strata.notes.begin(), strata.notes.end());
  if (stratum_sizes_.empty()) {
    stratum_sizes_ = std::move(strata.sizes);
    are_weights_ = strata.are_weights;
  }
  return std::move(strata.stratum_of_area);
}

/// Their trees are unknown, so they are not plots without trees.
void ReportMaker::note_plots_left_out() {
  const std::vector<std::string>& names = inventory_.plots_left_out;
  if (names.empty()) return;
  report_.notes.push_back(fmt::format(
      "plot {} {} treated as unknown and not counted, because all {} rows were skipped. For "
      "an empty plot, remove {} rows from the file and give {} window with the plot's name",
      data::list_of(names),
      names.size() == 1 ? "is" : "are",
      names.size() == 1 ? "its" : "their",
      names.size() == 1 ? "its" : "their",
      names.size() == 1 ? "its" : "their"));
}

void ReportMaker::note_trees_left_out(const std::vector<SampledArea>& areas) {
  std::vector<char> is_in_area(inventory_.size(), 0);
  std::size_t empty = 0;
  for (const SampledArea& area : areas) {
    for (const std::size_t tree : area.trees) is_in_area[tree] = 1;
    if (area.trees.empty()) ++empty;
  }
  std::size_t without_position = 0;
  for (std::size_t tree = 0; tree < inventory_.size(); ++tree) {
    if (is_in_area[tree] != 0) continue;
    const bool has_position = inventory_.has_coordinates() && !std::isnan(inventory_.x[tree]) &&
                              !std::isnan(inventory_.y[tree]);
    ++(has_position ? outside_ : without_position);
  }
  outside_ -= without_window_;
  if (without_position > 0) {
    report_.notes.push_back(counted(without_position,
                                    "tree without position is not counted",
                                    "trees without position are not counted"));
  }
  if (outside_ > 0) report_.notes.push_back(outside_text(false));
  if (empty > 0) {
    report_.notes.push_back(counted(empty,
                                    "plot with a window has no tree; it is counted as empty",
                                    "plots with a window have no tree; they are counted as empty"));
  }
}

std::string ReportMaker::outside_text(bool are_neighbors) const {
  std::string text = counted(outside_,
                             "tree outside the windows is not counted",
                             "trees outside the windows are not counted");
  if (!are_neighbors) return text;
  return text + (outside_ == 1 ? ", but is used as a neighbor" : ", but are used as neighbors");
}

/// Any column of the inventory may contain the strata, standard columns as well.
data::TextColumn ReportMaker::stratum_column() const {
  if (inventory_.other.has(options_.stratum)) return inventory_.other.labels(options_.stratum);
  const data::Table table = to_table(inventory_);
  if (table.has(options_.stratum)) return table.labels(options_.stratum);
  throw InputError(data::no_such_column(options_.stratum, table.names()),
                   {.file = inventory_.file, .column = "--stratum"});
}

void ReportMaker::check_one_stratum(const SampledArea& area, const data::TextColumn& column) const {
  const std::size_t first = area.trees.front();
  const auto name_of = [&column](std::size_t row) {
    return column.is_missing(row) ? "none" : fmt::format("'{}'", column[row]);
  };
  for (const std::size_t tree : area.trees) {
    if (column.code(tree) == column.code(first)) continue;
    Place place = inventory_.place(tree);
    place.column = options_.stratum;
    throw InputError(
        fmt::format("the plot belongs to two strata, {} and {}", name_of(first), name_of(tree)),
        place);
  }
}

/// The stratum of each area; areas without trees have none and are removed from the list.
std::vector<std::string> ReportMaker::strata_of(std::vector<SampledArea>& areas) {
  std::vector<std::string> strata;
  if (options_.stratum.empty()) {
    const bool has_table = options_.design.plots && options_.design.plots->has_stratum;
    return has_table ? strata_of_table(areas) : strata;
  }
  const data::TextColumn column = stratum_column();
  std::vector<std::string> without_stratum;
  const auto left_out =
      std::erase_if(areas, [](const SampledArea& area) { return area.trees.empty(); });
  if (left_out > 0) {
    report_.notes.push_back(counted(left_out,
                                    "plot without trees belongs to no stratum and is skipped",
                                    "plots without trees belong to no stratum and are skipped"));
  }
  for (const SampledArea& area : areas) {
    check_one_stratum(area, column);
    const std::size_t first = area.trees.front();
    strata.emplace_back(column.is_missing(first) ? std::string_view() : column[first]);
    if (strata.back().empty()) without_stratum.push_back(area.name);
  }
  if (!without_stratum.empty()) {
    report_.notes.push_back(fmt::format(
        "plot {} {} no stratum in the column {}; {} values are in the row '(none)'{}",
        data::list_of(without_stratum),
        without_stratum.size() == 1 ? "has" : "have",
        options_.stratum,
        without_stratum.size() == 1 ? "its" : "their",
        options_.stratum_areas_ha.empty() ? "" : ", which the row of all strata does not include"));
  }
  return strata;
}

StructuralUnits ReportMaker::compute_units() const {
  StructuralUnitOptions options = options_.units;
  options.plot_area_m2 = options_.plot_area_m2;
  const bool has_circles = sample_ != nullptr && !sample_->complete_circles.empty();
  return has_circles ? structural_units_of_sample(inventory_, *sample_, options)
                     : structural_units(inventory_, options);
}

void ReportMaker::add_structure() {
  if (!inventory_.has_coordinates()) {
    report_.notes.emplace_back("no tree positions, therefore no structural units");
    return;
  }
  if (sample_ != nullptr && sample_->complete_circles.empty() && options_.design.chooses_trees()) {
    report_.notes.emplace_back("neighborhoods of this design are unknown: no structural units");
    return;
  }
  report_.units = compute_units();
  for (const std::string& note : report_.units->notes) {
    if (note != outside_note(outside_, options_.units.edge)) {
      report_.notes.push_back(note);
      continue;
    }
    // The number of trees outside was already reported; this note adds how they are used.
    const bool are_neighbors = options_.units.edge != EdgeCorrection::kTorus;
    std::ranges::replace(report_.notes, outside_text(false), outside_text(are_neighbors));
  }
  report_.unit_means = summarize_all(inventory_, *report_.units);
  report_.unit_means_by_species = summarize_by_species(inventory_, *report_.units);
  for (const char* index : {"W", "U", "C"}) {
    if (index[0] == 'C' && report_.units->C.empty()) continue;
    report_.joint.push_back({index, "M", joint_distribution(*report_.units, index, "M")});
  }
}

void ReportMaker::add_species(const std::vector<SampledArea>& areas) {
  SpeciesTableOptions options = options_.species;
  const bool has_windows = areas.front().window.has_value();
  if (options.quadrat_m == 0.0 && inventory_.plot.levels().size() == 1 && has_windows) {
    options.quadrat_m = kQuadratMeters;
  }
  report_.layers = options.layers;
  report_.quadrat_m = options.quadrat_m;
  report_.dominant_trees_per_ha = options.dominant_trees_per_ha;
  report_.species = species_table(inventory_, areas, options);
  if (std::ranges::all_of(areas, &SampledArea::has_area)) return;
  for (SpeciesRow& row : report_.species) {
    row.figures.area_ha = data::kMissing;
    row.basal_area_m2 = data::kMissing;
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
  report_.notes.push_back(fmt::format(
      "the {} {} {} only one plot; a variance needs two plots, so {} no standard error{}",
      is_one ? "stratum" : "strata",
      data::list_of(names),
      is_one ? "has" : "each have",
      is_one ? "it has" : "they have",
      has_total ? "" : ", and neither has the total over all strata"));
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
  report_.notes.push_back(
      fmt::format("some of the thickest trees have no height, and dominant height is the mean of "
                  "the others: {}; to impute heights, use silvafit impute",
                  data::list_of(names)));
}

AreaReport ReportMaker::report_on(SampledArea area) const {
  AreaReport report;
  report.figures =
      stand_figures(inventory_, area.trees, area.area_m2, options_.species.dominant_trees_per_ha);
  if (!area.has_area) report.figures.area_ha = data::kMissing;
  if (area.window) {
    std::vector<Point> points;
    for (const std::size_t tree : area.trees) {
      points.push_back({inventory_.x[tree], inventory_.y[tree]});
    }
    report.clark_evans = clark_evans(points, *area.window);
  }
  report.area = std::move(area);
  return report;
}

void ReportMaker::add_figures(std::vector<SampledArea> areas,
                              const std::vector<std::string>& strata) {
  std::vector<std::size_t> trees;
  double area_m2 = 0.0;
  for (const SampledArea& area : areas) {
    trees.insert(trees.end(), area.trees.begin(), area.trees.end());
    area_m2 += area.area_m2;
  }
  report_.all = stand_figures(inventory_, trees, area_m2, options_.species.dominant_trees_per_ha);
  const bool have_areas = std::ranges::all_of(areas, &SampledArea::has_area);
  if (!have_areas) report_.all.area_ha = data::kMissing;
  if (std::string note = note_on_crown_cover(report_.all); !note.empty()) {
    report_.notes.push_back(std::move(note));
  }
  report_.diameters = diameter_distribution(inventory_, trees, area_m2, options_.diameter_class_cm);
  for (std::size_t i = 0; i < areas.size(); ++i) {
    report_.areas.push_back(report_on(std::move(areas[i])));
    if (!strata.empty()) report_.areas.back().stratum = strata[i];
  }
}

StandReport ReportMaker::run() {
  stratum_sizes_ = options_.stratum_areas_ha;
  for (const TreeQuantity& quantity : inventory_.quantities) {
    report_.quantities.push_back(quantity.name + "_" + quantity.unit);
  }
  std::vector<SampledArea> areas = find_areas();
  if (sample_ == nullptr) note_trees_left_out(areas);
  note_plots_left_out();
  const std::vector<std::string> strata = strata_of(areas);
  if (areas.empty()) {
    throw InputError(
        "no plot has an area; a convex hull needs three trees that are not on one line; give "
        "--window, --circle or --plot-area",
        {.file = inventory_.file});
  }
  add_structure();
  add_species(areas);
  report_.strata = stratum_figures(inventory_, areas, strata, stratum_sizes_, are_weights_);
  note_single_plots();
  add_figures(std::move(areas), strata);
  note_dominant_height();
  return std::move(report_);
}

}  // namespace

StandReport stand_report(const Inventory& inventory, const StandReportOptions& options) {
  const bool has_areas = !options.units.windows.empty() || options.plot_area_m2.has_value();
  if (options.design.chooses_trees() && has_areas) {
    throw UsageError("the sampling design gives the areas; omit --window, --circle and --plot-area",
                     {.column = options.plot_area_m2 ? "--plot-area" : "--window"});
  }
  if (!options.design.is_given() || has_areas) {
    return ReportMaker(inventory, options, nullptr).run();
  }
  const DesignedSample sample = sample_of(inventory, options.design);
  return ReportMaker(with_represented(inventory, sample), options, &sample).run();
}

}  // namespace silvafit::stand
