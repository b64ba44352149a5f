// SPDX-License-Identifier: MIT
// Reads an inventory in blocks of rows: fields become numbers, expressions give measures, checks
// exclude rows, and the others are appended to the columns.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
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
#include "silvafit/stand/prepared_table.hpp"
#include "silvafit/stand/species_spellings.hpp"
#include "silvafit/stand/tree_status.hpp"
#include "trees/inventory_checks.hpp"
#include "trees/inventory_columns.hpp"
#include "trees/inventory_finished_plots.hpp"
#include "trees/inventory_repeats.hpp"
#include "trees/inventory_shared_labels.hpp"

namespace silvafit::stand {

/// A row of the current block.
struct InventoryRow {
  std::size_t line = 0;
  std::array<std::string, kLabelCount> labels{};
  std::string time{};           ///< as written; empty if there is no such column
  std::string stand{};          ///< as time
  std::string status{};         ///< as time
  std::string measured_plot{};  ///< with InventoryOptions::period: the plot, without the time
  Measures measures{};
  std::string others{};  ///< of an inventory in parts: a record of the fields of other columns
  std::vector<ExcludedRow> unreadable{};  ///< fields that should be numbers but are not
};

/// Reader of a file, either at once or plot by plot.
class InventoryReader {
 public:
  /// \param in_parts  the rows are prepared part by part, by prepare_batches
  InventoryReader(const data::TableSource& source, InventoryOptions options, bool in_parts = false)
      : options_(std::move(options)),
        prepared_(in_parts ? PreparedTable{.table = source}
                           : prepared_table(source, preparation())),
        csv_(prepared_.table, options_.missing),
        plan_(plan(in_parts)) {
    result_.inventory.file = csv_.file();
    result_.inventory.expansion = plan_.expansion;
    for (const std::size_t field : plan_.filled_down) csv_.fill_down(field);
    if (plan_.status_field) {
      status_ =
          StatusColumn(csv_.header()[*plan_.status_field], options_.status_codes, csv_.header());
    }
  }

  /// The whole file.
  CheckedInventory read();
  /// The next plots, until this number of trees is reached; nothing at the end of the file.
  std::optional<CheckedInventory> read_batch(std::size_t trees);
  /// The next rows, until this number of trees is reached, without regard to plots and without
  /// comparison of trees; nothing at the end of the file.
  std::optional<CheckedInventory> read_rows(std::size_t trees);
  bool has_tree_numbers() const { return plan_.labels[kTree].exists(); }
  /// Prepares a file for read_batch: sorts its rows by plot, on disk, if those of a plot do not
  /// follow each other, and finds which of the other columns are text.
  /// \throws UsageError if there are other columns and the file can be read only once
  void prepare_batches();
  /// Whether the order of the rows differs from that of the file.
  bool is_sorted() const { return parts_ && parts_->is_sorted(); }
  /// Notes on all rows read so far.
  std::vector<std::string> notes() const;
  /// Those notes that describe how the file was read.
  std::vector<std::string> recognized() const;
  /// Notes on the rows that read_batch skipped so far.
  std::string excluded() const { return excluded_.text(result_.inventory.file); }

 private:
  static constexpr std::size_t kBlockRows = 4096;

  bool fill_batch(std::size_t trees, bool of_whole_plots);
  CheckedInventory hand_over_batch();
  bool is_new_plot(const InventoryRow& row) const;
  void finish_plots();
  void check_not_finished(const InventoryRow& row) const;
  bool read_block();
  RowPreparation preparation() const;
  ColumnPlan plan(bool in_parts) const;
  bool open_next_part();
  bool next_fields(std::vector<std::string_view>& fields);
  void read_row(const std::vector<std::string_view>& fields,
                InventoryRow& row,
                std::size_t position);
  double number_in(std::size_t position,
                   std::string_view field,
                   const std::string& column,
                   bool is_position,
                   InventoryRow& row);
  void refuse_both_marks(std::string_view text, const std::string& column) const;
  void require_clear_marks() const;
  void require_direction(const ExpressionField& source, double value) const;
  void find_missing_zeros(Measures& measures);
  bool set_aside_if_dead(const InventoryRow& row, TreeStatus status);
  void count_empty_plots(const InventoryRow& row);
  std::string note_on_dead() const;
  std::string note_on_empty_plots() const;
  void evaluate_expressions();
  void accept_or_exclude(InventoryRow& row);
  void complete(InventoryRow& row) const;
  bool exclude_if_unlabeled(const InventoryRow& row);
  void append(const InventoryRow& row, TreeStatus status);
  void exclude(const InventoryRow& row, std::string column, std::string value, std::string reason);
  std::vector<std::string> sources_of_others() const;
  void read_other_columns();
  void find_fields_of_others();
  char separator_of_others() const { return csv_.has_decimal_commas() ? ';' : ','; }
  void read_others_of_batch();
  void set_other_columns(const data::Table& source);
  void count_findings();
  void keep_measurements();
  void find_plots_left_out();
  void find_plot_lines();
  [[noreturn]] void refuse_empty(const std::string& excluded) const;

  InventoryOptions options_;
  PreparedTable prepared_;
  data::CsvReader csv_;
  std::optional<data::TableParts> parts_{};  ///< csv_ reads one of them, if there are parts
  ColumnPlan plan_;
  CheckedInventory result_{};
  std::vector<InventoryRow> block_ = std::vector<InventoryRow>(kBlockRows);
  std::size_t block_size_ = 0;
  std::size_t next_in_block_ = 0;  ///< first row of the block not yet taken
  FinishedPlots finished_{};
  ExcludedSummary excluded_{};  ///< of the batches so far
  bool is_first_batch_ = true;  ///< no batch before has a tree
  std::vector<std::vector<double>> expression_numbers_{};
  std::vector<data::TextColumn> expression_texts_{};
  std::size_t row_count_ = 0;
  std::vector<std::size_t> kept_rows_{};         ///< position in the file of each tree, from 0
  std::vector<std::size_t> fields_of_others_{};  ///< of an inventory in parts
  std::shared_ptr<data::TableHead> head_of_others_{};
  std::string others_{};  ///< the records of the batch's trees
  std::vector<std::size_t> lines_of_others_{};
  std::vector<std::size_t> rows_of_others_{};  ///< as kept_rows_, with trees that were removed
  data::TextColumn times_{};                   ///< of each tree, if there is a column of times
  SharedPlotLabels shared_labels_{};
  RepeatedNumbers repeated_numbers_{};
  OddValues odd_values_{};
  std::size_t without_species_ = 0;
  std::size_t without_dbh_ = 0;
  std::size_t crown_base_above_top_ = 0;
  bool has_cw_from_radii_ = false;
  data::MissingCodes codes_{};
  StatusColumn status_{};
  SpeciesSpellings spellings_{};
  std::size_t empty_plots_ = 0;      ///< rows with an empty plot below a filled one
  std::size_t empty_plots_run_ = 0;  ///< the last such rows
  bool has_run_of_empty_plots_ = false;
};

}  // namespace silvafit::stand
