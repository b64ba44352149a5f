// SPDX-License-Identifier: MIT
#include "trees/inventory_repeats.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/expression.hpp"
#include "trees/inventory_columns.hpp"
#include "trees/inventory_reader.hpp"
#include "trees/measurement_time.hpp"

namespace silvafit::stand {
namespace {

/// Separates plot and time in a key; it does not occur in files.
constexpr char kSeparator = '\x1f';

void exclude_same_tree(const RepeatedTree& tree,
                       const std::string& tree_column,
                       CheckedInventory& checked) {
  const Inventory& inventory = checked.inventory;
  const std::string reason = tree.later_visit.empty()
                                 ? fmt::format("the same tree is on line {}{}",
                                               inventory.lines[tree.first_row],
                                               tree.is_later ? ", measured at another time" : "")
                                 : fmt::format("the plot was measured again: {}", tree.later_visit);
  ++checked.excluded_tree_count;
  checked.excluded.push_back({.line = inventory.lines[tree.row],
                              .plot = std::string(inventory.plot[tree.row]),
                              .tree = std::string(inventory.tree[tree.row]),
                              .column = tree_column,
                              .value = std::string(inventory.tree[tree.row]),
                              .reason = reason,
                              .is_problem = tree.later_visit.empty()});
}

void keep_rows(const std::vector<std::size_t>& rows,
               Inventory& inventory,
               std::vector<std::size_t>& positions) {
  if (rows.size() == inventory.size()) return;
  const auto select = [&rows](auto& values) {
    if (values.empty()) return;
    for (std::size_t i = 0; i < rows.size(); ++i) values[i] = values[rows[i]];
    values.resize(rows.size());
  };
  const auto select_text = [&rows](data::TextColumn& column) {
    data::TextColumn kept;
    kept.reserve(rows.size());
    for (const std::size_t row : rows) {
      column.is_missing(row) ? kept.append_missing() : kept.append(column[row]);
    }
    column = std::move(kept);
  };
  for (std::size_t i = 0; i < kMeasureCount; ++i) select(values_of(inventory, i));
  select(inventory.lines);
  select(inventory.contents);
  select(inventory.neighbor_only);
  select(inventory.status);
  select(positions);
  select_text(inventory.plot);
  select_text(inventory.tree);
  select_text(inventory.species);
  for (data::TextColumn* const column :
       {&inventory.stem, &inventory.time, &inventory.measured_plot}) {
    if (column->size() > 0) select_text(*column);
  }
}

/// Whether the rows of one number and species have nearly the same dbh, as those of one tree at
/// several times. The dbh of different trees of one number are independent: their correlation is
/// above the limit in one of a thousand tables with the fewest pairs. Two trees with one number may
/// be of two species; most rows must have another one of their species nevertheless.
bool are_alike(const Inventory& inventory, const std::vector<std::vector<std::size_t>>& numbers) {
  constexpr std::size_t kFewest = 8;
  constexpr double kCorrelated = 0.9;
  std::vector<double> earlier;
  std::vector<double> later;
  std::size_t alone = 0;
  std::size_t together = 0;
  for (const std::vector<std::size_t>& rows : numbers) {
    std::map<std::uint32_t, std::vector<double>> dbh_of_species;
    for (const std::size_t row : rows) {
      const double dbh = inventory.dbh_cm[row];
      if (std::isfinite(dbh)) dbh_of_species[inventory.species.code(row)].push_back(std::log(dbh));
    }
    for (const auto& [species, dbh] : dbh_of_species) {
      ++(dbh.size() > 1 ? together : alone);
      earlier.insert(earlier.end(), dbh.begin(), dbh.end() - 1);
      later.insert(later.end(), dbh.begin() + 1, dbh.end());
    }
  }
  if (alone >= together) return false;
  if (earlier.size() < kFewest) return false;
  const auto n = static_cast<Eigen::Index>(earlier.size());
  Eigen::ArrayXd x = Eigen::Map<const Eigen::ArrayXd>(earlier.data(), n);
  Eigen::ArrayXd y = Eigen::Map<const Eigen::ArrayXd>(later.data(), n);
  x -= x.mean();
  y -= y.mean();
  return (x * y).sum() > kCorrelated * x.matrix().norm() * y.matrix().norm();
}

}  // namespace

void resolve_repeated_trees(const std::string& tree_column,
                            const data::TextColumn& times,
                            const TimedTrees& skipped,
                            bool thickest_first,
                            CheckedInventory& checked,
                            std::vector<std::size_t>& positions,
                            RepeatedNumbers& numbers) {
  Inventory& inventory = checked.inventory;
  const auto [repeated, visits, shared] = repeated_trees(inventory, times, skipped, thickest_first);
  numbers.visits.add(visits);
  numbers.shared.clear();
  const bool are_most = 2 * shared.size() > inventory.size() - repeated.size();
  numbers.are_alike = are_most && are_alike(inventory, shared);
  for (const std::vector<std::size_t>& rows : shared) {
    std::map<std::uint32_t, LabelParts> trees;
    for (const std::size_t row : rows) {
      trees[numbers.are_alike ? inventory.species.code(row) : 0].rows.push_back({positions[row]});
    }
    for (auto& [species, tree] : trees) {
      if (tree.rows.size() > 1) numbers.shared.push_back(std::move(tree));
    }
  }
  if (repeated.empty()) return;
  std::vector<std::size_t> kept;
  data::TextColumn ids;
  auto next = repeated.begin();
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    const bool is_repeated = next != repeated.end() && next->row == row;
    if (is_repeated && next->is_same_tree) {
      if (next->is_later) ++numbers.again;
      exclude_same_tree(*next++, tree_column, checked);
      continue;
    }
    kept.push_back(row);
    ids.append(is_repeated ? std::string_view(next->new_id) : inventory.tree[row]);
    if (!is_repeated) continue;
    if (next->is_same_place) ++numbers.stems;
    if (next->is_of_unknown_time) ++numbers.unplaced;
    if (numbers.renamed++ == 0) {
      numbers.first_renamed = describe(inventory.place(row), "now " + next->new_id);
    }
    ++next;
  }
  keep_rows(kept, inventory, positions);
  inventory.tree = std::move(ids);
  std::ranges::stable_sort(checked.excluded, {}, &ExcludedRow::line);
}

std::vector<std::string> RepeatedNumbers::notes() const {
  std::vector<std::string> notes = visits.notes();
  if (again > 0) {
    notes.push_back(fmt::format("{} trees again within a visit and {} skipped",
                                counted(again, "row measures", "rows measure"),
                                again == 1 ? "is" : "are"));
  }
  if (renamed > 0) {
    notes.push_back(fmt::format(
        "{} the number of another tree of the same plot and got a new one, the first: {}",
        counted(renamed, "tree has", "trees have"),
        first_renamed));
  }
  if (further_stems > 0) {
    notes.push_back(
        fmt::format("{} the number of another stem of the tree, or of a tree of another "
                    "subplot, and got one of {} own: {}",
                    counted(further_stems, "row has", "rows have"),
                    further_stems == 1 ? "its" : "their",
                    first_further_stem));
  }
  if (stems > 0) {
    notes.push_back(fmt::format("{} at the position of the other tree, as stems of one stool do{}",
                                counted(stems, "of these stands", "of these stand"),
                                advice));
  }
  if (equal > 0) {
    notes.push_back(
        fmt::format("{} an earlier one in all columns, the position included, and {}: {}",
                    counted(equal, "row equals", "rows equal"),
                    equal == 1 ? "is a tree of its own" : "are trees of their own, the first",
                    first_equal));
  }
  if (unplaced > 0) {
    notes.push_back(fmt::format(
        "{} no position{}", counted(unplaced, "of these has", "of these have"), advice));
  }
  return notes;
}

namespace {

/// The labels of stems by code of the column. Numbers are equal by value.
std::vector<std::string> stem_labels(const data::TextColumn& stems) {
  std::vector<std::string> labels;
  for (const std::string& label : stems.levels()) {
    double number = 0.0;
    labels.push_back(data::parse_number(label, number) ? data::shortest(number) : label);
  }
  return labels;
}

/// The calendar year of each time by code, or a number of its own for another time.
std::vector<double> calendar_years(const data::TextColumn& times) {
  std::vector<double> years;
  for (const std::string& time : times.levels()) {
    const std::optional<double> known = years_of(time);
    years.push_back(known ? std::floor(*known) : -1.0 - static_cast<double>(years.size()));
  }
  return years;
}

}  // namespace

/// Whether a column of stems has several of a tree in one year. Otherwise it is something else,
/// such as a class of quality, or each tree has one stem.
bool InventoryReader::tells_stems_apart(const std::vector<std::string>& labels) const {
  const Inventory& inventory = result_.inventory;
  const std::vector<double> years = calendar_years(times_);
  std::map<std::tuple<std::uint32_t, std::uint32_t, double>, std::string_view> seen;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    if (inventory.stem.is_missing(row)) continue;
    const std::string& label = labels[inventory.stem.code(row)];
    const bool has_time = times_.size() > 0 && !times_.is_missing(row);
    const double year = has_time ? years[times_.code(row)] : 0.0;
    const auto [first, is_new] =
        seen.try_emplace({inventory.plot.code(row), inventory.tree.code(row), year}, label);
    if (!is_new && first->second != label) return true;
  }
  return false;
}

/// Stems of a tree are trees of their own: the labels of all but the least become part of its
/// number, so that a stem is the same at all times, whatever the order of the rows.
void InventoryReader::number_stems() {
  Inventory& inventory = result_.inventory;
  if (inventory.stem.size() == 0) return;
  const std::vector<std::string> labels = stem_labels(inventory.stem);
  if (!tells_stems_apart(labels)) return;
  const data::TextColumn& plots =
      inventory.measured_plot.size() > 0 ? inventory.measured_plot : inventory.plot;
  const auto tree_of = [&](std::size_t row) {
    return std::pair(plots.code(row), inventory.tree.code(row));
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::string_view> least;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    if (inventory.stem.is_missing(row)) continue;
    const std::string_view label = labels[inventory.stem.code(row)];
    const auto [found, is_new] = least.try_emplace(tree_of(row), label);
    if (!is_new) found->second = std::min(found->second, label);
  }
  data::TextColumn numbers;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    const bool has_label = !inventory.stem.is_missing(row);
    const std::string_view label =
        has_label ? std::string_view(labels[inventory.stem.code(row)]) : std::string_view();
    const bool is_other = has_label && label != least.at(tree_of(row));
    numbers.append(is_other ? fmt::format("{}#{}", inventory.tree[row], label)
                            : std::string(inventory.tree[row]));
    if (!is_other || repeated_numbers_.further_stems++ > 0) continue;
    repeated_numbers_.first_further_stem =
        describe(inventory.place(row), fmt::format("now {}", numbers[row]));
  }
  inventory.tree = std::move(numbers);
}

/// Without numbers of trees, rows at one position that are equal in all columns may be stems of one
/// stool. Copies of a table double it.
void InventoryReader::count_equal_rows() {
  const Inventory& inventory = result_.inventory;
  if (plan_.labels[kTree].exists() || !inventory.has_coordinates()) return;
  std::set<std::pair<std::uint32_t, std::uint64_t>> seen;
  std::size_t equal = 0;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    const bool is_placed = !std::isnan(inventory.x[row]) && !std::isnan(inventory.y[row]);
    if (!is_placed || seen.emplace(inventory.plot.code(row), inventory.contents[row]).second) {
      continue;
    }
    if (repeated_numbers_.equal + equal++ == 0) {
      repeated_numbers_.first_equal = describe(inventory.place(row), "");
    }
  }
  repeated_numbers_.equal += equal;
  // Stems of one stool rarely have the same dbh: a tenth of all trees cannot be such stems.
  constexpr std::size_t kTenth = 10;
  if (kTenth * equal < inventory.size() || equal == 0 || options_.trust_units) return;
  throw InputError(
      fmt::format("{} of {} rows equal an earlier one in all columns, the position included: "
                  "remove the copies; if each is a tree, use `trust_units=true`",
                  equal,
                  inventory.size()),
      {.file = file_});
}

void InventoryReader::compare_trees() {
  count_equal_rows();
  number_stems();
  if (options_.keeps_measurements) result_.inventory.time = times_;
  if (options_.keeps_measurements && times_.size() > 0) {
    compare_measurements();
  } else {
    resolve_repeated_trees(
        plan_.labels[kTree].text, times_, skipped_, false, result_, kept_rows_, repeated_numbers_);
    refuse_unknown_visits();
    explain_shared_numbers();
  }
  result_.inventory.contents.clear();
  if (!options_.case_sensitive) spellings_.unify(result_.inventory.species);
}

/// Says, or asks, what the rows of one number are.
void InventoryReader::explain_shared_numbers() {
  RepeatedNumbers& numbers = repeated_numbers_;
  const bool has_times = !times_.levels().empty();
  if (numbers.shared.empty() || (has_times && !numbers.are_alike)) return;
  std::vector<std::size_t> fields = plan_.unread;
  fields.insert(fields.end(), plan_.unit_fields.begin(), plan_.unit_fields.end());
  auto columns = is_of_table() ? distinguishing_columns(
                                     prepared_.table, options_.missing, fields, numbers.shared)
                               : std::vector<DistinguishingColumn>();
  // Times and parts recur from tree to tree; measurements differ by accident.
  std::size_t rows = 0;
  for (const LabelParts& number : numbers.shared) rows += number.rows.size();
  std::erase_if(columns, [&](const DistinguishingColumn& column) {
    return numbers.shared.size() > 1 && 2 * column.distinct > rows;
  });
  const auto text_of = [](const std::string& name) {
    return data::Expression::variable(name).text();
  };
  const std::string column =
      columns.empty() ? "COLUMN" : text_of(csv_.header()[columns.front().field]);
  const std::string tree =
      plan_.labels[kTree].field ? text_of(plan_.labels[kTree].text) : plan_.labels[kTree].text;
  numbers.advice = fmt::format(
      "; {}if they are later measurements of a tree, name the column of the time: "
      "`columns=year={}`; if trees are numbered within parts of a plot, use "
      "`columns=tree={}+{}`",
      columns.empty() ? "" : fmt::format("the column {} tells them apart: ", column),
      column,
      column,
      tree);
  // Without plots and positions, each plot may have such a number (refuse_plots_without_column).
  const bool is_one_plot = plan_.labels[kPlot].exists() || result_.inventory.has_coordinates();
  if (!numbers.are_alike || !is_one_plot || options_.trust_units) return;
  throw InputError(
      fmt::format("{} several rows with nearly the same dbh, as measurements at several times "
                  "have, but {}{}; if all are trees of one time, use `trust_units=true`",
                  counted(numbers.shared.size(),
                          "tree of one number and species has",
                          "trees of one number and species have"),
                  has_times ? fmt::format("the column {} has one time for them",
                                          csv_.header()[*plan_.time_field])
                  : plan_.time_field
                      ? fmt::format("the column {} is empty", csv_.header()[*plan_.time_field])
                      : std::string("there is no column of the time"),
                  numbers.advice),
      {.file = file_, .column = plan_.labels[kTree].text});
}

/// Over many years, rows of a plot without a tree that comes again are not of one visit.
void InventoryReader::refuse_unknown_visits() const {
  const VisitCounts& visits = repeated_numbers_.visits;
  if (!visits.is_long || !plan_.labels[kPlot].exists()) return;
  throw InputError(
      fmt::format("{} rows of several times, but no tree comes again ({}); if these are several "
                  "visits, choose one with `where` or give trees the same numbers; if the column "
                  "is not the time of measurement, name another one with `columns=year=COLUMN`",
                  counted(visits.mixed, "plot has", "plots have"),
                  visits.first_mixed),
      {.file = file_, .column = csv_.header()[*plan_.time_field]});
}

/// Trees with the same number are compared within each time of measurement, the thickest first, so
/// that those of one stool are the same at all times whatever the order of the rows.
void InventoryReader::compare_measurements() {
  Inventory& inventory = result_.inventory;
  data::TextColumn labels;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    labels.append(fmt::format("{}{}{}", inventory.plot[row], kSeparator, times_[row]));
  }
  inventory.plot = std::move(labels);
  resolve_repeated_trees(
      plan_.labels[kTree].text, {}, {}, true, result_, kept_rows_, repeated_numbers_);
  const auto plot_in = [](std::string_view label) {
    return label.substr(0, label.find(kSeparator));
  };
  data::TextColumn plots;
  for (std::size_t row = 0; row < inventory.size(); ++row)
    plots.append(plot_in(inventory.plot[row]));
  inventory.plot = std::move(plots);
  for (ExcludedRow& row : result_.excluded) row.plot = plot_in(row.plot);
  // The first message has the label, too, in which signs that cannot be printed are escaped.
  constexpr std::string_view kEscaped = "\\x1f";
  std::string& first = repeated_numbers_.first_renamed;
  if (const std::size_t at = first.find(kEscaped); at != std::string::npos) {
    first.replace(at, kEscaped.size(), " ");
    first +=
        "; from one time to the next they are matched in the order of dbh: give each tree a "
        "number of its own, as in `columns=tree=subplot + \"-\" + number`, if that is wrong";
  }
}

/// Plots whose rows stand apart in the file may be several plots of one label.
void InventoryReader::find_divided_plots() {
  const Inventory& inventory = result_.inventory;
  const bool is_chosen = mapping_to("plot", options_.columns) != nullptr;
  if (plan_.time_field || is_chosen || !plan_.labels[kPlot].exists()) return;
  std::vector<LabelParts> plots(inventory.plot.levels().size());
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    LabelParts& plot = plots[inventory.plot.code(row)];
    const bool goes_on = row > 0 && inventory.plot.code(row) == inventory.plot.code(row - 1);
    if (!goes_on) plot.rows.emplace_back();
    plot.rows.back().push_back(kept_rows_[row]);
    plot.label = inventory.plot[row];
  }
  std::erase_if(plots, [](const LabelParts& plot) { return plot.rows.size() < 2; });
  const auto columns =
      distinguishing_columns(prepared_.table, options_.missing, plan_.unread, plots);
  if (columns.empty()) return;
  SharedPlotLabels shared;
  for (std::size_t i = 0; i < plots.size(); ++i) {
    for (const std::string& value : columns.front().values[i]) shared.add(plots[i].label, value);
  }
  result_.notes.push_back(shared.note(csv_.header()[columns.front().field]));
}

}  // namespace silvafit::stand
