// SPDX-License-Identifier: MIT
#include "silvafit/stand/repeated_trees.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "silvafit/data/csv.hpp"
#include "trees/plot_visits.hpp"

namespace silvafit::stand {
namespace {

struct StemPosition {
  double x = 0.0;
  double y = 0.0;
};

using Cell = std::pair<double, double>;

Cell cell_of(StemPosition point) {
  return {std::floor(point.x / kResurveyMeters), std::floor(point.y / kResurveyMeters)};
}

/// What distinguishes stems at one position: their stem number, species and dbh or, without a
/// position, all columns.
using StemKey = std::tuple<std::uint64_t, std::uint32_t, double>;

/// The stems of one id at one position: the first row, and the first row of each stem.
struct Stems {
  std::size_t first_row = 0;
  std::map<StemKey, std::size_t> row_of_stem{};
};

/// Compares rows of one id, one after another.
class SameId {
 public:
  SameId(const Inventory& inventory, const data::TextColumn& times)
      : inventory_(inventory), times_(times) {}

  /// \param rows  all of the id
  void begin(std::span<const std::size_t> rows);
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
  bool is_number_of_tree(std::span<const std::size_t> rows) const;
  StemKey key_of(std::size_t row) const;
  std::optional<std::size_t> row_of_other_time(std::size_t row) const;

  const Inventory& inventory_;
  const data::TextColumn& times_;
  bool is_number_ = false;
  std::size_t first_row_ = kNoRow;
  Stems unplaced_{};
  std::map<std::pair<double, double>, Stems> places_{};
  std::map<Cell, std::vector<std::size_t>> first_rows_near_{};

  static constexpr std::size_t kNoRow = std::numeric_limits<std::size_t>::max();
};

/// 0 and words such as `untagged` are the number of no tree. Rows that are copied with their whole
/// file stand equally often in it; those of many trees without numbers do not.
bool SameId::is_number_of_tree(std::span<const std::size_t> rows) const {
  constexpr std::size_t kWord = 3;
  constexpr std::size_t kMany = 3;
  const std::string_view label = inventory_.tree[rows.front()];
  double number = 1.0;
  if (data::parse_number(label, number) && number == 0.0) return false;
  const bool has_digit = label.find_first_of("0123456789") != std::string_view::npos;
  if (!has_digit && label.size() >= kWord) return false;
  std::map<std::uint32_t, std::map<std::uint64_t, std::size_t>> counts;  // by time
  for (const std::size_t row : rows) {
    ++counts[is_time_known(row) ? times_.code(row) : data::TextColumn::kMissingCode]
            [inventory_.contents[row]];
  }
  return std::ranges::all_of(counts, [](const auto& of_time) {
    return of_time.second.size() < kMany ||
           std::ranges::all_of(of_time.second, [&](const auto& of_content) {
             return of_content.second == of_time.second.begin()->second;
           });
  });
}

void SameId::begin(std::span<const std::size_t> rows) {
  is_number_ = is_number_of_tree(rows);
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

StemKey SameId::key_of(std::size_t row) const {
  if (!position_of(row)) return {inventory_.contents[row], 0, 0.0};
  // Missing values are equal, and NaN cannot be ordered.
  const double dbh = inventory_.dbh_cm[row];
  return {inventory_.stem.size() > 0 ? inventory_.stem.code(row) : 0,
          inventory_.species.size() > 0 ? inventory_.species.code(row) : 0,
          std::isnan(dbh) ? -std::numeric_limits<double>::infinity() : dbh};
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
  const StemKey key = key_of(row);
  const auto same = stems->row_of_stem.find(key);
  if (same != stems->row_of_stem.end() && (position || is_number_)) {
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
  stems->row_of_stem.emplace(key, row);
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
  for (auto begin = order.begin(); begin != order.end();) {
    const auto is_other = [&](std::size_t row) { return id(row) != id(*begin); };
    const std::span<const std::size_t> rows(begin, std::find_if(begin, order.end(), is_other));
    begin += std::ssize(rows);
    if (rows.size() == 1) continue;
    same_id.begin(rows);
    bool is_shared = false;
    std::vector<std::size_t> of_one_time;
    for (const std::size_t row : rows) {
      RepeatedTree tree = same_id.add(row);
      if (!tree.is_same_tree) of_one_time.push_back(row);
      if (row == rows.front()) continue;
      const bool has_time = times.size() != 0 && !times.is_missing(row);
      is_shared = is_shared ||
                  (has_time ? !tree.is_same_tree : tree.is_of_unknown_time || tree.is_same_place);
      repeated.push_back(std::move(tree));
    }
    if (is_shared) result.shared_numbers.push_back(std::move(of_one_time));
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

}  // namespace silvafit::stand
