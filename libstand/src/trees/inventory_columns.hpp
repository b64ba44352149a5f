// SPDX-License-Identifier: MIT
// The meaning of the columns of a file.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/expression.hpp"
#include "silvafit/stand/inventory.hpp"
#include "trees/polar_positions.hpp"

namespace silvafit::stand {

enum Label : std::size_t { kPlot, kTree, kSpecies, kLabelCount };

enum Measure : std::size_t {
  kX,
  kY,
  kZ,
  kDbh,
  kH,
  kHcb,
  kCw,
  kCrE,
  kCrW,
  kCrS,
  kCrN,
  kMeasureCount
};

inline constexpr std::array<Measure, 4> kRadii{kCrE, kCrW, kCrS, kCrN};

/// The standard columns of labels and measures; `tree_columns()` has them in this order.
inline const TreeColumn& known_label(std::size_t label) { return tree_columns()[label]; }
inline const TreeColumn& known_measure(std::size_t measure) {
  return tree_columns()[kLabelCount + measure];
}
Measure measure_named(std::string_view name);

/// The member of the inventory for a measure.
inline std::vector<double>& values_of(Inventory& inventory, std::size_t measure) {
  return inventory.*known_measure(measure).values;
}
inline const std::vector<double>& values_of(const Inventory& inventory, std::size_t measure) {
  return inventory.*known_measure(measure).values;
}

/// The source of a value: a field of the record, or an expression of several.
struct Source {
  std::string text{};                  ///< the spelling of the header or expression
  std::optional<std::size_t> field{};  ///< position in the record
  std::optional<data::Expression> expression{};
  std::vector<std::size_t> joined{};  ///< positions of the fields that make a label

  bool exists() const { return field.has_value() || expression.has_value() || !joined.empty(); }
};

/// A field that an expression reads, as a number or as text.
struct ExpressionField {
  std::string name{};
  std::size_t field = 0;
  bool is_text = false;
  bool is_position = false;  ///< it becomes x, y or z
  PolarColumn polar{};
};

/// The meaning of all columns, determined before the first row is read.
struct ColumnPlan {
  std::array<Source, kLabelCount> labels{};
  std::array<Source, kMeasureCount> measures{};
  std::optional<std::size_t> time_field{};  ///< of the time of measurement
  /// What tells apart rows with one number: the stem, and the subplot in which trees are numbered.
  std::vector<std::size_t> stem_fields{};
  /// Of columns of stands and other units of plots, within which plots may be numbered.
  std::vector<std::size_t> unit_fields{};
  /// Fields that name the place of a plot, in a known table whose plots are visits.
  std::vector<std::size_t> location{};
  std::optional<std::size_t> status_field{};         ///< alive, dead, cut
  std::optional<std::size_t> tally_field{};          ///< that may be the number of trees of a row
  bool tally_counts_trees = false;                   ///< by its name, not stems or anything
  std::optional<std::size_t> factor_field{};         ///< that may be the trees per ha of a row
  std::optional<std::size_t> genus_field{};          ///< beside a column of species
  std::vector<std::size_t> unread{};                 ///< fields that nothing reads, or only keeps
  std::vector<std::size_t> filled_down{};            ///< fields of --fill-down
  std::vector<ExpressionField> expression_fields{};  ///< of all measures' expressions
  std::optional<data::Expression> azimuth{};         ///< if the user computes it
  std::vector<ColumnMapping> others{};               ///< nonstandard columns to keep
  /// Standard columns under other names, and those in other units.
  std::vector<ColumnMapping> usual{};
  std::string expansion{};             ///< Inventory::expansion
  bool is_placed_by_subplots = false;  ///< Inventory::is_placed_by_subplots
};

/// \param units  of each column, from a row below the header; none if there is no such row
/// \throws UsageError, FormulaError or InputError as read_inventory does
ColumnPlan plan_columns(const std::vector<std::string>& header,
                        const std::vector<std::string>& units,
                        const InventoryOptions& options,
                        const std::string& file);

}  // namespace silvafit::stand
