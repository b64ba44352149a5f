// SPDX-License-Identifier: MIT
#include "trees/inventory_repeats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/csv.hpp"
#include "trees/inventory_columns.hpp"
#include "trees/inventory_reader.hpp"
#include "trees/measurement_time.hpp"
#include "trees/plot_visits.hpp"

namespace silvafit::stand {
namespace {

/// Separates plot and time in a key; it does not occur in files.
constexpr char kSeparator = '\x1f';

struct StemPosition {
  double x = 0.0;
  double y = 0.0;
};

using Cell = std::pair<double, double>;

Cell cell_of(StemPosition point) {
  return {std::floor(point.x / kResurveyMeters), std::floor(point.y / kResurveyMeters)};
}

/// The stems of one id at one position: the first row, and the first row of each dbh or, if the
/// position is unknown, of each set of measures.
struct Stems {
  std::size_t first_row = 0;
  std::map<std::vector<double>, std::size_t> row_of_measures{};
};

/// Compares rows of one id, one after another.
class SameId {
 public:
  SameId(const Inventory& inventory, const data::TextColumn& times)
      : inventory_(inventory), times_(times) {}

  void begin();
  /// Relation of a row to the earlier ones; the first row is classified as another tree, too.
  RepeatedTree add(std::size_t row);

 private:
  bool is_time_known(std::size_t row) const {
    return times_.size() != 0 && !times_.is_missing(row);
  }
  bool is_other_time(std::size_t left, std::size_t right) const {
    return is_time_known(left) && is_time_known(right) && times_.code(left) != times_.code(right);
  }
  std::optional<StemPosition> position_of(std::size_t row) const;
  std::vector<double> measures_of(std::size_t row) const;
  std::optional<std::size_t> row_of_other_time(std::size_t row) const;

  const Inventory& inventory_;
  const data::TextColumn& times_;
  std::size_t first_row_ = kNoRow;
  Stems unplaced_{};
  std::map<std::pair<double, double>, Stems> places_{};
  std::map<Cell, std::vector<std::size_t>> first_rows_near_{};

  static constexpr std::size_t kNoRow = std::numeric_limits<std::size_t>::max();
};

void SameId::begin() {
  first_row_ = kNoRow;
  unplaced_ = {.first_row = kNoRow};
  places_.clear();
  first_rows_near_.clear();
}

std::optional<StemPosition> SameId::position_of(std::size_t row) const {
  if (!inventory_.has_coordinates()) return std::nullopt;
  const StemPosition point{inventory_.x[row], inventory_.y[row]};
  if (std::isnan(point.x) || std::isnan(point.y)) return std::nullopt;
  return point;
}

/// What distinguishes stems at one position: their number and dbh or, without a position, all
/// measures.
std::vector<double> SameId::measures_of(std::size_t row) const {
  // Missing values are equal, and NaN cannot be ordered.
  const auto comparable = [row](const std::vector<double>& values) {
    const bool is_missing = values.empty() || std::isnan(values[row]);
    return is_missing ? -std::numeric_limits<double>::infinity() : values[row];
  };
  std::vector<double> measures;
  if (inventory_.stem.size() > 0) measures.push_back(inventory_.stem.code(row));
  if (position_of(row)) {
    measures.push_back(comparable(inventory_.dbh_cm));
    return measures;
  }
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    measures.push_back(comparable(values_of(inventory_, i)));
  }
  return measures;
}

/// The nearest tree of another time that may be the same tree: within the error of a survey or, if
/// one of the two has no position, the first one.
std::optional<std::size_t> SameId::row_of_other_time(std::size_t row) const {
  const std::optional<StemPosition> position = position_of(row);
  if (!position || !position_of(first_row_)) {
    return is_other_time(row, first_row_) ? std::optional(first_row_) : std::nullopt;
  }
  std::optional<std::size_t> nearest;
  double nearest_m = kResurveyMeters;
  const Cell center = cell_of(*position);
  for (const double i : {-1.0, 0.0, 1.0}) {
    for (const double j : {-1.0, 0.0, 1.0}) {
      const auto near = first_rows_near_.find({center.first + i, center.second + j});
      if (near == first_rows_near_.end()) continue;
      for (const std::size_t other : near->second) {
        const StemPosition point = *position_of(other);
        const double distance_m = std::hypot(point.x - position->x, point.y - position->y);
        if (distance_m > nearest_m || !is_other_time(row, other)) continue;
        nearest = other;
        nearest_m = distance_m;
      }
    }
  }
  return nearest;
}

RepeatedTree SameId::add(std::size_t row) {
  const std::optional<StemPosition> position = position_of(row);
  Stems* stems = &unplaced_;
  if (position) {
    stems =
        &places_.try_emplace({position->x, position->y}, Stems{.first_row = kNoRow}).first->second;
  }
  const std::vector<double> measures = measures_of(row);
  if (const auto same = stems->row_of_measures.find(measures);
      same != stems->row_of_measures.end()) {
    return {.row = row, .first_row = same->second, .is_same_tree = true};
  }
  if (first_row_ != kNoRow) {
    if (const auto earlier = row_of_other_time(row)) {
      return {.row = row, .first_row = *earlier, .is_same_tree = true, .is_later = true};
    }
  }
  const bool is_new = stems->first_row == kNoRow;
  RepeatedTree tree{.row = row, .first_row = is_new ? row : stems->first_row};
  tree.is_same_place = position && !is_new;
  tree.is_of_unknown_time = !position && !is_new && !is_time_known(row);
  if (is_new) stems->first_row = row;
  if (is_new && position) first_rows_near_[cell_of(*position)].push_back(row);
  if (first_row_ == kNoRow) first_row_ = row;
  stems->row_of_measures.emplace(measures, row);
  return tree;
}

using PlotAndTree = std::pair<std::uint32_t, std::string>;

/// Returns `64#2`, `64#3`, ... and skips ids that the plot already has.
class IdSupply {
 public:
  explicit IdSupply(const Inventory& inventory) {
    for (std::size_t row = 0; row < inventory.size(); ++row) {
      const std::string_view id = inventory.tree[row];
      if (id.find('#') != std::string_view::npos) taken_.emplace(inventory.plot.code(row), id);
    }
  }

  std::string next(std::uint32_t plot, const std::string& id) {
    std::size_t& number = last_number_.try_emplace({plot, id}, 1).first->second;
    for (;;) {
      std::string candidate = fmt::format("{}#{}", id, ++number);
      if (taken_.emplace(plot, candidate).second) return candidate;
    }
  }

 private:
  std::set<PlotAndTree> taken_{};
  std::map<PlotAndTree, std::size_t> last_number_{};
};

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

}  // namespace

RepeatedTrees repeated_trees(const Inventory& inventory,
                             const data::TextColumn& times,
                             const TimedTrees& skipped,
                             bool thickest_first) {
  RepeatedTrees result;
  std::vector<RepeatedTree>& repeated = result.rows;
  const std::vector<std::string> later = later_visits(inventory, times, skipped, result.visits);
  std::vector<std::size_t> order;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    if (later[row].empty()) {
      order.push_back(row);
    } else {
      repeated.push_back({.row = row, .later_visit = later[row], .is_same_tree = true});
    }
  }
  // As many ids as trees: no id repeats, and no sorting is needed.
  if (inventory.tree.levels().size() == inventory.size()) return result;
  const auto id = [&inventory](std::size_t row) {
    return std::pair(inventory.plot.code(row), inventory.tree.code(row));
  };
  std::ranges::stable_sort(order, {}, [&](std::size_t row) {
    const bool is_sized = thickest_first && !std::isnan(inventory.dbh_cm[row]);
    return std::pair(id(row), is_sized ? -inventory.dbh_cm[row] : 0.0);
  });

  SameId same_id(inventory, times);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_first = i == 0 || id(order[i]) != id(order[i - 1]);
    const bool is_last = i + 1 == order.size() || id(order[i]) != id(order[i + 1]);
    if (is_first && is_last) continue;
    if (is_first) same_id.begin();
    RepeatedTree tree = same_id.add(order[i]);
    if (!is_first) repeated.push_back(std::move(tree));
  }
  if (repeated.empty()) return result;
  std::ranges::sort(repeated, {}, &RepeatedTree::row);

  IdSupply ids(inventory);
  for (RepeatedTree& tree : repeated) {
    if (tree.is_same_tree) continue;
    tree.new_id = ids.next(inventory.plot.code(tree.row), std::string(inventory.tree[tree.row]));
  }
  return result;
}

void resolve_repeated_trees(const std::string& tree_column,
                            const data::TextColumn& times,
                            const TimedTrees& skipped,
                            bool thickest_first,
                            CheckedInventory& checked,
                            std::vector<std::size_t>& positions,
                            RepeatedNumbers& numbers) {
  Inventory& inventory = checked.inventory;
  const auto [repeated, visits] = repeated_trees(inventory, times, skipped, thickest_first);
  numbers.visits.add(visits);
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
    notes.push_back(fmt::format(
        "{} at the position of the other tree and differ{} from it in dbh, as stems of one stool "
        "do; if they are later measurements of a tree, name the column of the time: "
        "`columns=year=COLUMN`",
        counted(stems, "of these stands", "of these stand"),
        stems == 1 ? "s" : ""));
  }
  if (unplaced > 0) {
    notes.push_back(fmt::format(
        "{} no position; if they are later measurements of a tree, name the column of the time: "
        "`columns=year=COLUMN`",
        counted(unplaced, "of these has", "of these have")));
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

void InventoryReader::compare_trees() {
  number_stems();
  if (options_.keeps_measurements) result_.inventory.time = times_;
  if (options_.keeps_measurements && times_.size() > 0) {
    compare_measurements();
  } else {
    resolve_repeated_trees(
        plan_.labels[kTree].text, times_, skipped_, false, result_, kept_rows_, repeated_numbers_);
    refuse_unknown_visits();
  }
  if (!options_.case_sensitive) spellings_.unify(result_.inventory.species);
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

void SharedPlotLabels::add(std::string_view plot, std::string_view stand) {
  // Most rows are of the same plot as the one before.
  if (!stand_of_plot_.empty() && plot == last_plot_ && stand == last_stand_) return;
  last_plot_ = plot;
  last_stand_ = stand;
  const auto [known, is_new] = stand_of_plot_.try_emplace(last_plot_, stand);
  if (is_new || known->second == stand) return;
  shared_.try_emplace(last_plot_, Shared{.first = known->second, .other = std::string(stand)});
}

void SharedPlotLabels::finish_plots() {
  stand_of_plot_.clear();
  while (shared_.size() > 1) {
    shared_.erase(std::prev(shared_.end()));
    ++forgotten_;
  }
}

std::optional<SharedPlotLabels::Example> SharedPlotLabels::first() const {
  if (shared_.empty()) return std::nullopt;
  const auto& [label, stands] = *shared_.begin();
  return Example{.label = label, .first = stands.first, .other = stands.other};
}

std::string SharedPlotLabels::note_on_visits() const {
  if (shared_.empty()) return {};
  const auto& [place, plots] = *shared_.begin();
  return fmt::format(
      "{} visited several times ({} has the plots {} and {}), and each visit counts as a plot; "
      "choose one visit of each with `where`",
      counted(forgotten_ + shared_.size(), "place was", "places were"),
      place,
      plots.first,
      plots.other);
}

std::string SharedPlotLabels::note(const std::string& column) const {
  if (shared_.empty()) return {};
  const auto& [plot, stands] = *shared_.begin();
  return fmt::format(
      "{} several values of the column {} ({} occurs with {} and {}), but all trees with one plot "
      "label are treated as one plot; use plot labels that are unique in the file, such as {}-{}",
      counted(forgotten_ + shared_.size(), "plot label occurs with", "plot labels occur with"),
      column,
      plot,
      stands.first,
      stands.other,
      stands.first,
      plot);
}

}  // namespace silvafit::stand
