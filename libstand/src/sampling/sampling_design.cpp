// SPDX-License-Identifier: MIT
#include "silvafit/stand/sampling_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include "sampling/plot_areas.hpp"
#include "sampling/sample_maker.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/table.hpp"
#include "trees/folded_text.hpp"
#include "trees/usual_names.hpp"
#include "units/density_indices.hpp"

namespace silvafit::stand {
namespace {

constexpr double kRadiansOfDegree = std::numbers::pi / 180.0;

/// The distance up to which an angle count counts a tree [m].
double limiting_distance_m(double dbh_cm, double basal_area_factor) {
  return dbh_cm / (2.0 * std::sqrt(basal_area_factor));
}

/// Labels `plot/subplot`.
data::TextColumn labels_of_subplots(const Inventory& inventory, const std::string& column) {
  const data::Table& other = inventory.other;
  if (!other.has(column)) {
    throw InputError(data::no_such_column(column, other.names()),
                     {.file = inventory.file, .column = "`subplot`"});
  }
  const data::TextColumn subplots = other.labels(column);
  data::TextColumn labels;
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    labels.append(fmt::format("{}/{}", inventory.plot[tree], subplots[tree]));
  }
  return labels;
}

}  // namespace

void SampleMaker::join() {
  const std::vector<std::string>& names = inventory_.plot.levels();
  records_.assign(names.size(), nullptr);
  if (!design_.plots) return;
  std::set<std::string> seen;
  for (const PlotRecord& record : design_.plots->plots) {
    const std::uint32_t code = inventory_.plot.code_of(record.plot);
    if (code != data::TextColumn::kMissingCode) records_[code] = &record;
    if (seen.insert(record.plot).second) continue;
    throw InputError(
        "the plot is listed twice; the table of plots needs one row for each plot (of a database, "
        "`plots_sql` selects them)",
        {.file = design_.plots->file, .line = record.line, .column = "plot", .plot = record.plot});
  }
  note_unmatched();
  if (uses_table_areas()) refuse_unused_factors(inventory_);
}

bool SampleMaker::uses_table_areas() const { return !design_.chooses_trees(); }

/// A column of factors, in the table of other columns.
void SampleMaker::find_expansions() {
  if (design_.expansion.empty()) return;
  const data::Table& other = inventory_.other;
  if (!other.has(design_.expansion)) {
    throw InputError(data::no_such_column(design_.expansion, other.names()),
                     {.file = inventory_.file, .column = "`expansion`"});
  }
  if (has_word("baf basalareafactor zahlfaktor zf", folded_letters(design_.expansion))) {
    throw UsageError("a basal area factor is no number of trees; use `angle_count` with its value",
                     {.column = "`expansion`"});
  }
  std::vector<data::TextCell> texts;
  expansions_ = data::numbers_of(
      other,
      data::column_reference("expansion", design_.expansion, other.names(), inventory_.file),
      texts);
  if (is_per_acre(design_.expansion)) {
    for (double& factor : expansions_) factor *= kPerAcre;
    sample_.notes.push_back(
        fmt::format("{} has trees per acre and is converted", design_.expansion));
  }
  for (std::size_t tree = 0; tree < inventory_.size(); ++tree) {
    if (inventory_.is_neighbor_only(tree)) continue;
    if (expansions_[tree] >= 0.0 && std::isfinite(expansions_[tree])) continue;
    if (std::isnan(expansions_[tree]) && design_.expansion == inventory_.expansion) {
      // FIA's trees without a factor belong to no sample.
      ++without_factor_;
      continue;
    }
    Place place = inventory_.place(tree);
    place.column = design_.expansion;
    throw InputError(std::isnan(expansions_[tree])
                         ? std::string("the expansion factor is missing or not a number")
                         : fmt::format("an expansion factor of {} trees per ha must be 0 or more",
                                       expansions_[tree]),
                     place);
  }
  find_plots_without_factors();
}

/// Plots all of whose trees lack the factor are unknown, not empty.
void SampleMaker::find_plots_without_factors() {
  if (without_factor_ == 0) return;
  has_factor_.assign(records_.size(), 0);
  for (std::size_t tree = 0; tree < inventory_.size(); ++tree) {
    if (!std::isnan(expansions_[tree])) has_factor_[inventory_.plot.code(tree)] = 1;
  }
  std::vector<std::string> unknown;
  for (std::size_t code = 0; code < has_factor_.size(); ++code) {
    if (has_factor_[code] == 0) unknown.push_back(inventory_.plot.levels()[code]);
  }
  if (unknown.empty()) return;
  if (unknown.size() == has_factor_.size()) {
    throw InputError("no tree has an expansion factor",
                     {.file = inventory_.file, .column = design_.expansion});
  }
  sample_.notes.push_back(
      fmt::format("{} unknown and not counted, because no tree has a factor: {}",
                  counted(unknown.size(), "plot is", "plots are"),
                  data::list_of(unknown)));
}

void SampleMaker::find_smallest_dbh() {
  smallest_dbh_cm_ = design_.smallest_dbh_cm;
  if (!design_.circles.empty()) smallest_dbh_cm_ = design_.circles.front().from_dbh_cm;
  if (smallest_dbh_cm_ > 0.0 || !(design_.basal_area_factor > 0.0)) return;
  smallest_dbh_cm_ = std::numeric_limits<double>::infinity();
  for (std::size_t tree = 0; tree < inventory_.size(); ++tree) {
    if (!inventory_.is_neighbor_only(tree))
      smallest_dbh_cm_ = std::min(smallest_dbh_cm_, inventory_.dbh_cm[tree]);
  }
}

/// The circle in which a tree is counted.
std::optional<std::size_t> SampleMaker::circle_of(double dbh_cm) const {
  std::optional<std::size_t> circle;
  for (std::size_t i = 0; i < design_.circles.size(); ++i) {
    if (dbh_cm >= design_.circles[i].from_dbh_cm) circle = i;
  }
  return circle;
}

/// The largest distance from the center at which a tree is counted; NaN if the design has none.
double SampleMaker::reach_m(std::size_t tree) const {
  const double dbh_cm = inventory_.dbh_cm[tree];
  if (design_.basal_area_factor > 0.0) {
    return limiting_distance_m(dbh_cm, design_.basal_area_factor);
  }
  if (!design_.circles.empty()) {
    const auto circle = circle_of(dbh_cm);
    return circle ? design_.circles[*circle].radius_m : data::kMissing;
  }
  const PlotRecord* const record = record_of(tree);
  return record == nullptr || !design_.expansion.empty() ? data::kMissing : record->radius_m;
}

/// How far from the center a tree may have been mapped: of concentric circles also small trees of
/// the largest one, which are not counted.
double SampleMaker::mapped_m(std::size_t tree) const {
  const double reach = reach_m(tree);
  return design_.circles.empty() || std::isnan(reach) ? reach : design_.circles.back().radius_m;
}

double SampleMaker::slope_cosine(const PlotRecord* record) const {
  if (!design_.corrects_slope || record == nullptr || std::isnan(record->slope_deg)) return 1.0;
  return std::cos(record->slope_deg * kRadiansOfDegree);
}

/// The area of a whole plot before corrections; NaN if it is not known.
double SampleMaker::plot_area_m2(const PlotRecord* record) const {
  const auto subplots = static_cast<double>(design_.subplots);
  if (!design_.circles.empty()) {
    return subplots * circle_area_m2(design_.circles.back().radius_m);
  }
  if (design_.basal_area_factor > 0.0 || record == nullptr) return data::kMissing;
  return recorded_area_m2(*record, design_.subplots, design_.plots->file);
}

bool SampleMaker::is_counted(std::size_t tree) {
  if (inventory_.is_neighbor_only(tree)) return false;
  if (!expansions_.empty() && std::isnan(expansions_[tree])) return false;
  const double dbh_cm = inventory_.dbh_cm[tree];
  const bool has_limit = !design_.circles.empty() || design_.basal_area_factor > 0.0;
  if (has_limit && dbh_cm < smallest_dbh_cm_) {
    ++below_smallest_;
    return false;
  }
  if (origin_ == Origin::kNone || !is_placed(inventory_, tree)) return true;
  if (std::isnan(reach_m(tree)) || is_within(tree, origin_, reach_m(tree))) return true;
  if (outside_++ == 0) {
    first_outside_ =
        describe(inventory_.place(tree),
                 fmt::format("dbh {} cm is counted up to {:.4g} m", dbh_cm, reach_m(tree)));
  }
  return false;
}

/// The horizontal area of a plot; none if it is needed and not known.
std::optional<SampledArea> SampleMaker::area_of(const std::string& name,
                                                const PlotRecord* record) const {
  double area_m2 = plot_area_m2(record);
  const bool has_area = !std::isnan(area_m2);
  if (!has_area && uses_table_areas()) return std::nullopt;
  area_m2 = has_area ? area_m2 * slope_cosine(record) : kSquareMetersPerHectare;
  const double share = record == nullptr || std::isnan(record->share) ? 1.0 : record->share;
  return SampledArea{
      .name = name, .area_m2 = area_m2 * share, .has_area = has_area, .whole_m2 = area_m2};
}

/// The number of trees per hectare of the whole plot that a tree stands for.
double SampleMaker::per_ha_of_whole_plot(std::size_t tree, const PlotRecord* record) const {
  const auto subplots = static_cast<double>(design_.subplots);
  if (!design_.expansion.empty()) {
    const bool is_scaled = design_.is_expansion_of_part && record != nullptr;
    const double share = is_scaled && !std::isnan(record->share) ? record->share : 1.0;
    return expansions_[tree] * share;
  }
  if (design_.basal_area_factor > 0.0) {
    return design_.basal_area_factor / basal_area_m2(inventory_.dbh_cm[tree]) / subplots;
  }
  return kSquareMetersPerHectare / (subplots * circle_area_m2(reach_m(tree)));
}

void SampleMaker::add_areas() {
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> area_of_plot(records_.size(), kNone);
  sample_.represented.assign(inventory_.size(), 1.0);
  for (std::size_t code = 0; code < records_.size(); ++code) {
    if (!has_factor_.empty() && has_factor_[code] == 0) continue;
    std::optional<SampledArea> area = area_of(inventory_.plot.levels()[code], records_[code]);
    if (!area) continue;
    area_of_plot[code] = sample_.areas.size();
    sample_.areas.push_back(std::move(*area));
  }
  for (std::size_t tree = 0; tree < inventory_.size(); ++tree) {
    const std::size_t code = inventory_.plot.code(tree);
    if (area_of_plot[code] == kNone || !is_counted(tree)) continue;
    const PlotRecord* const record = records_[code];
    SampledArea& area = sample_.areas[area_of_plot[code]];
    if (area.area_m2 == 0.0) {
      if (outside_population_++ == 0) {
        first_outside_population_ = describe(inventory_.place(tree), "the share of its plot is 0");
      }
      continue;
    }
    area.trees.push_back(tree);
    if (uses_table_areas()) continue;
    // Factors of a column usually contain the correction for slope; it is applied only on request.
    sample_.represented[tree] = per_ha_of_whole_plot(tree, record) / slope_cosine(record) *
                                area.whole_m2 / kSquareMetersPerHectare;
  }
  note_unused_areas();
  const std::vector<std::string> unknown = take_unknown_plots(inventory_, false, sample_.areas);
  if (unknown.empty()) return;
  sample_.notes.push_back(
      fmt::format("{} no tree with a dbh and {} treated as unknown and not counted: {}",
                  counted(unknown.size(), "plot has", "plots have"),
                  unknown.size() == 1 ? "is" : "are",
                  data::list_of(unknown)));
}

/// Plots all of whose trees are dead or cut, and those of the table without trees. Those whose rows
/// were all skipped are unknown, not empty.
void SampleMaker::add_empty_plots() {
  for (const std::string& plot : inventory_.plots_without_trees) {
    const auto is_it = [&plot](const PlotRecord& record) { return record.plot == plot; };
    if (design_.plots && std::ranges::any_of(design_.plots->plots, is_it)) continue;
    if (auto area = area_of(plot, nullptr)) sample_.areas.push_back(std::move(*area));
  }
  if (!design_.plots) return;
  for (const PlotRecord& record : design_.plots->plots) {
    if (inventory_.plot.code_of(record.plot) != data::TextColumn::kMissingCode) continue;
    const auto& left_out = inventory_.plots_left_out;
    if (std::ranges::find(left_out, record.plot) != left_out.end()) continue;
    if (auto area = area_of(record.plot, &record)) sample_.areas.push_back(std::move(*area));
  }
}

/// The radius within which all trees with the smallest counted dbh were measured.
double SampleMaker::complete_radius_m(const PlotRecord* record) const {
  double radius_m = record == nullptr ? data::kMissing : record->radius_m;
  if (!design_.circles.empty()) radius_m = design_.circles.front().radius_m;
  if (design_.basal_area_factor > 0.0) {
    radius_m = limiting_distance_m(smallest_dbh_cm_, design_.basal_area_factor);
  }
  // An ellipse on the map, whose shorter half axis is this.
  return radius_m * slope_cosine(record);
}

void SampleMaker::add_complete_circles() {
  if (origin_ == Origin::kNone || !design_.expansion.empty()) return;
  const data::TextColumn& labels =
      sample_.subplot_labels ? *sample_.subplot_labels : inventory_.plot;
  std::vector<char> has_circle(labels.levels().size(), 0);
  for (std::size_t tree = 0; tree < inventory_.size(); ++tree) {
    const std::uint32_t code = labels.code(tree);
    if (has_circle[code] != 0) continue;
    has_circle[code] = 1;
    const PlotRecord* const record = record_of(tree);
    const double radius_m = complete_radius_m(record);
    if (!(radius_m > 0.0) || (record == nullptr && origin_ == Origin::kMap)) continue;
    const Point center = center_of(record, origin_);
    if (std::isnan(center.x) || std::isnan(center.y)) continue;
    sample_.complete_circles.push_back(
        {.plot = labels.levels()[code], .window = Window::circle(center, radius_m)});
  }
  const bool differs = design_.circles.size() > 1 || design_.basal_area_factor > 0.0;
  if (!differs || sample_.complete_circles.empty()) return;
  sample_.notes.push_back(fmt::format(
      "neighborhoods are complete only within {:.4g} m of the center, where trees with dbh {} cm "
      "are counted; trees farther away are neighbors, but not core trees",
      complete_radius_m(nullptr),
      smallest_dbh_cm_));
}

/// A design counts a plot as the area of as many subplots as it is told of.
void SampleMaker::check_subplots() const {
  const bool has_radii = std::ranges::any_of(records_, [](const PlotRecord* record) {
    return record != nullptr && !std::isnan(record->radius_m);
  });
  const bool counts_subplots =
      !design_.circles.empty() || design_.basal_area_factor > 0.0 || has_radii;
  if (!sample_.subplot_labels || !counts_subplots) return;
  std::map<std::uint32_t, std::set<std::uint32_t>> subplots;
  for (std::size_t tree = 0; tree < inventory_.size(); ++tree) {
    subplots[inventory_.plot.code(tree)].insert(sample_.subplot_labels->code(tree));
  }
  for (const auto& [plot, labels] : subplots) {
    if (labels.size() <= design_.subplots) continue;
    throw UsageError(
        fmt::format("plot {} has {} subplots in column {}, but the design has {} in a plot; give "
                    "their number with `subplots={}`",
                    inventory_.plot.levels()[plot],
                    labels.size(),
                    design_.subplot,
                    design_.subplots,
                    labels.size()),
        {.file = inventory_.file, .column = "`subplots`"});
  }
}

void SampleMaker::check_density() const {
  if (inventory_.trusts_units) return;
  const Place place{.file = design_.plots ? design_.plots->file : inventory_.file,
                    .column = "area"};
  double basal_area = 0.0;
  double area_m2 = 0.0;
  for (const SampledArea& area : sample_.areas) {
    area_m2 += area.area_m2;
    double of_stems = 0.0;
    for (const std::size_t tree : area.trees) {
      const double stem = basal_area_m2(inventory_.dbh_cm[tree]);
      if (std::isnan(stem)) continue;
      of_stems += stem;
      basal_area += sample_.represented[tree] * stem;
    }
    if (!uses_table_areas()) continue;
    check_plot_density(
        area.name, static_cast<double>(area.trees.size()), of_stems, area.area_m2, place);
  }
  check_density_is_possible(basal_area / area_m2 * kSquareMetersPerHectare, place);
}

DesignedSample SampleMaker::run() {
  check_design(design_);
  join();
  find_expansions();
  if (!design_.expansion.empty() && design_.expansion == inventory_.expansion) {
    sample_.notes.emplace_back(
        "trees per hectare are those that the design of the inventory gives each tree");
  }
  find_smallest_dbh();
  if (!design_.subplot.empty()) {
    sample_.subplot_labels = labels_of_subplots(inventory_, design_.subplot);
  }
  check_subplots();
  find_origin();
  add_areas();
  add_empty_plots();
  const auto is_counted_area = [](const SampledArea& area) { return area.area_m2 > 0.0; };
  if (std::ranges::none_of(sample_.areas, is_counted_area)) {
    throw InputError(
        "no plot has an area; give area, radius or expansion in the table of plots, or a design "
        "(`circles`, `angle_count`, `expansion`)",
        {.file = design_.plots ? design_.plots->file : inventory_.file});
  }
  check_density();
  add_complete_circles();
  note_counts();
  if (uses_table_areas()) sample_.represented.clear();
  return std::move(sample_);
}

void check_density_is_possible(double basal_area_m2_per_ha, const Place& place) {
  if (!(basal_area_m2_per_ha > kImpossibleBasalArea)) return;
  throw InputError(
      fmt::format(
          "the areas of plots make {:.4g} m2 of basal area per hectare; areas are in m2 "
          "(1 ha is 10000, 1 are 100), radii in m and expansion factors per ha; if they are "
          "right, use `trust_units=true`",
          basal_area_m2_per_ha),
      place);
}

void check_plot_density(
    const std::string& plot, double trees, double basal_area, double area_m2, const Place& place) {
  const bool is_too_large = trees < area_m2 / kSquareMetersPerHectare;
  const bool is_too_small = basal_area > area_m2;
  if (trees == 0.0 || !(is_too_large || is_too_small)) return;
  const std::string stems =
      fmt::format("less than the {:.3g} m2 of basal area of its trees", basal_area);
  throw InputError(
      fmt::format("plot {} has an area of {:.10g} m2 for {}, {}; areas are in m2 (1 ha is 10000), "
                  "radii in m; if they are right, use `trust_units=true`",
                  plot,
                  area_m2,
                  counted(static_cast<std::size_t>(trees), "tree", "trees"),
                  is_too_large ? "less than one per hectare" : stems),
      place);
}

void check_design(const SamplingDesign& design) {
  const int ways = static_cast<int>(!design.circles.empty()) +
                   static_cast<int>(design.basal_area_factor > 0.0) +
                   static_cast<int>(!design.expansion.empty());
  if (ways > 1) {
    throw UsageError("use one of `circles`, `angle_count` and `expansion`",
                     {.column = "`circles`"});
  }
  if (design.is_expansion_of_part && design.expansion.empty()) {
    throw UsageError("`expansion_area` needs `expansion`", {.column = "`expansion_area`"});
  }
  if (design.basal_area_factor < 0.0 || !std::isfinite(design.basal_area_factor)) {
    throw UsageError(
        fmt::format("a basal area factor of {} m2/ha must be above 0", design.basal_area_factor),
        {.column = "`angle_count`"});
  }
  if (design.subplots == 0) {
    throw UsageError("a plot has at least one subplot", {.column = "`subplots`"});
  }
  double dbh_cm = -1.0;
  double radius_m = 0.0;
  for (const CountingCircle& circle : design.circles) {
    const bool is_larger = circle.from_dbh_cm > dbh_cm && circle.radius_m > radius_m;
    if (!is_larger || !std::isfinite(circle.from_dbh_cm) || !std::isfinite(circle.radius_m)) {
      throw UsageError(
          fmt::format("circles must have increasing dbh (0 or more) and radius (above 0); '{}={}' "
                      "does not",
                      circle.from_dbh_cm,
                      circle.radius_m),
          {.column = "`circles`"});
    }
    dbh_cm = circle.from_dbh_cm;
    radius_m = circle.radius_m;
  }
}

SamplingDesign design_for(const Inventory& inventory, SamplingDesign design) {
  const auto has_area = [](const PlotRecord& record) {
    return !std::isnan(record.area_m2) || !std::isnan(record.radius_m) ||
           !std::isnan(record.expansion);
  };
  const bool is_known = design.chooses_trees() ||
                        (design.plots && std::ranges::any_of(design.plots->plots, has_area));
  const bool has_factors = !inventory.expansion.empty() && inventory.other.has(inventory.expansion);
  if (!is_known && has_factors) design.expansion = inventory.expansion;
  return design;
}

DesignedSample sample_of(const Inventory& inventory, const SamplingDesign& design) {
  return SampleMaker(inventory, design).run();
}

}  // namespace silvafit::stand
