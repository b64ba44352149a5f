// SPDX-License-Identifier: MIT
// The columns of tables of trees: what each is, and where a file has it.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/stand/tree_status.hpp"

namespace silvafit::stand {

struct Inventory;

/// The values that a measure can have.
struct MeasureRange {
  std::string_view text{};  ///< "above 0 m"; empty: any number
  double lowest = 0.0;
  bool allows_lowest = false;  ///< whether the lowest value is possible itself
  double largest = 0.0;        ///< larger values are odd; 0: none is
};

/// A standard column of a table of trees.
struct TreeColumn {
  std::string_view name{};     ///< plot, dbh, status ...
  std::string_view meaning{};  ///< "diameter at breast height"
  std::string_view unit{};     ///< cm, m or degrees; empty for labels
  MeasureRange range{};
  /// Names in the form of folded_letters(), with blanks between them.
  std::string_view usual{};
  std::string_view vague{};                          ///< used only if no column has a usual name
  std::vector<double> Inventory::*values = nullptr;  ///< of a measure
  /// Names of another measure, used only if no column has one of the names above: dbh is
  /// circumference/pi.
  std::string_view converted{};
  std::string_view conversion{};  ///< what makes it this measure: "/pi"

  bool is_measure() const { return values != nullptr; }
  bool is_position() const { return name == "x" || name == "y" || name == "z"; }
  /// Whether x and y can be made of it: azimuth, distance, x0, y0.
  bool makes_position() const { return !unit.empty() && !is_measure(); }
  bool is_possible(double value) const {
    return range.text.empty() || value > range.lowest ||
           (range.allows_lowest && value == range.lowest);
  }
  /// "diameter at breast height in cm"
  std::string meaning_with_unit() const;
};

/// All standard columns: plot, tree and species, the measures, the status, and those of which
/// positions are made.
std::span<const TreeColumn> tree_columns();
/// The standard column of this name; null if there is none.
const TreeColumn* tree_column(std::string_view name);

/// Whether a name is that of a label: plot, tree or species.
bool is_label(std::string_view name);

/// Whether a name is that of a measure: x, y, z, dbh, h, hcb, cw or a crown radius.
bool is_measure(std::string_view name);

/// Whether a number in a standard column is a missing-value code: -9, -99, -999, -9999 or -99999;
/// in positions the last two only.
bool is_missing_number_of(std::string_view name, double value);

/// Whether a measure cannot be 0, so that 0 is a missing-value code: dbh, h and cw.
bool is_zero_missing(std::string_view name);

/// Makes codes of missing values of a measure missing in columns of numbers: those of
/// is_missing_number_of() and, with `zeros`, 0 where the measure cannot be 0.
/// \param found  called with the column and each code
void take_missing_codes(
    std::string_view measure,
    const std::vector<std::string>& columns,
    bool zeros,
    data::Table& table,
    const std::function<void(const std::string& column, const std::string& code)>& found);

/// `name=source`: the source of a standard column.
struct ColumnMapping {
  std::string name{};    ///< plot, tree, species, x, y, z, dbh, h, hcb, cw, cr_e ..., or any other
  std::string source{};  ///< a column of the file, spelled as in its header, or an expression
};

/// Reads `dbh=DBH_cm,h=Height,x=xk/10`. Commas inside parentheses, double quotes or backquotes do
/// not separate.
/// \throws UsageError if a part is not `name=source` or a name comes twice
std::vector<ColumnMapping> parse_column_mappings(std::string_view text);
std::vector<ColumnMapping> parse_column_mappings(const std::vector<std::string>& entries);

/// The mapping to a name; null if there is none.
const ColumnMapping* mapping_to(std::string_view name, const std::vector<ColumnMapping>& mappings);

/// The columns of a label that is joined of several, such as `SUBP+TREE`: the label of a row is
/// then `1-4`. None if the text is a column, or one of the parts is none.
std::vector<std::string> joined_columns(std::string_view source,
                                        const std::vector<std::string>& header);
/// The label of these fields; empty if one is missing.
std::string joined_label(const std::vector<std::string_view>& fields);
/// The same for all rows of a table.
data::TextColumn joined_labels(const data::Table& table, const std::vector<std::string>& columns);

/// The numbers of a source in a table; texts are NaN.
/// \throws as data::column_reference and data::numbers_of
std::vector<double> numbers_from(const data::Table& table,
                                 std::string_view name,
                                 std::string_view source);

/// Standard columns that a file has under another usual name, such as dbh as BHD, or in another
/// unit, such as `DBH (mm)`, which is the source `DBH (mm)`/10. docs/inventory.md lists the names.
/// In FIA's table TREE, columns have FIA's meaning and units. Labels may be joined_columns(). If x
/// and y are not found, or azimuth or distance are mapped, they are x0 + distance*sin(azimuth) and
/// y0 + distance*cos(azimuth), with x0 = y0 = 0 unless there are such columns.
/// \param header     of the file
/// \param is_wanted  whether a standard name is searched for
/// \param file       for messages
/// \param units      of each column, from a row below the header; none if there is no such row
/// \param by_location  whether FIA's rows of several visits belong to one plot
/// \param mapped     by the user, of which positions may be made
/// \throws UsageError if two columns of the file could be the same standard column, or an azimuth
///   is mapped and no distance is there
std::vector<ColumnMapping> usual_columns(const std::vector<std::string>& header,
                                         const std::function<bool(const std::string&)>& is_wanted,
                                         const std::string& file,
                                         const std::vector<std::string>& units = {},
                                         bool by_location = false,
                                         const std::vector<ColumnMapping>& mapped = {});

/// Checks the azimuths and distances of which usual_columns() makes positions.
/// \param position  the source of x or y
/// \throws InputError if an azimuth is beyond a full circle, or a distance negative
void check_polar_positions(const data::Table& table,
                           const std::string& position,
                           const std::vector<std::string>& header,
                           const std::vector<std::string>& units,
                           const std::vector<ColumnMapping>& mapped);

/// The fields of a column, by position in a header: as mapped, under this name or, of our columns,
/// a usual one. Several for a label of joined columns, none if there is no such column.
std::vector<std::size_t> fields_of(const std::string& name,
                                   const std::vector<std::string>& header,
                                   const std::vector<ColumnMapping>& mapped,
                                   const std::string& file);

/// The column that says whether trees are alive: as mapped, or under a usual name; none if the file
/// has none.
/// \param dead  as the caller asks for
/// \throws UsageError if it is mapped to an expression, or there is no column although codes are
///   given or dead trees are asked for
std::optional<std::string> status_column(const std::vector<std::string>& header,
                                         const std::vector<ColumnMapping>& mappings,
                                         const StatusCodes& codes,
                                         DeadTrees dead,
                                         const std::string& file);

/// The column of the time of measurement: year, else date, in upper or lower case; else that of a
/// known table, or one of other usual names of years, dates and visits.
std::optional<std::string> usual_time_column(const std::vector<std::string>& header);

/// The column that numbers the stems of a tree, by its usual names.
std::optional<std::string> usual_stem_column(const std::vector<std::string>& header);

/// A mapping of a whole column to a measure, converted if the column's header or the row of units
/// names another unit; any other mapping is unchanged.
ColumnMapping in_our_unit(ColumnMapping mapping,
                          const std::vector<std::string>& header,
                          const std::vector<std::string>& units);

/// Whether numbers of species can be codes of FIA: not in a known table of another inventory.
bool may_have_fia_species(const std::vector<std::string>& header);

/// The note on such columns: "dbh is read from column DBH_cm, h from Height". Long expressions are
/// named by their columns.
/// \param header  of the file: a table of FIA is named; empty: not known
std::string describe_usual_columns(const std::vector<ColumnMapping>& columns,
                                   const std::vector<std::string>& header = {});

}  // namespace silvafit::stand
