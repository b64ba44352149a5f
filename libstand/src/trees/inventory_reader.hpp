// SPDX-License-Identifier: MIT
// Reads an inventory, or a part of it, in blocks of rows: fields become numbers, expressions give
// measures, checks exclude rows, and the others are appended to the columns.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/missing_codes.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/data/table_parts.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/odd_values.hpp"
#include "silvafit/stand/prepared_table.hpp"
#include "silvafit/stand/species_spellings.hpp"
#include "silvafit/stand/tree_status.hpp"
#include "silvafit/stand/unread_columns.hpp"
#include "trees/inventory_checks.hpp"
#include "trees/inventory_columns.hpp"
#include "trees/inventory_repeats.hpp"
#include "trees/shared_plot_labels.hpp"

namespace silvafit::stand {

/// Whether a label or text is missing.
inline bool is_missing(std::string_view field) {
  return data::is_missing_field(field) || field == "NaN" || field == "nan";
}

/// A row of the current block.
struct InventoryRow {
  std::size_t line = 0;
  std::uint64_t content = 0;  ///< Inventory::contents
  std::array<std::string, kLabelCount> labels{};
  std::string time{};                ///< as written; empty if there is no such column
  std::vector<std::string> units{};  ///< as time, of ColumnPlan::unit_fields
  std::string stem{};                ///< as time
  std::string location{};            ///< of the visits of a plot, in some known tables
  std::string genus{};               ///< as time
  std::string factor{};              ///< as time
  std::string heading{};             ///< why the row may be a heading of the rows below it
  std::string status{};              ///< as time
  std::string measured_plot{};       ///< with InventoryOptions::period: the plot, without the time
  /// Words of dead or cut trees, with their positions in ColumnPlan::unread.
  std::vector<std::pair<std::size_t, StatusWords::Entry*>> status_words{};
  Measures measures{};
  std::vector<ExcludedRow> unreadable{};  ///< fields that should be numbers but are not
};

/// The labels of trees in tables without a column of plots or species.
inline constexpr char kOnlyPlot[] = "1";
inline constexpr char kOnlySpecies[] = "unknown";

/// Reads a table, or its parts one after another.
class InventoryReader {
 public:
  InventoryReader(const data::TableSource& source, InventoryOptions options, BatchOf of);

  /// The parts of a file, to be opened one after another; none if its trees are one part.
  /// \throws UsageError if other columns or rows are wanted and the file can be read only once
  std::optional<data::TableParts> parts(std::size_t rows);
  void open(const std::shared_ptr<const data::TableText>& part);
  /// The trees of the table or part that is open; those of a table with notes.
  CheckedInventory read();
  /// \throws InputError if no row so far can be used
  void require_trees() const;
  bool has_tree_numbers() const { return plan_.labels[kTree].exists(); }
  bool is_of_table() const { return of_ == BatchOf::kTable; }
  /// Notes on all rows read so far.
  void refuse_plots_without_column() const;
  std::vector<std::string> notes() const;
  /// Those notes that describe how the file was read.
  std::vector<std::string> recognized() const;
  /// Notes on the rows that were skipped so far.
  std::string excluded() const { return excluded_.text(file_); }

 private:
  static constexpr std::size_t kBlockRows = 4096;

  bool read_block();
  void read_row(const std::vector<std::string_view>& fields,
                InventoryRow& row,
                std::size_t position);
  void count_tally(const std::vector<std::string_view>& fields);
  void read_expression_fields(const std::vector<std::string_view>& fields,
                              InventoryRow& row,
                              std::size_t position);
  double number_in(std::size_t position,
                   std::string_view field,
                   const std::string& column,
                   bool is_position,
                   InventoryRow& row);
  void refuse_other_marks(std::string_view text, const std::string& column) const;
  void require_clear_marks() const;
  void require_computed_directions(const data::Table& table) const;
  void find_missing_zeros(Measures& measures);
  void keep_time(const InventoryRow& row);
  bool set_aside_if_dead(const InventoryRow& row, TreeStatus status);
  void count_empty_plots(const InventoryRow& row);
  std::string note_on_dead() const;
  std::string note_on_empty_plots() const;
  void evaluate_expressions();
  void accept_or_exclude(InventoryRow& row);
  void complete(InventoryRow& row) const;
  bool exclude_if_unlabeled(const InventoryRow& row);
  void append(const InventoryRow& row, TreeStatus status);
  bool is_sum(std::string_view label) const;
  void exclude(const InventoryRow& row, std::string column, std::string value, std::string reason);
  std::vector<std::string> sources_of_others() const;
  void read_other_columns();
  void refuse_tally() const;
  void refuse_epithets() const;
  void count_findings();
  bool tells_stems_apart(const std::vector<std::string>& labels) const;
  void number_stems();
  void compare_trees();
  void count_equal_rows();
  void refuse_overlaid_maps() const;
  void compare_measurements();
  void refuse_unknown_visits() const;
  void explain_shared_numbers();
  void find_divided_plots();
  void find_plots_left_out();
  void find_plot_lines();
  void describe_table();
  [[noreturn]] void refuse_empty(const std::string& excluded) const;

  InventoryOptions options_;
  BatchOf of_;
  PreparedTable prepared_;
  data::CsvReader csv_;
  ColumnPlan plan_;
  std::string file_;
  CheckedInventory result_{};
  std::vector<InventoryRow> block_ = std::vector<InventoryRow>(kBlockRows);
  std::size_t block_size_ = 0;
  ExcludedSummary excluded_{};
  bool has_trees_ = false;  ///< in an earlier part
  std::vector<std::vector<double>> expression_numbers_{};
  std::vector<data::TextColumn> expression_texts_{};
  std::size_t row_count_ = 0;
  std::size_t rows_before_ = 0;           ///< in earlier parts
  std::vector<std::size_t> kept_rows_{};  ///< position in the table or part of each tree, from 0
  data::TextColumn times_{};              ///< of each tree, if there is a column of times
  TimedTrees skipped_{};                  ///< trees of rows that are not used, likewise
  std::vector<SharedPlotLabels> shared_labels_{};  ///< of ColumnPlan::unit_fields
  SharedPlotLabels plots_of_locations_{};
  SharedPlotLabels genera_of_species_{};
  SharedPlotLabels factors_of_plots_{};  ///< values of ColumnPlan::factor_field
  RepeatedNumbers repeated_numbers_{};
  OddValues odd_values_{};
  std::size_t tally_rows_ = 0;     ///< with a number in ColumnPlan::tally_field
  std::size_t tally_others_ = 0;   ///< with another number than 1
  std::size_t tally_several_ = 0;  ///< with several trees
  std::size_t tally_none_ = 0;     ///< with no tree
  std::size_t without_species_ = 0;
  std::size_t without_dbh_ = 0;
  std::size_t crown_base_above_top_ = 0;
  bool has_cw_from_radii_ = false;
  std::size_t other_widths_ = 0;  ///< trees whose cw contradicts their radii
  std::string first_other_width_{};
  data::MissingCodes codes_{};
  StatusColumn status_{};
  SpeciesSpellings spellings_{};
  std::vector<StatusWords> unread_{};  ///< of ColumnPlan::unread, and of species without a status
  std::vector<std::string> plots_of_dead_{};  ///< without a living tree so far
  std::string last_plot_{};                   ///< of the last tree, also of an earlier part
  std::size_t heading_line_ = 0;              ///< of the last heading, before any further tree
  std::string heading_{};
  std::size_t empty_plots_ = 0;      ///< rows with an empty plot below a filled one
  std::size_t empty_plots_run_ = 0;  ///< the last such rows
  bool has_run_of_empty_plots_ = false;
};

}  // namespace silvafit::stand
