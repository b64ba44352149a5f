// SPDX-License-Identifier: MIT
#include "trees/inventory_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/stand/plot_table.hpp"
#include "silvafit/stand/similar_plots.hpp"
#include "trees/measurement_time.hpp"

namespace silvafit::stand {
namespace {

std::string_view name_of(TreeStatus status) {
  if (status == TreeStatus::kNotInSample) return "not in the sample";
  return status == TreeStatus::kDead ? "dead" : "cut, fallen or a stump";
}

/// Meters of a unit of a column that is multiplied by a number; 1 for other expressions.
double meters_per_unit(const Source& source) {
  if (!source.expression || source.expression->variables().size() != 1) return 1.0;
  const std::string column = source.expression->variables().front();
  data::Table table(3);
  table.set(column, std::vector<double>{0.0, 1.0, 2.0});
  const std::vector<double> values = data::evaluate(*source.expression, table);
  const bool is_multiple = values[0] == 0.0 && values[1] > 0.0 && values[2] == 2.0 * values[1];
  return is_multiple ? values[1] : 1.0;
}

}  // namespace

InventoryReader::InventoryReader(const data::TableSource& source,
                                 InventoryOptions options,
                                 BatchOf of)
    : options_(std::move(options)),
      of_(of),
      prepared_(of == BatchOf::kTable ? prepared_table(source, options_)
                                      : PreparedTable{.table = source}),
      csv_(prepared_.table, options_.missing),
      file_(csv_.file()) {
  if (of != BatchOf::kTable && makes_columns(options_, csv_.header(), file_)) {
    throw UsageError("columns of visits or of texts are made of the whole table; omit `stream`",
                     {.file = file_, .column = "`stream`"});
  }
  plan_ = plan_columns(csv_.header(), csv_.layout().units, options_, file_);
  for (const std::size_t field : plan_.filled_down) csv_.fill_down(field);
  shared_labels_.resize(plan_.unit_fields.size());
  for (InventoryRow& row : block_) row.units.resize(plan_.unit_fields.size());
  for (const std::size_t field : plan_.unread) unread_.emplace_back(csv_.header()[field]);
  if (!plan_.status_field) unread_.emplace_back(plan_.labels[kSpecies].text);
  if (plan_.status_field) {
    status_ =
        StatusColumn(csv_.header()[*plan_.status_field], options_.status_codes, csv_.header());
  }
}

/// Sets the default labels of columns that the file lacks.
void InventoryReader::complete(InventoryRow& row) const {
  if (!plan_.labels[kPlot].exists()) row.labels[kPlot] = kOnlyPlot;
  if (!plan_.labels[kTree].exists()) row.labels[kTree] = fmt::format("{}", row_count_);
  if (!plan_.labels[kSpecies].exists()) row.labels[kSpecies] = kOnlySpecies;
  if (options_.period.empty()) return;
  row.measured_plot = row.labels[kPlot];
  if (is_missing(row.time) || is_missing(row.measured_plot)) return;
  row.labels[kPlot] = label_at_time(row.measured_plot, row.time);
}

void InventoryReader::exclude(const InventoryRow& row,
                              std::string column,
                              std::string value,
                              std::string reason) {
  result_.excluded.push_back({.line = row.line,
                              .plot = row.labels[kPlot],
                              .tree = row.labels[kTree],
                              .column = std::move(column),
                              .value = std::move(value),
                              .reason = std::move(reason)});
}

bool InventoryReader::is_sum(std::string_view label) const {
  return is_summary_label(label, [this](std::string_view plot) {
    return plot == last_plot_ ||
           result_.inventory.plot.code_of(plot) != data::TextColumn::kMissingCode;
  });
}

bool InventoryReader::exclude_if_unlabeled(const InventoryRow& row) {
  bool excluded = false;
  for (const Label label : {kPlot, kTree}) {
    if (!is_missing(row.labels[label])) continue;
    exclude(row,
            plan_.labels[label].text,
            row.labels[label],
            fmt::format("the {} is missing", known_label(label).meaning));
    excluded = true;
  }
  for (const Label label : {kPlot, kTree, kSpecies}) {
    const std::string& text = row.labels[label];
    if (!(label == kSpecies ? is_summary_label(text, true) : is_sum(text))) continue;
    exclude(
        row, plan_.labels[label].text, row.labels[label], "a row of sums or means is not a tree");
    excluded = true;
  }
  if (!options_.period.empty() && is_missing(row.time)) {
    exclude(row, options_.period, row.time, "the time of measurement is missing");
    excluded = true;
  }
  return excluded;
}

/// A row that is not used shows, too, that its plot was visited and its tree was found.
void InventoryReader::keep_time(const InventoryRow& row) {
  const bool is_known = plan_.time_field && !is_missing(row.time) &&
                        !is_missing(row.labels[kPlot]) && !is_missing(row.labels[kTree]);
  if (!is_known) return;
  skipped_.plot.append(row.labels[kPlot]);
  skipped_.tree.append(row.labels[kTree]);
  skipped_.time.append(row.time);
}

/// Excludes rows of dead or cut trees, unless they are to be used.
bool InventoryReader::set_aside_if_dead(const InventoryRow& row, TreeStatus status) {
  const bool is_used = status == TreeStatus::kAlive || options_.dead == DeadTrees::kInclude ||
                       options_.keeps_measurements ||
                       (status == TreeStatus::kDead && options_.dead == DeadTrees::kNeighbors);
  if (is_used && status != TreeStatus::kNotInSample) return false;
  exclude(row, status_.header(), row.status, fmt::format("the tree is {}", name_of(status)));
  result_.excluded.back().is_problem = false;
  ++result_.excluded_tree_count;
  if (status == TreeStatus::kNotInSample) return true;
  keep_time(row);
  const std::string& plot = row.labels[kPlot];
  if (!is_missing(plot) && (plots_of_dead_.empty() || plots_of_dead_.back() != plot)) {
    plots_of_dead_.push_back(plot);
  }
  return true;
}

/// Merged cells of a spreadsheet are exported as one value with empty fields below it.
void InventoryReader::count_empty_plots(const InventoryRow& row) {
  const bool is_empty = row.labels[kPlot].empty() && row_count_ > 1;
  empty_plots_run_ = is_empty ? empty_plots_run_ + 1 : 0;
  if (is_empty) ++empty_plots_;
  has_run_of_empty_plots_ = has_run_of_empty_plots_ || empty_plots_run_ > 1;
}

void InventoryReader::accept_or_exclude(InventoryRow& row) {
  ++row_count_;
  complete(row);
  count_empty_plots(row);
  const TreeStatus status = plan_.status_field ? status_.read(row.status) : TreeStatus::kAlive;
  if (set_aside_if_dead(row, status)) return;
  find_missing_zeros(row.measures);
  bool is_cw_from_radii = false;
  if (std::isnan(row.measures[kCw])) {
    row.measures[kCw] = crown_width_m(row.measures);
    is_cw_from_radii = !std::isnan(row.measures[kCw]);
  }
  // Half or twice is no error of measurement, and no crown that is not round.
  constexpr double kContradiction = 2.0;
  const double ratio = crown_width_m(row.measures) / row.measures[kCw];
  const bool contradicts = ratio > kContradiction || ratio < 1.0 / kContradiction;
  if (contradicts && other_widths_++ == 0) {
    first_other_width_ = fmt::format(
        "line {}: {} m, radii {:.3g} m", row.line, row.measures[kCw], crown_width_m(row.measures));
  }
  bool excluded = exclude_if_unlabeled(row);
  for (ExcludedRow& problem : row.unreadable) {
    exclude(row, std::move(problem.column), std::move(problem.value), std::move(problem.reason));
    excluded = true;
  }
  for (Problem& problem : problems_of(row.measures, options_.needs_coordinates, is_cw_from_radii)) {
    const double value = row.measures[problem.measure];
    const std::string& column = plan_.measures[problem.measure].text;
    // A field that is not a number is reported once, not also as missing.
    if (std::isnan(value) && !row.unreadable.empty()) continue;
    // A dead or cut tree needs no measures, and a living one without dbh has survived.
    if (options_.keeps_measurements && std::isnan(value) && problem.measure == kDbh) continue;
    if (problem.measure == kHcb && value >= row.measures[kH]) ++crown_base_above_top_;
    exclude(row, column, std::isnan(value) ? "" : data::shortest(value), std::move(problem.reason));
    excluded = true;
  }
  if (excluded) {
    ++result_.excluded_tree_count;
    keep_time(row);
    if (row.heading.empty()) return;
    heading_line_ = row.line;
    heading_ = row.heading;
    return;
  }
  if (heading_line_ > 0) {
    throw InputError("the line " + heading_, {.file = file_, .line = heading_line_});
  }
  has_cw_from_radii_ = has_cw_from_radii_ || is_cw_from_radii;
  if (status == TreeStatus::kAlive) {
    const bool has_dbh = !std::isnan(row.measures[kDbh]);
    for (const auto& [column, word] : row.status_words) unread_[column].count(*word, has_dbh);
  }
  append(row, status);
}

void InventoryReader::append(const InventoryRow& row, TreeStatus status) {
  Inventory& inventory = result_.inventory;
  const bool is_dead_neighbor =
      status == TreeStatus::kDead && options_.dead == DeadTrees::kNeighbors;
  if (is_dead_neighbor || std::isnan(row.measures[kDbh])) {
    inventory.neighbor_only.resize(inventory.size(), 0);
    inventory.neighbor_only.push_back(1);
  } else if (!inventory.neighbor_only.empty()) {
    inventory.neighbor_only.push_back(0);
  }
  inventory.lines.push_back(static_cast<std::uint32_t>(row.line));
  inventory.contents.push_back(row.content);
  kept_rows_.push_back(row_count_ - rows_before_ - 1);
  inventory.plot.append(row.labels[kPlot]);
  last_plot_ = row.labels[kPlot];
  inventory.tree.append(row.labels[kTree]);
  if (data::is_missing_number(row.labels[kSpecies])) {
    inventory.species.append_missing();
  } else {
    inventory.species.append(row.labels[kSpecies]);
  }
  if (!options_.period.empty()) {
    inventory.measured_plot.append(row.measured_plot);
    inventory.time.append(row.time);
  } else if (plan_.time_field) {
    is_missing(row.time) ? times_.append_missing() : times_.append(row.time);
  }
  if (!plan_.stem_fields.empty()) {
    row.stem.empty() ? inventory.stem.append_missing() : inventory.stem.append(row.stem);
  }
  if (!row.location.empty()) plots_of_locations_.add(row.location, row.labels[kPlot]);
  if (plan_.genus_field && !is_missing(row.genus) && !is_missing(row.labels[kSpecies])) {
    genera_of_species_.add(row.labels[kSpecies], row.genus);
  }
  if (!is_missing(row.factor)) factors_of_plots_.add(row.labels[kPlot], row.factor);
  if (options_.keeps_measurements && plan_.status_field) inventory.status.push_back(status);
  for (std::size_t i = 0; i < row.units.size(); ++i) {
    if (!is_missing(row.units[i])) shared_labels_[i].add(row.labels[kPlot], row.units[i]);
  }
  const bool has_radii = std::ranges::all_of(
      kRadii, [this](Measure radius) { return plan_.measures[radius].exists(); });
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const bool is_kept = plan_.measures[i].exists() || (i == kCw && has_radii);
    if (is_kept) values_of(inventory, i).push_back(row.measures[i]);
  }
}

/// Counts of the kept trees.
void InventoryReader::count_findings() {
  const Inventory& inventory = result_.inventory;
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    if (inventory.species.is_missing(i)) ++without_species_;
    const bool is_alive = inventory.status.empty() || inventory.status[i] == TreeStatus::kAlive;
    if (is_alive && std::isnan(inventory.dbh_cm[i])) ++without_dbh_;
  }
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const auto place_of = [&inventory](std::size_t row) { return inventory.place(row); };
    odd_values_.add(known_measure(i).name, values_of(inventory, i), place_of);
  }
  if (!plan_.status_field) unread_.back().add(inventory.species);
}

void InventoryReader::find_plots_left_out() {
  Inventory& inventory = result_.inventory;
  std::unordered_set<std::string_view> seen;
  for (const ExcludedRow& row : result_.excluded) {
    const bool is_unknown = row.is_problem && !is_missing(row.plot) && !is_sum(row.plot);
    if (!is_unknown || !seen.insert(row.plot).second) continue;
    if (inventory.plot.code_of(row.plot) != data::TextColumn::kMissingCode) continue;
    inventory.plots_left_out.push_back(row.plot);
  }
  // A part without a tree is not reported; the next one has its plots.
  if (inventory.size() == 0) return;
  for (std::string& plot : plots_of_dead_) {
    const bool has_trees = inventory.plot.code_of(plot) != data::TextColumn::kMissingCode;
    if (!has_trees && seen.insert(plot).second) inventory.plots_without_trees.push_back(plot);
  }
  plots_of_dead_.clear();
}

void InventoryReader::find_plot_lines() {
  Inventory& inventory = result_.inventory;
  std::vector<std::uint32_t> lines(inventory.plot.levels().size(),
                                   std::numeric_limits<std::uint32_t>::max());
  const auto add = [&lines](std::size_t plot, std::uint32_t line) {
    lines[plot] = std::min(lines[plot], line);
  };
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    add(inventory.plot.code(row), inventory.lines[row]);
  }
  for (const ExcludedRow& row : result_.excluded) {
    const std::uint32_t code = inventory.plot.code_of(row.plot);
    if (code != data::TextColumn::kMissingCode) add(code, static_cast<std::uint32_t>(row.line));
  }
  if (!std::ranges::is_sorted(lines)) inventory.plot_lines = std::move(lines);
}

/// Notes on a whole table, and the names of its columns.
void InventoryReader::describe_table() {
  Inventory& inventory = result_.inventory;
  result_.notes = notes();
  refuse_overlaid_maps();
  find_divided_plots();
  std::string similar_plots = describe_similar_labels(inventory.plot);
  if (!similar_plots.empty()) result_.notes.push_back(std::move(similar_plots));
  result_.recognized = recognized();
  inventory.is_placed_by_subplots = plan_.is_placed_by_subplots;
  inventory.area_column = plot_area_column(csv_.header());
  for (std::size_t label = 0; label < kLabelCount; ++label) {
    const Source& source = plan_.labels[label];
    if (!source.field) continue;
    inventory.label_columns.emplace(known_label(label).name, csv_.header()[*source.field]);
  }
  if (plan_.time_field) inventory.label_columns.emplace("time", csv_.header()[*plan_.time_field]);
  // A status of `visits` is of several columns.
  if (options_.keeps_measurements && plan_.status_field) {
    const std::string& status = csv_.header()[*plan_.status_field];
    if (mapping_to(status, options_.visits) == nullptr) {
      inventory.label_columns.emplace("status", status);
    }
  }
}

CheckedInventory InventoryReader::read() {
  result_ = {};
  Inventory& inventory = result_.inventory;
  inventory.file = file_;
  inventory.expansion = plan_.expansion;
  if (plan_.factor_field) inventory.factors.column = csv_.header()[*plan_.factor_field];
  inventory.trusts_units = options_.trust_units;
  inventory.position_unit_m = meters_per_unit(plan_.measures[kX]);
  kept_rows_.clear();
  times_ = {};
  skipped_ = {};
  rows_before_ = row_count_;
  while (read_block()) {
    for (std::size_t i = 0; i < block_size_; ++i) status_.learn(block_[i].status);
    for (std::size_t i = 0; i < block_size_; ++i) accept_or_exclude(block_[i]);
  }
  require_clear_marks();
  refuse_unusable_labels(inventory.plot, "plot", plan_.labels[kPlot].text, file_);
  refuse_unusable_labels(inventory.tree, "tree", plan_.labels[kTree].text, file_);
  refuse_unusable_labels(inventory.species, "species", plan_.labels[kSpecies].text, file_);
  status_.require_one_meaning(file_);
  refuse_tally();
  refuse_epithets();
  if (const auto plot = factors_of_plots_.first()) {
    inventory.factors.plot = plot->label;
    inventory.factors.first = plot->first;
    inventory.factors.other = plot->other;
  }
  if (of_ == BatchOf::kPlots) {
    for (SharedPlotLabels& shared : shared_labels_) shared.finish_plots();
  }
  if (of_ != BatchOf::kRows) compare_trees();
  excluded_.add(result_);
  const bool is_whole = of_ == BatchOf::kTable;
  const bool is_first = !has_trees_ && (is_whole || inventory.size() > 0);
  has_trees_ = has_trees_ || inventory.size() > 0;
  if (is_whole && has_trees_) refuse_plots_without_column();
  if (is_first && !options_.trust_units) check_units(inventory, plan_, crown_base_above_top_);
  if (is_whole) {
    require_trees();
    const auto& dbh = inventory.dbh_cm;
    if (!options_.is_part && std::ranges::all_of(dbh, [](double d) { return std::isnan(d); })) {
      refuse_empty(plan_.measures[kDbh].text + " is missing in all rows");
    }
    find_plot_lines();
  }
  find_plots_left_out();
  read_other_columns();
  count_findings();
  if (!is_whole) return std::move(result_);
  describe_table();
  return std::move(result_);
}

}  // namespace silvafit::stand
