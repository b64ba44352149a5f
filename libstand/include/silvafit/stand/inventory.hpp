// SPDX-License-Identifier: MIT
// Forest inventories with one row per tree, and the checks of their values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/tree_columns.hpp"
#include "silvafit/stand/tree_status.hpp"

namespace silvafit::stand {

/// The values of an equation for each tree, such as its volume.
struct TreeQuantity {
  std::string name{};            ///< volume, biomass, carbon
  std::string unit{};            ///< m3, kg; empty: that of a column of the file
  std::vector<double> values{};  ///< (N) NaN where the equation does not apply
};

/// Its name with its unit, if it has one: volume_m3.
std::string label_of(const TreeQuantity& quantity);

/// Measured trees, N of them, in the order of the file. A measure has N values, NaN where it was
/// not taken; it has none if the file has no such column.
struct Inventory {
  std::string file{};
  std::vector<std::uint32_t> lines{};  ///< line of each tree in the file, from 1

  data::TextColumn plot{};
  data::TextColumn tree{};     ///< unique within a plot; the second tree of a number gets #2
  data::TextColumn species{};  ///< missing where the field is empty
  data::TextColumn stem{};     ///< its number within the tree, if the file has such a column
  /// (N) equal for rows of the file that are equal in all columns, while rows are compared.
  std::vector<std::uint64_t> contents{};

  std::vector<double> x{};  ///< east [m]
  std::vector<double> y{};  ///< north [m]
  std::vector<double> z{};  ///< elevation of the stem's foot [m]

  std::vector<double> dbh_cm{};  ///< diameter at breast height, > 0; missing in neighbors only
  std::vector<double> h_m{};     ///< total height, > 1.3
  std::vector<double> hcb_m{};   ///< height to crown base, in [0, h)
  std::vector<double> cw_m{};    ///< crown width, a diameter, > 0
  std::vector<double> cr_e_m{};  ///< crown radii to the east, west, south and north, >= 0
  std::vector<double> cr_w_m{};
  std::vector<double> cr_s_m{};
  std::vector<double> cr_n_m{};

  /// (N) 1 for trees that are neighbors of others and not used otherwise: those without dbh, and
  /// standing dead ones with DeadTrees::kNeighbors; none if there are no such trees.
  std::vector<char> neighbor_only{};

  /// (N) Number of trees on the area of its plot that a tree stands for, by the sampling design;
  /// none if it is one for all.
  std::vector<double> represented{};

  std::vector<TreeQuantity> quantities{};  ///< none, unless they were computed

  /// Of repeated measurements only (InventoryOptions::keeps_measurements): year or date of each
  /// row, as written, and whether the tree was alive then; none if the file has no such column.
  /// With InventoryOptions::period `time` has the times, too.
  data::TextColumn time{};
  std::vector<TreeStatus> status{};
  /// With InventoryOptions::period only: the plot of each row in the file, as `plot` is then the
  /// plot at a time, "7 (2019)".
  data::TextColumn measured_plot{};

  /// Plots of the file all of whose rows were skipped: their trees are unknown.
  std::vector<std::string> plots_left_out{};
  /// Plots of the file all of whose trees are dead or cut: they are empty.
  std::vector<std::string> plots_without_trees{};
  /// By code of `plot`: the line of its first row in the file, even if that row was skipped; none
  /// if the plots are in the order of these lines.
  std::vector<std::uint32_t> plot_lines{};

  /// Column of `other` with the number of trees per hectare that each tree stands for, if the table
  /// has one of known meaning (FIA's TPA_UNADJ); kept only with InventoryOptions::keeps_expansion.
  std::string expansion{};

  /// A column of the file that may have such numbers, but is not used.
  struct UnusedFactors {
    std::string column{};  ///< empty if there is none
    std::string plot{};    ///< with trees of two numbers, `first` and `other`; else empty
    std::string first{};
    std::string other{};
  } factors{};

  bool trusts_units = false;     ///< InventoryOptions::trust_units
  double position_unit_m = 1.0;  ///< meters of a unit of x and y in the file
  /// Whether x and y are from the center of plots, computed from the subplots of FIA's trees.
  bool is_placed_by_subplots = false;

  /// The column of the file that each label and the time is from; none for those joined of several.
  std::map<std::string, std::string> label_columns{};

  /// Column of the file that may have the areas of the plots, see plot_area_column(); else empty.
  std::string area_column{};

  /// Other columns that were requested.
  data::Table other{};

  std::size_t size() const { return dbh_cm.size(); }
  bool is_neighbor_only(std::size_t row) const {
    return !neighbor_only.empty() && neighbor_only[row] != 0;
  }
  /// The number of trees on the area of its plot that a tree stands for.
  double trees_represented(std::size_t row) const {
    return represented.empty() ? 1.0 : represented[row];
  }
  bool has_coordinates() const { return !x.empty() && !y.empty(); }
  /// The line of a tree in the file, for messages.
  Place place(std::size_t row) const;
};

struct InventoryOptions {
  std::vector<ColumnMapping> columns{};  ///< sources may be a data::TextFormula
  /// Condition for the rows to use, of columns of the file and standard names; empty: all rows.
  std::string where{};
  /// `dbh=DBH_{year}`: columns of one measure at several times, which become a row each with the
  /// columns `year` and `dbh`. What stands at {} begins with a digit.
  std::vector<ColumnMapping> visits{};
  /// Columns of the file to keep in Inventory::other if they are not standard columns. Mappings to
  /// other names are kept there too.
  std::vector<std::string> keep{};
  bool keep_all = false;                  ///< keep every other column of the file
  bool refuses_unread = false;            ///< mappings to names that are not kept are errors
  bool needs_coordinates = false;         ///< rows without x or y cannot be used
  bool trust_units = false;               ///< do not check whether a column has another unit
  std::vector<std::string> missing{};     ///< further texts and numbers for missing values
  std::vector<std::string> fill_down{};   ///< columns whose empty fields have the value above
  DeadTrees dead = DeadTrees::kLeaveOut;  ///< cut, fallen and stumps are always skipped except with
                                          ///< kInclude
  StatusCodes status_codes{};             ///< values of the status column
  bool has_expansion = false;             ///< rows have given numbers of trees per hectare
  bool keeps_expansion = false;           ///< keep the column of Inventory::expansion
  bool case_sensitive = false;            ///< species that differ only in capitals are different
  std::vector<std::string> needs{};       ///< measures the file must have, such as "h"
  /// Keep the rows of all dates and of dead and cut trees, with Inventory::time and status, for
  /// growth. Otherwise later measurements of a tree are skipped.
  bool keeps_measurements = false;
  /// Column of the subplots in which trees are numbered, if numbers tell trees apart within them
  /// only. Empty: none.
  std::string subplot{};
  /// Column of the time of measurement, if each plot and time is to be a plot of its own: then the
  /// rows of all times are kept, and dead and cut trees as without it. Empty: no.
  std::string period{};
  bool is_part = false;  ///< a part of an inventory: all its trees may lack dbh
};

/// Why a row cannot be used. A row with several problems has as many entries.
struct ExcludedRow {
  std::size_t line = 0;
  std::string plot{};
  std::string tree{};
  std::string column{};  ///< the file's name of the column
  std::string value{};   ///< as written, or the number that was tested
  std::string reason{};
  bool is_problem = true;  ///< false: a valid row of a dead or cut tree or of an earlier visit
};

struct CheckedInventory {
  Inventory inventory{};
  std::vector<ExcludedRow> excluded{};  ///< by line
  std::size_t excluded_tree_count = 0;  ///< skipped rows
  bool is_in_file_order = true;         ///< false: Inventory::lines has the order of the file
  std::vector<std::string> notes{};     ///< recognized columns, assumptions, single unusual values
  /// Of these, how the file was read: titles, columns, units, codes, spellings, dead trees.
  std::vector<std::string> recognized{};
};

/// Reads an inventory from a file or a table in memory, and checks every value; docs/inventory.md
/// lists the columns and the rules.
///
/// A value that was not measured is missing; an impossible value excludes its row, and all
/// problems of all rows are collected. A missing crown width is computed from four radii:
/// cw = ((cr_e + cr_w) + (cr_s + cr_n)) / 2.
/// \throws InputError if a needed column is missing, a whole column looks like another unit (the
///         message names the remedy), or no row can be used (with the first problems)
/// \throws FormulaError if a mapping cannot be read; InputError if it names a missing column
CheckedInventory read_inventory(const data::TableSource& source,
                                const InventoryOptions& options = {});

/// What a batch of an inventory has.
enum class BatchOf {
  kTable,  ///< all trees
  kPlots,  ///< whole plots
  kRows,   ///< rows in the order of the file, whose trees are not compared with each other
};

/// The note on files that are read plot by plot and were sorted first.
inline constexpr char kSortedNote[] =
    "the rows of a plot are not contiguous; the file was sorted by plot on disk";

/// Reads an inventory batch by batch, so that memory does not grow with the file. If the rows of a
/// plot do not follow each other, they are sorted by plot on disk; those of a pipe, and of a file
/// without numbers of trees, must follow each other. A whole table is one batch.
class InventoryBatches {
 public:
  /// Columns beyond the inventory's own (keep, keep_all, other mappings) need a file, which is then
  /// read twice: whether a column is text depends on all rows.
  /// \param rows     a batch ends with the plot that reaches this number of rows
  /// \param threads  1: no reading ahead
  /// \param note     gets all notes, with a whole table or after the last batch
  /// \throws as read_inventory; UsageError if the source of several batches is no CSV file, or if
  ///         there are other columns and the file can be read only once
  explicit InventoryBatches(const data::TableSource& source,
                            const InventoryOptions& options,
                            std::size_t rows = 200000,
                            BatchOf of = BatchOf::kPlots,
                            unsigned threads = 1,
                            std::function<void(const std::string&)> note = {});
  ~InventoryBatches();
  InventoryBatches(InventoryBatches&&) noexcept;
  InventoryBatches& operator=(InventoryBatches&&) noexcept;

  /// The next batch, checked as read_inventory does; nothing at the end. Units are checked in the
  /// first batch. A batch of several has no notes: see notes().
  /// \throws InputError also if a plot comes again after its batch
  std::optional<CheckedInventory> next();
  /// The rows of the last batch, if there is no reading ahead; null if the table is one batch.
  const std::shared_ptr<const data::TableText>& rows() const;
  /// Of all batches; 0 if the table is one batch, or is read in one pass.
  std::size_t row_count() const;
  /// The notes on all batches read so far: on sorting and, after the last, those of read_inventory.
  std::vector<std::string> notes() const;
  /// Of these, how the file was read, as CheckedInventory::recognized.
  std::vector<std::string> recognized() const;
  /// Whether the rows were sorted.
  bool is_sorted() const;
  /// Whether the file numbers its trees.
  bool has_numbers() const;
  /// ExcludedSummary of all batches read so far.
  std::string excluded() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The skipped rows of an inventory, or of its batches one after another; only those that are shown
/// are kept.
class ExcludedSummary {
 public:
  explicit ExcludedSummary(std::size_t most_shown = 5) : most_shown_(most_shown) {}
  void add(const CheckedInventory& batch);
  /// Their number and the reasons for the first ones; empty if none was skipped. Rows of dead trees
  /// are not counted.
  std::string text(const std::string& file) const;

 private:
  std::size_t most_shown_;
  std::vector<ExcludedRow> shown_{};
  std::size_t problems_ = 0;
  std::size_t without_problem_ = 0;
  std::size_t left_out_ = 0;
  std::size_t kept_ = 0;
};

inline constexpr char kExcludedHeader[] = "line,plot,tree,column,value,reason\n";

/// Writes excluded.csv: line, plot, tree, column, value, reason.
void write_excluded(const std::vector<ExcludedRow>& excluded, std::ostream& stream);
void write_excluded(const std::vector<ExcludedRow>& excluded, const std::filesystem::path& path);
/// A row of excluded.csv, with its line end.
std::string csv_text(const ExcludedRow& row);

/// The inventory as a table with standard names: plot, tree, species, the measures that the file
/// has (x, y, z, dbh, h, hcb, cw, cr_e, cr_w, cr_s, cr_n), then the other columns.
data::Table to_table(const Inventory& inventory);

}  // namespace silvafit::stand
