// SPDX-License-Identifier: MIT
#include "silvafit/stand/stand_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

#include "figures/report_maker.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"
#include "trees/plot_order.hpp"

namespace silvafit::stand {
namespace {

/// What describes units, without the values of trees.
StructuralUnits header_of(const StructuralUnits& units) {
  StructuralUnits header{.neighbors = units.neighbors,
                         .scope = units.scope,
                         .alpha0_deg = units.alpha0_deg,
                         .edge = units.edge,
                         .buffer_m = units.buffer_m};
  for (const FurtherValues& one : units.further) header.further.push_back({.index = one.index});
  return header;
}

}  // namespace

ReportMaker::ReportMaker(const StandReportOptions& options,
                         const DesignedSample* sample,
                         std::optional<bool> is_only_plot)
    : options_(options),
      sample_(sample),
      is_part_(is_only_plot.has_value()),
      is_only_plot_(is_only_plot.value_or(false)),
      diameters_(options.class_width_cm),
      domains_(options.by, options.class_width_cm) {
  options_.units.is_part = is_part_;
  options_.units.plot_area_m2 = options_.plot_area_m2;
  refuse_two_strata(options_.stratum, options_.design.plots);
  stratum_sizes_ = options_.stratum_areas_ha;
  report_.layers = options_.species.layers;
  report_.dominant_trees_per_ha = options_.species.dominant_trees_per_ha;
  if (!is_part_) return;
  for (const NamedWindow& window : options_.units.windows) {
    if (window.plot && *window.plot != kEveryPlot) windows_without_rows_.insert(*window.plot);
  }
}

/// Strata are in the table of plots, which plots without trees have, too.
std::vector<std::string> ReportMaker::strata_of_table(const std::vector<SampledArea>& areas) {
  DesignStrata strata = strata_of_plots(*options_.design.plots, areas, stratum_sizes_);
  notes_on_strata_ = std::move(strata.notes);
  stratum_sizes_ = std::move(strata.sizes);
  are_weights_ = strata.are_weights;
  options_.strata.unit_of_stratum = std::move(strata.unit_of_stratum);
  return std::move(strata.stratum_of_area);
}

/// Any column of the inventory, standard columns as well.
data::TextColumn ReportMaker::labels_of(const Inventory& inventory,
                                        const std::string& column,
                                        const char* setting) {
  if (inventory.other.has(column)) return inventory.other.labels(column);
  const data::Table table = to_table(inventory);
  if (table.has(column)) return table.labels(column);
  throw InputError(data::no_such_column(column, table.names()),
                   {.file = inventory.file, .column = setting});
}

void ReportMaker::check_one_stratum(const Inventory& inventory,
                                    const SampledArea& area,
                                    const data::TextColumn& column) const {
  const std::size_t first = area.trees.front();
  const auto name_of = [&column](std::size_t row) {
    return column.is_missing(row) ? "none" : fmt::format("'{}'", column[row]);
  };
  for (const std::size_t tree : area.trees) {
    if (column.code(tree) == column.code(first)) continue;
    Place place = inventory.place(tree);
    place.column = options_.stratum;
    throw InputError(
        fmt::format("the plot belongs to two strata, {} and {}", name_of(first), name_of(tree)),
        place);
  }
}

/// A plot without a tree is in the sample of its stratum, which rows of trees do not tell.
void ReportMaker::require_trees_of_strata(const std::vector<SampledArea>& areas,
                                          const std::string& file) const {
  const auto empty =
      std::ranges::find_if(areas, [](const SampledArea& area) { return area.trees.empty(); });
  if (options_.stratum.empty() || empty == areas.end()) return;
  throw InputError(
      fmt::format("the plot has no living tree that tells its stratum by the column {}; give the "
                  "strata of all plots in a table of `plots` with the columns plot and stratum",
                  options_.stratum),
      {.file = file, .column = "`stratum`", .plot = empty->name});
}

/// The stratum of each area.
std::vector<std::string> ReportMaker::strata_of(const Inventory& inventory,
                                                const std::vector<SampledArea>& areas) {
  std::vector<std::string> strata;
  if (options_.stratum.empty()) {
    const bool has_table = options_.design.plots && options_.design.plots->has_stratum;
    return has_table ? strata_of_table(areas) : strata;
  }
  const data::TextColumn column = labels_of(inventory, options_.stratum, "`stratum`");
  require_trees_of_strata(areas, inventory.file);
  std::vector<std::string> without_stratum;
  for (const SampledArea& area : areas) {
    check_one_stratum(inventory, area, column);
    const std::size_t first = area.trees.front();
    strata.emplace_back(column.is_missing(first) ? std::string_view() : column[first]);
    if (strata.back().empty()) without_stratum.push_back(area.name);
  }
  without_stratum_count_ += without_stratum.size();
  without_stratum_.add(without_stratum);
  return strata;
}

bool ReportMaker::has_structure(const Inventory& inventory) const {
  const bool is_unknown =
      sample_ != nullptr && sample_->complete_circles.empty() && options_.design.chooses_trees();
  return inventory.has_coordinates() && !is_unknown && !options_.without_units;
}

void ReportMaker::add_structure(const Inventory& inventory) {
  if (options_.without_units) return;
  if (!inventory.has_coordinates()) {
    notes_on_units_ = {"no tree positions, therefore no structural units"};
  } else if (!has_structure(inventory)) {
    notes_on_units_ = {"neighborhoods of this design are unknown: no structural units"};
  }
  if (!has_structure(inventory)) return;
  const bool has_circles = sample_ != nullptr && !sample_->complete_circles.empty();
  StructuralUnits units = has_circles
                              ? structural_units_of_sample(inventory, *sample_, options_.units)
                              : structural_units(inventory, options_.units);
  if (joint_.empty()) {
    for (const char* index : {"W", "U", "C"}) {
      if (index[0] != 'C' || !units.C.empty()) joint_.emplace_back(index, "M");
    }
  }
  unit_sums_.add(inventory, units);
  const std::vector<std::size_t> rows = rows_in_plot_order(inventory);
  for (JointSums& joint : joint_) joint.add(units, rows);
  findings_.add(units.findings);
  notes_on_units_ = units.notes;
  report_.units = std::move(units);
}

void ReportMaker::add_species(const Inventory& inventory, const std::vector<SampledArea>& areas) {
  if (!species_) {
    SpeciesTableOptions options = options_.species;
    const bool is_only = is_part_ ? is_only_plot_ : inventory.plot.levels().size() == 1;
    if (options.quadrat_m == 0.0) options.quadrat_m = usual_quadrat_m(is_only, areas);
    report_.quadrat_m = options.quadrat_m;
    species_.emplace(options);
  }
  species_->add(inventory, areas);
}

/// Trees whose order by size is needed for dominant heights.
void ReportMaker::add_dominant(const Inventory& inventory, const std::vector<SampledArea>& areas) {
  if (!is_part_) {
    // All areas and trees are known.
    inventory_ = &inventory;
    trees_of_species_.resize(species_->species_count());
  }
  for (const SampledArea& area : areas) {
    for (const std::size_t tree : area.trees) {
      const std::size_t species = species_->number_of(inventory, tree);
      if (!is_part_) {
        trees_.push_back(tree);
        trees_of_species_[species].push_back(tree);
      } else {
        const double h_m = inventory.h_m.empty() ? data::kMissing : inventory.h_m[tree];
        dominant_.add(inventory.dbh_cm[tree], h_m, species);
      }
    }
  }
}

AreaReport ReportMaker::report_on(const Inventory& inventory, SampledArea area) {
  compare_with_hull(inventory, area);
  AreaReport report;
  FigureSums sums = without_trees_sums_;
  sums.add(inventory, area.trees);
  report.figures = sums.figures(area.area_m2);
  set_dominant_height(inventory,
                      area.trees,
                      options_.species.dominant_trees_per_ha * report.figures.area_ha,
                      report.figures);
  if (!area.has_area) report.figures.area_ha = data::kMissing;
  if (area.window) {
    std::vector<Point> points;
    for (const std::size_t tree : area.trees)
      points.push_back({inventory.x[tree], inventory.y[tree]});
    report.clark_evans = clark_evans(points, *area.window);
  }
  if (is_part_) {
    area.trees = std::vector<std::size_t>();  // assigning {} would keep the memory
    area.window.reset();
  }
  report.area = std::move(area);
  return report;
}

void ReportMaker::add_figures(const Inventory& inventory,
                              std::vector<SampledArea> areas,
                              const std::vector<std::string>& strata) {
  if (!options_.by.empty() && inventory.size() > 0) {
    const auto labels = [&](const std::string& name) { return labels_of(inventory, name, "`by`"); };
    domains_.add(inventory, areas, labels, plots_.trees.size());
  }
  plots_.add(inventory, areas);
  stratum_of_area_.insert(stratum_of_area_.end(), strata.begin(), strata.end());
  std::size_t number = 0;
  for (SampledArea& area : areas) {
    all_.add(inventory, area.trees);
    diameters_.add(inventory, area.trees);
    area_m2_ += area.area_m2;
    have_areas_ = have_areas_ && area.has_area;
    report_.areas.push_back(report_on(inventory, std::move(area)));
    if (!strata.empty()) report_.areas.back().stratum = strata[number++];
  }
}

void ReportMaker::refuse_no_areas(const std::string& file) const {
  throw InputError(
      "no plot has an area; a convex hull needs three trees that are not on one line; give "
      "`window`, `circle` or `plot_area`",
      {.file = file});
}

void ReportMaker::take_labels(const Inventory& inventory) {
  if (report_.quantities.empty()) {
    for (const TreeQuantity& quantity : inventory.quantities) {
      report_.quantities.push_back(label_of(quantity));
      without_rows_.quantities.push_back({.name = quantity.name, .unit = quantity.unit});
    }
  }
  expansion_ = inventory.expansion;
  without_trees_sums_.add(inventory, {});
  // Rows at the end of a part may be skipped ones of the next part's first plot.
  for (const std::string& plot : inventory.plot.levels()) windows_without_rows_.erase(plot);
  std::erase_if(plots_left_out_, [&inventory](const std::string& plot) {
    return inventory.plot.code_of(plot) != data::TextColumn::kMissingCode;
  });
  plots_left_out_.insert(
      plots_left_out_.end(), inventory.plots_left_out.begin(), inventory.plots_left_out.end());
  std::ranges::copy_if(
      inventory.plots_without_trees,
      std::back_inserter(plots_without_trees_),
      [this](const std::string& plot) { return !windows_without_rows_.contains(plot); });
}

void ReportMaker::add(const Inventory& inventory) {
  take_labels(inventory);
  if (inventory.size() == 0) return;
  std::vector<SampledArea> areas = find_areas(inventory);
  sort_areas(inventory, areas);
  if (sample_ == nullptr) count_trees_left_out(inventory, areas);
  const std::vector<std::string> strata = strata_of(inventory, areas);
  if (areas.empty() && !is_part_) refuse_no_areas(inventory.file);
  add_structure(inventory);
  if (areas.empty()) return;
  add_species(inventory, areas);
  add_dominant(inventory, areas);
  add_figures(inventory, std::move(areas), strata);
}

void ReportMaker::finish_structure(const std::string& file) {
  if (!report_.units) return;
  if (is_part_) {
    notes_on_units_ = notes_of(findings_, options_.units, file);
    std::vector<std::string> names;
    for (const UnitSummary& summary : unit_sums_.by_species()) names.push_back(summary.species);
    std::erase(names, "");
    check_species_of_angles(options_.units, names, file);
    report_.units = header_of(*report_.units);
  }
  report_.unit_means = unit_sums_.all();
  report_.unit_means_by_species = unit_sums_.by_species();
  for (const JointSums& joint : joint_) {
    report_.joint.push_back({joint.first(), joint.second(), joint.distribution()});
  }
}

void ReportMaker::finish_figures() {
  const double per_ha = options_.species.dominant_trees_per_ha;
  report_.all = all_.figures(area_m2_);
  const double wanted = per_ha * report_.all.area_ha;
  if (is_part_) {
    dominant_.find(wanted);
    dominant_.set_of_all(report_.all);
  } else {
    set_dominant_height(*inventory_, trees_, wanted, report_.all);
  }
  report_.species = species_->rows(area_m2_, [&](std::size_t species, StandFigures& figures) {
    if (is_part_) return dominant_.set_of_species(species, figures);
    set_dominant_height(*inventory_, trees_of_species_[species], wanted, figures);
  });
  report_.diameters = diameters_.classes(area_m2_);
  if (have_areas_) return;
  report_.all.area_ha = data::kMissing;
  for (SpeciesRow& row : report_.species) {
    row.figures.area_ha = data::kMissing;
    row.basal_area_m2 = data::kMissing;
  }
}

StandReport ReportMaker::finish(const std::string& file) {
  if (is_part_) add_plots_without_rows();
  if (report_.areas.empty()) refuse_no_areas(file);
  finish_structure(file);
  finish_figures();
  check_density(file);
  const auto strata_of = [this](const PlotSums& plots) {
    return stratum_figures(plots, stratum_of_area_, stratum_sizes_, are_weights_, options_.strata);
  };
  report_.strata = strata_of(plots_);
  report_.by = options_.by;
  report_.domains =
      domains_.figures(plots_, [&](const PlotSums& plots) { return strata_of(plots).back(); });
  write_notes();
  return std::move(report_);
}

StandReport stand_report(const Inventory& inventory, const StandReportOptions& options) {
  const bool has_areas = !options.units.windows.empty() || options.plot_area_m2.has_value();
  if (options.design.chooses_trees() && has_areas) {
    throw UsageError("the sampling design gives the areas; omit `window`, `circle` and `plot_area`",
                     {.column = options.plot_area_m2 ? "`plot_area`" : "`window`"});
  }
  StandReportOptions own = options;
  if (!has_areas) own.design = design_for(inventory, options.design);
  if (!own.design.is_given() || has_areas) {
    ReportMaker maker(own, nullptr);
    maker.add(inventory);
    return maker.finish(inventory.file);
  }
  const DesignedSample sample = sample_of(inventory, own.design);
  const Inventory weighted = with_represented(inventory, sample);
  ReportMaker maker(own, &sample);
  maker.add(weighted);
  return maker.finish(inventory.file);
}

StandReportParts::StandReportParts(const StandReportOptions& options, bool is_only_plot)
    : maker_(std::make_unique<ReportMaker>(options, nullptr, is_only_plot)) {
  if (options.design.is_given()) {
    throw UsageError("`stream` cannot be combined with a sampling design; omit one of them",
                     {.column = "`stream`"});
  }
  if (options.units.scope == SearchScope::kStand) {
    throw UsageError("`stream` cannot search neighbors across plots; use `per=plot`",
                     {.column = "`stream`"});
  }
}
StandReportParts::~StandReportParts() = default;
StandReportParts::StandReportParts(StandReportParts&&) noexcept = default;
StandReportParts& StandReportParts::operator=(StandReportParts&&) noexcept = default;

const StructuralUnits* StandReportParts::add(const Inventory& part) {
  maker_->add(part);
  return maker_->units();
}

StandReport StandReportParts::finish(const std::string& file) { return maker_->finish(file); }

}  // namespace silvafit::stand
