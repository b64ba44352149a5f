// SPDX-License-Identifier: MIT
// Which column of a file holds what.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/expression.hpp"
#include "silvafit/stand/inventory.hpp"

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

/// A name of ours, its meaning in messages, and other usual spellings (lower case).
struct KnownColumn {
  std::string_view name;
  std::string_view meaning;
  std::array<std::string_view, 2> spellings;
};

const KnownColumn& known_label(std::size_t label);
const KnownColumn& known_measure(std::size_t measure);

/// Where the inventory keeps a measure.
std::vector<double>& values_of(Inventory& inventory, std::size_t measure);
const std::vector<double>& values_of(const Inventory& inventory, std::size_t measure);

/// Where a value comes from: a field of the record, or an expression of several.
struct Source {
  std::string text{};                  ///< the header's spelling, or the expression's
  std::optional<std::size_t> field{};  ///< position in the record
  std::optional<data::Expression> expression{};

  bool exists() const { return field.has_value() || expression.has_value(); }
};

/// A field that an expression reads, as a number or as text.
struct ExpressionField {
  std::string name{};
  std::size_t field = 0;
  bool is_text = false;
};

/// Everything about columns that is decided before the first row.
struct ColumnPlan {
  std::array<Source, kLabelCount> labels{};
  std::array<Source, kMeasureCount> measures{};
  std::optional<std::size_t> time_field{};  ///< of the column that says when a row was measured
  /// Of a column of stands, which plots may be numbered within.
  std::optional<std::size_t> stand_field{};
  std::vector<ExpressionField> expression_fields{};  ///< of all measures' expressions
  std::vector<ColumnMapping> others{};               ///< kept beside ours
  std::vector<std::string> notes{};
};

/// \throws UsageError, FormulaError or InputError as read_inventory does
ColumnPlan plan_columns(const std::vector<std::string>& header,
                        const InventoryOptions& options,
                        const std::string& file);

}  // namespace silvafit::stand
