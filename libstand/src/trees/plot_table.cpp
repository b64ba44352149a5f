// SPDX-License-Identifier: MIT
#include "silvafit/stand/plot_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/stand/similar_plots.hpp"
#include "trees/folded_text.hpp"
#include "trees/known_tables.hpp"
#include "trees/usual_names.hpp"

namespace silvafit::stand {
namespace {

constexpr double kDegreesOfRadian = 180.0 / std::numbers::pi;

/// A number of a plot, its usual names as folded_letters gives them, and its range.
struct NumberColumn {
  std::string_view name;
  double PlotRecord::*value = nullptr;
  std::string_view usual{};  ///< with blanks between them; a unit is part of a name
  double unit = 1.0;         ///< factor from the unit of the usual names to the standard unit
  double low = 0.0;
  double high = 0.0;  ///< 0: no upper limit
  bool may_be_low = false;
};

/// Columns of one name, and of one value, follow each other.
constexpr std::array<NumberColumn, 12> kNumbers{{
    {.name = "area",
     .value = &PlotRecord::area_m2,
     .usual =
         "areaqm aream2 plotarea plotaream2 plotsize plotsizem2 flache flaeche probeflache "
         "probekreisflache flachem2 surface superficie "
         "areaparcela areadelaparcela superficieparcela superficiedelaparcela parzellenflache"},
    {.name = "area",
     .value = &PlotRecord::area_m2,
     .usual = "areaha plotareaha plotsizeha flacheha surfaceha superficieha",
     .unit = 1e4},
    {.name = "radius",
     .value = &PlotRecord::radius_m,
     .usual = "r radiusm plotradius plotradiusm probekreisradius rayon rayonm radio radiom"},
    {.name = "expansion",
     .value = &PlotRecord::expansion,
     .usual = "expansionfactor expfactor treesperha tph nha repfactor"},
    {.name = "expansion",
     .value = &PlotRecord::expansion,
     .usual = kPerAcreNames,
     .unit = kPerAcre},
    {.name = "slope",
     .value = &PlotRecord::slope_deg,
     .usual = "slopedeg slopedegrees inclination neigung hangneigung pente pendiente",
     .high = 90.0,
     .may_be_low = true},
    {.name = "slope_percent",
     .value = &PlotRecord::slope_deg,
     .usual = "slopepct slopeperc neigungprozent pentepct",
     .may_be_low = true},
    // Adjusted proportions of FIA exceed 1 by the part of a stratum's plots that was not sampled;
    // above 2, most of the stratum would be unknown, and the column is in percent.
    {.name = "share",
     .value = &PlotRecord::share,
     .usual = "proportion plotshare anteil condpropunadj",
     .high = 2.0,
     .may_be_low = true},
    {.name = "x", .value = &PlotRecord::x},
    {.name = "y", .value = &PlotRecord::y},
    {.name = "stratum_area",
     .value = &PlotRecord::stratum_ha,
     .usual = "strataarea stratumareaha strataareaha stratumha schichtflache",
     .may_be_low = true},
    {.name = "stratum_weight",
     .value = &PlotRecord::stratum_weight,
     .usual = "strataweight stratumwgt schichtgewicht",
     .may_be_low = true},
}};

/// Names of which one is enough, because each gives the same.
constexpr std::array<std::array<std::string_view, 3>, 3> kAlternatives{
    {{"area", "radius", "expansion"},
     {"slope", "slope_percent"},
     {"stratum_area", "stratum_weight"}}};

constexpr std::string_view kStratumNames = "strata stratumid stratumname schicht strate estrato";
constexpr std::array<std::string_view, 5> kTexts{
    "plot", "stratum", "estimation_unit", "year", "date"};

/// Whether the header says that the slope is in percent: `Slope (%)`.
bool is_percent(std::string_view header) { return header.find('%') != std::string_view::npos; }

/// The factor of the unit in the header of such a column, as in `Area (ac)` and `radius [ft]`; none
/// if it is another column, or has no unit.
std::optional<double> unit_of(const NumberColumn& column, const std::string& header) {
  const HeaderParts parts = header_parts(header);
  const std::string key = folded_letters(parts.name);
  if (key != folded_letters(column.name) && !has_word(column.usual, key)) return std::nullopt;
  if (column.name == "area") return square_meters(parts.other_unit);
  if (column.name == "stratum_area" && square_meters(parts.other_unit)) {
    return *square_meters(parts.other_unit) / 1e4;  // hectares
  }
  if (column.name == "radius" && parts.unit) return parts.unit->meters;
  return std::nullopt;
}

/// The factor of a column to our unit.
double factor_of(std::string_view name, const std::string& source) {
  double factor = 1.0;
  for (const NumberColumn& one : kNumbers) {
    if (one.name != name) continue;
    if (has_word(one.usual, folded_letters(source))) factor = one.unit;
    if (const auto unit = unit_of(one, source)) factor = *unit;
  }
  return factor;
}

class PlotTableReader {
 public:
  PlotTableReader(const data::TableSource& source, const std::vector<ColumnMapping>& columns)
      : header_(data::CsvReader(source).header()), columns_(columns) {
    result_.file = data::file_of(source);
    check_names();
    find_columns();
    read_table(source);
  }

  PlotTable read();

 private:
  void check_names() const;
  void find_columns();
  std::optional<std::string> usual_column(std::string_view name);
  std::string named_instead_of(std::string_view name) const;
  void note(const std::string& text);
  void add(std::string_view name, std::string source, bool is_usual);
  void read_table(const data::TableSource& source);
  std::vector<PlotRecord> records();
  std::vector<double> numbers(const std::string& name);
  std::string text(const std::string& name, std::size_t row) const;
  void check_range(const std::string& name, std::vector<double>& values);
  void compare_others(const std::string& name, const std::vector<double>& values);
  bool repeats(const PlotRecord& record, std::size_t row);
  void problem(std::size_t row, const std::string& column, const std::string& what);
  void refuse_problems() const;

  std::vector<std::string> header_;
  const std::vector<ColumnMapping>& columns_;
  std::map<std::string, std::string, std::less<>> sources_{};
  std::map<std::string, double, std::less<>> factors_{};
  std::map<std::string, std::vector<std::string>> others_{};  ///< further columns of one value
  data::Table table_{};
  PlotTable result_{};
  std::vector<std::string> problems_{};
  bool is_of_trees_ = false;
  std::map<std::pair<std::string, std::string>, PlotRecord> known_{};  ///< by plot and time
};

void PlotTableReader::check_names() const {
  std::vector<std::string> known(kTexts.begin(), kTexts.end());
  for (const NumberColumn& column : kNumbers) known.emplace_back(column.name);
  for (const ColumnMapping& mapping : columns_) {
    if (std::ranges::find(known, mapping.name) != known.end()) continue;
    std::ranges::sort(known);
    known.erase(std::unique(known.begin(), known.end()), known.end());
    throw UsageError(
        fmt::format(
            "'{}' is not a column of plots; available: {}", mapping.name, fmt::join(known, ", ")),
        {.column = "`plots_columns`"});
  }
}

/// A column of the file under another name. Two columns that match are an error, because the
/// choice is up to the user.
std::optional<std::string> PlotTableReader::usual_column(std::string_view name) {
  if (name == "plot") {
    if (auto visit = known_plot_column(header_)) return visit;
  }
  std::vector<std::string> found;
  for (const std::string& column : header_) {
    const std::string key = folded_letters(column);
    bool is_it = key == folded_letters(name) && !is_percent(column);
    if (name == "stratum") is_it = is_it || has_word(kStratumNames, key);
    if (name == "estimation_unit") is_it = is_it || key == "estnunit";
    if (name == "slope_percent") {
      is_it = is_it || (is_percent(column) && has_word("slope inclination neigung hangneigung "
                                                       "pente pendiente",
                                                       key));
    }
    for (const NumberColumn& one : kNumbers) {
      is_it = is_it || (one.name == name && !is_percent(column) &&
                        (has_word(one.usual, key) || unit_of(one, column)));
    }
    if (name == "plot" || name == "x" || name == "y") {
      const std::optional<MeantName> meant = meant_name(column);
      is_it = is_it || (meant && meant->name == name && meant->fit != NameFit::kVague);
    }
    if (is_it) found.push_back(column);
  }
  if (found.empty()) return std::nullopt;
  const auto own = std::ranges::find(found, name);
  if (own != found.end()) {
    std::ranges::copy_if(found,
                         std::back_inserter(others_[std::string(name)]),
                         [name](const std::string& other) { return other != name; });
    return *own;
  }
  if (found.size() > 1) {
    throw UsageError(fmt::format("'{}' and '{}' could both be {}; name one with "
                                 "`plots_columns={}={}`",
                                 found[0],
                                 found[1],
                                 name,
                                 name,
                                 found[0]),
                     {.file = result_.file});
  }
  return found.front();
}

void PlotTableReader::note(const std::string& text) {
  result_.recognized += (result_.recognized.empty() ? "" : ", ") + text;
}

/// The name in `plots_columns` that makes a column of this name unnecessary; empty if there is
/// none.
std::string PlotTableReader::named_instead_of(std::string_view name) const {
  for (const auto& alternatives : kAlternatives) {
    if (std::ranges::find(alternatives, name) == alternatives.end()) continue;
    for (const ColumnMapping& mapping : columns_) {
      if (std::ranges::find(alternatives, mapping.name) != alternatives.end()) return mapping.name;
    }
  }
  return {};
}

void PlotTableReader::add(std::string_view name, std::string source, bool is_usual) {
  if (is_usual && source != name) note(fmt::format("{} is read from column {}", name, source));
  factors_[std::string(name)] = factor_of(name, source);
  sources_.emplace(name, std::move(source));
}

void PlotTableReader::find_columns() {
  is_of_trees_ = std::ranges::any_of(header_, [](const std::string& column) {
    const std::optional<MeantName> meant = meant_name(column);
    return meant && (meant->name == "dbh" || meant->name == "tree") &&
           meant->fit != NameFit::kVague;
  });
  std::vector<std::string> names(kTexts.begin(), kTexts.end());
  for (const NumberColumn& one : kNumbers) {
    if (names.back() != one.name) names.emplace_back(one.name);
  }
  for (const std::string& name : names) {
    const auto mapping = std::ranges::find(columns_, name, &ColumnMapping::name);
    if (mapping != columns_.end()) {
      add(name, mapping->source, false);
    } else if (is_of_trees_ && (name == "x" || name == "y" || name == "expansion")) {
      continue;
    } else if (auto column = usual_column(name)) {
      if (const std::string named = named_instead_of(name); named.empty()) {
        add(name, std::move(*column), true);
      } else {
        note(fmt::format("column {} is not read, because {} is named", *column, named));
      }
    }
  }
  if (sources_.contains("plot")) return;
  throw InputError(
      fmt::format("no column plot was found; name it with `plots_columns=plot=COLUMN`; available: "
                  "{}",
                  data::list_of(header_)),
      {.file = result_.file});
}

void PlotTableReader::read_table(const data::TableSource& source) {
  data::CsvTableOptions options;
  for (const std::string_view name : kTexts) {
    const auto column = sources_.find(name);
    if (column == sources_.end()) continue;
    if (std::ranges::find(header_, column->second) == header_.end()) {
      throw InputError(data::no_such_column(column->second, header_),
                       {.file = result_.file, .column = "`plots_columns`"});
    }
    options.text_columns.push_back(column->second);
  }
  table_ = data::read_csv_table(source, options);
}

void PlotTableReader::problem(std::size_t row, const std::string& column, const std::string& what) {
  const auto plot = sources_.find("plot");
  Place place{.file = result_.file, .column = column};
  if (table_.line(row) > 0) place.line = table_.line(row);
  place.plot = std::string(table_.labels(plot->second)[row]);
  problems_.push_back(describe(place, what));
}

void PlotTableReader::check_range(const std::string& name, std::vector<double>& values) {
  const auto column = std::ranges::find(kNumbers, name, &NumberColumn::name);
  if (name == "x" || name == "y") return;
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (std::isnan(values[row])) continue;
    const double value = values[row];
    const bool is_low = column->may_be_low ? value < column->low : value <= column->low;
    const bool is_high =
        std::isinf(value) ||
        (column->high > 0.0 && (name == "slope" ? value >= column->high : value > column->high));
    if (!is_low && !is_high) continue;
    std::string range = column->may_be_low ? fmt::format("{} or more", column->low)
                                           : fmt::format("above {}", column->low);
    if (column->high > 0.0) {
      range += fmt::format(" and {} {}", name == "slope" ? "below" : "at most", column->high);
    }
    if (name == "share" && is_high) {
      range += "; for percentages use `plots_columns=share=COLUMN/100`";
    }
    problem(row, sources_.find(name)->second, fmt::format("{} must be {}", value, range));
  }
}

/// Columns with other names of the same value must agree with it.
void PlotTableReader::compare_others(const std::string& name, const std::vector<double>& values) {
  constexpr double kRounded = 0.05;  // a size in ha with two decimals, from 0.1 ha on
  for (const std::string& other : others_[name]) {
    if (!table_.is_numeric(other)) continue;
    const auto numbers = table_.numbers(other);
    for (std::size_t row = 0; row < values.size(); ++row) {
      const double value = numbers[row] * factor_of(name, other);
      if (!(std::abs(value - values[row]) > kRounded * std::abs(values[row]))) continue;
      problem(row,
              other,
              fmt::format("{} {} is {:.6g} in the unit of {}, which is {:.6g}; name the right one "
                          "with `plots_columns={}=COLUMN`",
                          other,
                          numbers[row],
                          value,
                          name,
                          values[row],
                          name));
    }
  }
}

std::vector<double> PlotTableReader::numbers(const std::string& name) {
  std::vector<double> values(table_.rows(), data::kMissing);
  const auto source = sources_.find(name);
  if (source == sources_.end()) return values;
  const data::ColumnReference reference =
      data::column_reference(name, source->second, table_.names(), result_.file);
  std::vector<data::TextCell> text_cells;
  values = data::numbers_of(table_, reference, text_cells);
  for (const data::TextCell& cell : text_cells) {
    problem(cell.row, cell.column, fmt::format("'{}' is not a number", cell.text));
  }
  for (double& value : values) value *= factors_[name];
  check_range(name, values);
  compare_others(name, values);
  if (name != "slope_percent") return values;
  for (double& value : values) value = std::atan(value / 100.0) * kDegreesOfRadian;
  return values;
}

/// The rows with their numbers, of several columns of one value the first that is known.
std::vector<PlotRecord> PlotTableReader::records() {
  std::vector<PlotRecord> records(table_.rows());
  std::string_view read;
  for (const NumberColumn& column : kNumbers) {
    if (std::exchange(read, column.name) == column.name) continue;
    const std::vector<double> values = numbers(std::string(column.name));
    for (std::size_t row = 0; row < records.size(); ++row) {
      double& value = records[row].*column.value;
      if (std::isnan(value)) value = values[row];
    }
  }
  return records;
}

std::string PlotTableReader::text(const std::string& name, std::size_t row) const {
  const auto source = sources_.find(name);
  if (source == sources_.end()) return {};
  const data::TextColumn& column = table_.text(source->second);
  if (column.is_missing(row) || data::is_missing_number(column[row])) return {};
  return std::string(column[row]);
}

/// Whether the plot has been read already. In a table of trees its rows must agree.
bool PlotTableReader::repeats(const PlotRecord& record, std::size_t row) {
  const auto [found, is_new] = known_.try_emplace({record.plot, record.time}, record);
  if (is_new) return false;
  const PlotRecord& first = found->second;
  if (!is_of_trees_) {
    problem(row,
            sources_.find("plot")->second,
            fmt::format("the plot is already on line {}{}",
                        first.line,
                        result_.has_time ? " with the same date" : ""));
    return true;
  }
  const auto differs = [&](const std::string& name, const auto& value, const auto& known) {
    problem(
        row,
        name,
        fmt::format("{} differs from {} on line {}, of the same plot", value, known, first.line));
  };
  double PlotRecord::*compared = nullptr;
  for (const NumberColumn& column : kNumbers) {
    if (std::exchange(compared, column.value) == column.value) continue;
    const double value = record.*column.value;
    const double known = first.*column.value;
    const bool is_same = value == known || (std::isnan(value) && std::isnan(known));
    if (!is_same) differs(std::string(column.name), value, known);
  }
  if (record.stratum != first.stratum) differs("stratum", record.stratum, first.stratum);
  return true;
}

void PlotTableReader::refuse_problems() const {
  constexpr std::size_t kShown = 5;
  if (problems_.empty()) return;
  std::string text = problems_.front();
  for (std::size_t i = 1; i < std::min(kShown, problems_.size()); ++i) text += "\n" + problems_[i];
  if (problems_.size() > kShown) text += fmt::format("\nand {} more", problems_.size() - kShown);
  throw InputError(text);
}

PlotTable PlotTableReader::read() {
  const std::string time = sources_.contains("year") ? "year" : "date";
  result_.has_stratum = sources_.contains("stratum");
  result_.has_time = sources_.contains(time);
  result_.has_slope = sources_.contains("slope") || sources_.contains("slope_percent");
  if (const auto slope = sources_.find("slope"); slope != sources_.end()) {
    result_.slope_lacks_unit = header_parts(slope->second).other_unit.empty() &&
                               folded_letters(slope->second).find("deg") == std::string::npos;
  }
  result_.has_center = sources_.contains("x") && sources_.contains("y");
  std::vector<PlotRecord> rows = records();
  for (std::size_t row = 0; row < rows.size(); ++row) {
    PlotRecord& record = rows[row];
    record.line = table_.line(row);
    record.plot = text("plot", row);
    record.stratum = text("stratum", row);
    record.estimation_unit = text("estimation_unit", row);
    record.time = text(time, row);
    if (record.plot.empty()) problem(row, sources_.find("plot")->second, "the plot is missing");
    const auto is_plot = [this](std::string_view plot) {
      return std::ranges::find(result_.plots, plot, &PlotRecord::plot) != result_.plots.end();
    };
    if (is_summary_label(record.plot, is_plot)) {
      problem(row, sources_.find("plot")->second, "a row of sums or means is not a plot");
    }
    if (!repeats(record, row)) result_.plots.push_back(std::move(record));
  }
  if (result_.plots.empty()) {
    throw InputError("the table of plots has no rows", {.file = result_.file});
  }
  refuse_problems();
  return std::move(result_);
}

/// The area whose name, or one of whose usual names, a column has; null: none.
const NumberColumn* area_named(const std::string& column) {
  const std::string key = folded_letters(column);
  const auto found = std::ranges::find_if(kNumbers, [&](const NumberColumn& one) {
    return one.name == "area" && (key == "area" || has_word(one.usual, key));
  });
  return found == kNumbers.end() ? nullptr : &*found;
}

}  // namespace

PlotTable read_plot_table(const data::TableSource& source,
                          const std::vector<ColumnMapping>& columns) {
  return PlotTableReader(source, columns).read();
}

std::string plot_area_column(const std::vector<std::string>& header) {
  const auto found = std::ranges::find_if(
      header, [](const std::string& column) { return area_named(column) != nullptr; });
  return found == header.end() ? std::string() : *found;
}

std::string offer_of_area_column(const Inventory& inventory) {
  const std::string& column = inventory.area_column;
  const NumberColumn* area = area_named(column);
  std::string offer;
  if (!inventory.factors.column.empty()) {
    offer = fmt::format(
        "; if {0} is the number of trees per ha that a row stands for, use "
        "`expansion={0}`",
        inventory.factors.column);
  }
  if (area == nullptr) return offer;
  offer += fmt::format(
      ", or read it from column '{}' of this file with `plots={}`", column, inventory.file);
  const std::string key = folded_letters(column);
  const bool has_unit = area->unit != 1.0 || key.ends_with("m2") || key.ends_with("qm");
  if (!has_unit) {
    offer += fmt::format("; if it is in ha, with `plots_columns=area=`{}`*10000`", column);
  }
  return offer;
}

void refuse_unused_factors(const Inventory& inventory) {
  const Inventory::UnusedFactors& factors = inventory.factors;
  if (factors.plot.empty()) return;
  throw InputError(
      fmt::format("trees stand for different numbers of trees per ha, {} and {}, if the column {} "
                  "has these; use `expansion={}`, or, if every row is one tree of the whole plot, "
                  "`trust_units=true`",
                  factors.first,
                  factors.other,
                  factors.column,
                  factors.column),
      {.file = inventory.file, .column = factors.column, .plot = factors.plot});
}

}  // namespace silvafit::stand
