// SPDX-License-Identifier: MIT
// Where a file has the standard columns: under usual names, in other units, in several columns.
#include "trees/column_sources.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/data/text_formula.hpp"
#include "silvafit/stand/inventory.hpp"
#include "trees/known_tables.hpp"
#include "trees/status_words.hpp"
#include "trees/usual_names.hpp"

namespace silvafit::stand {
namespace {

constexpr std::string_view kStatus = "status";

/// Short names of crown radii, such as RW and CRS, have other meanings (ring width, coordinate
/// system) where those of the other three directions are missing.
bool is_one_of_four_radii(std::string_view name, const std::vector<std::string>& header) {
  constexpr std::array<std::string_view, 4> kRadii{"cr_e", "cr_w", "cr_s", "cr_n"};
  if (std::ranges::find(kRadii, name) == kRadii.end()) return true;
  return std::ranges::all_of(kRadii, [&header](std::string_view radius) {
    return std::ranges::any_of(header, [radius](const std::string& column) {
      const auto meant = meant_name(column);
      return meant && meant->name == radius;
    });
  });
}

/// The field of a standard column under another usual spelling.
/// \throws UsageError if there are two such fields; of several status columns the first is used
std::optional<std::size_t> usual_field(std::string_view name,
                                       const std::vector<std::string>& header,
                                       const std::string& file) {
  std::optional<std::size_t> found;
  std::optional<std::size_t> other;
  NameFit best = NameFit::kConverted;
  for (std::size_t i = 0; i < header.size(); ++i) {
    const std::optional<MeantName> meant = meant_name(header[i]);
    if (!meant || meant->name != name) continue;
    if (found && (meant->fit > best || (meant->fit == best && name == kStatus))) continue;
    other = found && meant->fit == best ? found : std::nullopt;
    found = i;
    best = meant->fit;
  }
  if (found && best != NameFit::kUsual && !is_one_of_four_radii(name, header)) return std::nullopt;
  if (other) {
    throw UsageError(fmt::format("'{}' and '{}' could both be {}; name one with `columns={}={}`",
                                 header[*other],
                                 header[*found],
                                 name,
                                 name,
                                 header[*other]),
                     {.file = file});
  }
  return found;
}

/// A column, converted to the standard unit if it has another one.
std::string in_our_unit(std::string_view name,
                        const std::string& column,
                        const std::optional<LengthUnit>& unit) {
  constexpr double kCentimeter = 0.01;
  const TreeColumn* const standard = tree_column(name);
  const bool is_length = standard != nullptr && (standard->unit == "cm" || standard->unit == "m");
  if (!unit || !is_length) return column;
  const double ours_m = standard->unit == "cm" ? kCentimeter : 1.0;
  if (unit->meters == ours_m) return column;
  const std::string text = data::Expression::variable(column).text();
  const double divisor = std::round(ours_m / unit->meters);
  const bool is_metric = unit->name != "in" && unit->name != "ft" && unit->name != "yd";
  const bool is_decimal_part = is_metric && divisor > 1.0;
  if (is_decimal_part) return fmt::format("{}/{}", text, divisor);
  return fmt::format("{}*{:.6g}", text, unit->meters / ours_m);
}

/// Whether the source of a known table is used for a standard column although the header has one of
/// this name: for labels, such as FIA's PLOT, which is unique within a county only, and for the
/// column itself, which may have another unit.
bool is_known_preferred(const ColumnMapping& known, const std::vector<std::string>& header) {
  return is_label(known.name) || known.source == known.name ||
         std::ranges::find(header, known.name) == header.end();
}

/// Where x and y come from if trees were measured from points by azimuth and distance.
class PolarPosition {
 public:
  PolarPosition(const std::vector<std::string>& header,
                const std::vector<ColumnMapping>& mapped,
                const std::string& file,
                const std::vector<std::string>& units)
      : header_(header), mapped_(mapped), file_(file), units_(units) {}

  /// Nothing if a column is missing.
  std::vector<ColumnMapping> sources() const;
  /// Whether the user has named columns of it.
  bool is_named() const {
    return mapping_to("azimuth", mapped_) != nullptr || mapping_to("distance", mapped_) != nullptr;
  }

 private:
  std::string source_of(std::string_view name) const;

  const std::vector<std::string>& header_;
  const std::vector<ColumnMapping>& mapped_;
  const std::string& file_;
  const std::vector<std::string>& units_;
};

/// A factor or summand of an expression; empty if there is no such column.
std::string PolarPosition::source_of(std::string_view name) const {
  ColumnMapping source{.name = std::string(name)};
  if (const ColumnMapping* const mapping = mapping_to(name, mapped_)) {
    source = *mapping;
  } else if (const auto field = usual_field(name, header_, file_)) {
    source.source = header_[*field];
  } else {
    return {};
  }
  source = in_our_unit(std::move(source), header_, units_);
  if (std::ranges::find(header_, source.source) == header_.end()) return "(" + source.source + ")";
  return data::Expression::variable(source.source).text();
}

std::vector<ColumnMapping> PolarPosition::sources() const {
  const std::string azimuth = source_of("azimuth");
  // Without directions, columns of distances are others.
  if (azimuth.empty() && !is_named()) return {};
  const std::string distance = source_of("distance");
  if (is_named() && (azimuth.empty() || distance.empty())) {
    const char* const lacking = azimuth.empty() ? "azimuth" : "distance";
    throw UsageError(fmt::format("positions need an azimuth and a distance; name the {0} with "
                                 "`columns={0}=COLUMN`; available: {1}",
                                 lacking,
                                 data::list_of(header_)),
                     {.file = file_, .column = "`columns`"});
  }
  if (azimuth.empty() || distance.empty()) return {};
  const auto coordinate = [&](std::string_view start, std::string_view function) {
    const std::string from = source_of(start);
    return fmt::format(
        "{}{}{}*{}({}*pi/180)", from, from.empty() ? "" : " + ", distance, function, azimuth);
  };
  return {{"x", coordinate("x0", "sin")}, {"y", coordinate("y0", "cos")}};
}

constexpr char kColumnsOption[] = "`columns`";

ColumnMapping mapping_of(std::string_view part) {
  const std::size_t sign = part.find('=');
  if (sign != std::string_view::npos) {
    const std::string_view name = data::trimmed(part.substr(0, sign));
    const std::string_view source = data::trimmed(part.substr(sign + 1));
    if (!name.empty() && !source.empty() && !source.starts_with('=')) {
      return {.name = std::string(name), .source = std::string(source)};
    }
  }
  throw UsageError(fmt::format("'{}' is not NAME=COLUMN, such as dbh=DBH_cm or x=xk/10", part),
                   {.column = kColumnsOption});
}

}  // namespace

const ColumnMapping* mapping_to(std::string_view name, const std::vector<ColumnMapping>& mappings) {
  const auto found = std::ranges::find(mappings, name, &ColumnMapping::name);
  return found == mappings.end() ? nullptr : &*found;
}

bool is_no_column(const ColumnMapping& mapping, const std::vector<std::string>& header) {
  return mapping.source == "NA" && !field_named(mapping.source, header);
}

std::optional<std::size_t> field_named(std::string_view name,
                                       const std::vector<std::string>& header) {
  const auto found = std::ranges::find(header, name);
  if (found == header.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header.begin());
}

std::optional<LengthUnit> unit_of_field(std::size_t field,
                                        const std::vector<std::string>& header,
                                        const std::vector<std::string>& units) {
  if (const auto unit = unit_in_header(header[field])) return unit;
  if (field < units.size()) {
    if (const auto unit = unit_of_length(units[field])) return unit;
  }
  return unit_of_length(known_unit(header[field], header));
}

std::optional<std::size_t> field_in_any_case(std::string_view name,
                                             const std::vector<std::string>& header) {
  const auto found = std::ranges::find_if(
      header, [name](const std::string& column) { return are_equal_words(column, name); });
  if (found == header.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header.begin());
}

std::optional<ColumnMapping> source_of(const std::string& name,
                                       const std::vector<std::string>& header,
                                       const std::vector<std::string>& units,
                                       const std::vector<ColumnMapping>& mapped,
                                       const std::string& file) {
  if (const ColumnMapping* const mapping = mapping_to(name, mapped)) {
    if (is_no_column(*mapping, header)) return std::nullopt;
    return in_our_unit(*mapping, header, units);
  }
  const auto is_it = [&name](const std::string& known) { return known == name; };
  const std::vector<ColumnMapping> usual = usual_columns(header, is_it, file, units, false, mapped);
  if (!usual.empty()) return usual.front();
  const bool is_own = std::ranges::find(header, name) != header.end();
  return is_own ? std::optional(ColumnMapping{.name = name, .source = name}) : std::nullopt;
}

/// Times and statuses are columns, because expressions make numbers.
void require_column(const ColumnMapping& mapping,
                    const std::vector<std::string>& header,
                    const std::string& file) {
  if (std::ranges::find(header, mapping.source) != header.end()) return;
  const std::string remedy =
      mapping.name == kStatus
          ? "name the column and explain its values, such as `columns=status=COLUMN` and "
            "`dead_codes=DS`"
          : fmt::format("name the column: `columns={}=COLUMN`", mapping.name);
  throw UsageError(fmt::format("{} must be a column, not the expression '{}'; {}; available: {}",
                               mapping.name,
                               mapping.source,
                               remedy,
                               data::list_of(header)),
                   {.file = file, .column = "`columns`"});
}

std::vector<std::string> joined_columns(std::string_view source,
                                        const std::vector<std::string>& header) {
  const auto is_column = [&header](std::string_view name) {
    return std::ranges::find(header, name) != header.end();
  };
  std::vector<std::string> columns;
  if (is_column(source) || source.find('+') == std::string_view::npos) return columns;
  for (std::size_t begin = 0; begin <= source.size();) {
    const std::size_t end = std::min(source.find('+', begin), source.size());
    std::string_view name = data::trimmed(source.substr(begin, end - begin));
    const bool is_quoted = name.size() > 2 && name.front() == '`' && name.back() == '`';
    if (is_quoted) name = name.substr(1, name.size() - 2);
    if (!is_column(name)) return {};
    columns.emplace_back(name);
    begin = end + 1;
  }
  return columns;
}

std::string joined_label(const std::vector<std::string_view>& fields) {
  std::string label;
  for (const std::string_view field : fields) {
    const std::string_view text = data::trimmed(field);
    if (data::is_missing_field(text)) return {};
    if (!label.empty()) label += '-';
    label += text;
  }
  return label;
}

data::TextColumn joined_labels(const data::Table& table, const std::vector<std::string>& columns) {
  std::vector<data::TextColumn> fields;
  for (const std::string& column : columns) fields.push_back(table.labels(column));
  data::TextColumn labels;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    std::vector<std::string_view> texts;
    for (const data::TextColumn& field : fields) texts.push_back(field[row]);
    const std::string label = joined_label(texts);
    label.empty() ? labels.append_missing() : labels.append(label);
  }
  return labels;
}

std::vector<double> numbers_from(const data::Table& table,
                                 std::string_view name,
                                 std::string_view source) {
  std::vector<data::TextCell> ignored;
  return data::numbers_of(
      table, data::column_reference(name, source, table.names(), table.file()), ignored);
}

void take_missing_codes(
    std::string_view measure,
    const std::vector<std::string>& columns,
    bool zeros,
    data::Table& table,
    const std::function<void(const std::string& column, const std::string& code)>& found) {
  for (const std::string& column : columns) {
    if (!table.has(column) || !table.is_numeric(column)) continue;
    std::vector<double> values(table.numbers(column).begin(), table.numbers(column).end());
    for (double& value : values) {
      const bool is_zero = zeros && value == 0.0 && is_zero_missing(measure);
      if (!is_zero && !is_missing_number_of(measure, value)) continue;
      if (found) found(column, data::shortest(value));
      value = data::kMissing;
    }
    table.set(column, std::move(values));
  }
}

std::vector<double> measured_values(
    std::string_view name,
    const data::ColumnReference& reference,
    data::Table table,
    const std::function<void(const std::string& column, const std::string& code)>& found) {
  take_missing_codes(name, reference.columns(), !reference.expression, table, found);
  std::vector<data::TextCell> ignored;
  std::vector<double> values = data::numbers_of(table, reference, ignored);
  for (double& value : values) {
    if (value != 0.0 || !is_zero_missing(name)) continue;
    if (found) found(reference.text, data::shortest(value));
    value = data::kMissing;
  }
  return values;
}

std::vector<ColumnMapping> usual_columns(const std::vector<std::string>& header,
                                         const std::function<bool(const std::string&)>& is_wanted,
                                         const std::string& file,
                                         const std::vector<std::string>& units,
                                         bool by_location,
                                         const std::vector<ColumnMapping>& mapped) {
  std::vector<ColumnMapping> found;
  const PolarPosition polar(header, mapped, file, units);
  bool has_position = false;
  const std::vector<ColumnMapping> known_table = known_columns(header, by_location);
  for (const TreeColumn& column : tree_columns()) {
    std::string name(column.name);
    if (name == kStatus || column.makes_position() || !is_wanted(name)) continue;
    if ((name == "x" || name == "y") && polar.is_named()) continue;
    const ColumnMapping* const known = mapping_to(name, known_table);
    if (known != nullptr && is_known_preferred(*known, header)) {
      has_position = has_position || column.is_position();
      ColumnMapping ours = in_our_unit(*known, header, units);
      if (ours.source != name) found.push_back(std::move(ours));
      continue;
    }
    const auto own = field_named(name, header);
    const auto field = own ? own : usual_field(name, header, file);
    if (!field) continue;
    has_position = has_position || name == "x" || name == "y";
    std::string source = in_our_unit(name, header[*field], unit_of_field(*field, header, units));
    const auto meant = meant_name(header[*field]);
    if (!own && meant && !meant->conversion.empty()) {
      if (source == header[*field]) source = data::Expression::variable(source).text();
      source += meant->conversion;
    }
    if (source != name) found.push_back({std::move(name), std::move(source)});
  }
  const bool wants_position = is_wanted("x") || is_wanted("y");
  if (has_position || !wants_position) return found;
  for (ColumnMapping& coordinate : polar.sources()) {
    if (is_wanted(coordinate.name)) found.push_back(std::move(coordinate));
  }
  return found;
}

std::optional<double> degrees_of_field(std::size_t field,
                                       const std::vector<std::string>& header,
                                       const std::vector<std::string>& units) {
  const auto below = field < units.size() ? degrees_of(units[field]) : std::nullopt;
  return below ? below : degrees_of(header_parts(header[field]).other_unit);
}

ColumnMapping in_our_unit(ColumnMapping mapping,
                          const std::vector<std::string>& header,
                          const std::vector<std::string>& units) {
  const auto field = field_named(mapping.source, header);
  if (!field) return mapping;
  const auto degrees = degrees_of_field(*field, header, units);
  if (mapping.name == "azimuth" && degrees) {
    mapping.source =
        fmt::format("{}*{}", data::Expression::variable(mapping.source).text(), *degrees);
  }
  mapping.source = in_our_unit(mapping.name, mapping.source, unit_of_field(*field, header, units));
  return mapping;
}

std::vector<std::size_t> fields_of(const std::string& name,
                                   const std::vector<std::string>& header,
                                   const std::vector<ColumnMapping>& mapped,
                                   const std::string& file) {
  const auto find = [&header](const std::string& source) {
    std::vector<std::size_t> fields;
    if (const auto own = field_named(source, header)) return std::vector{*own};
    for (const std::string& column : joined_columns(source, header)) {
      fields.push_back(*field_named(column, header));
    }
    return fields;
  };
  const ColumnMapping* const mapping = mapping_to(name, mapped);
  if (mapping != nullptr && is_no_column(*mapping, header)) return {};
  std::vector<std::size_t> fields = find(mapping == nullptr ? name : mapping->source);
  if (!fields.empty()) return fields;
  const auto is_it = [&name](const std::string& known) { return known == name; };
  const std::vector<ColumnMapping> usual = usual_columns(header, is_it, file);
  return usual.size() == 1 ? find(usual.front().source) : fields;
}

std::optional<std::string> status_column(const std::vector<std::string>& header,
                                         const std::vector<ColumnMapping>& mappings,
                                         const StatusCodes& codes,
                                         DeadTrees dead,
                                         const std::string& file) {
  if (const ColumnMapping* const mapping = mapping_to(kStatus, mappings)) {
    if (is_no_column(*mapping, header)) return std::nullopt;
    require_column(*mapping, header, file);
    return mapping->source;
  }
  if (const auto known = known_status_column(header)) return known;
  if (const auto field = usual_field(kStatus, header, file)) return header[*field];
  const auto named = std::ranges::find_if(header, [](const std::string& column) {
    const auto of_header = status_of_header(column);
    return of_header && of_header->is_clear;
  });
  if (named != header.end()) return *named;
  const char* const given = !codes.alive.empty()           ? "`alive_codes`"
                            : !codes.dead.empty()          ? "`dead_codes`"
                            : !codes.cut.empty()           ? "`cut_codes`"
                            : dead != DeadTrees::kLeaveOut ? "`dead`"
                                                           : nullptr;
  if (given == nullptr) return std::nullopt;
  throw UsageError(
      fmt::format("no column of the status was found; name it with `columns=status=COLUMN`; "
                  "available: {}",
                  data::list_of(header)),
      {.file = file, .column = given});
}

std::string describe_usual_columns(const std::vector<ColumnMapping>& columns,
                                   const std::vector<std::string>& header) {
  constexpr std::size_t kLongest = 60;
  std::string text;
  for (ColumnMapping column : columns) {
    const bool is_polar = column.source.ends_with("*pi/180)");
    if (column.source.size() > kLongest) {
      const std::vector<std::string> names = data::Expression::parse(column.source).variables();
      column.source = fmt::format("{}", fmt::join(names, ", "));
    }
    const bool has_comma = column.source.find(',') != std::string::npos;
    const char* const remark = is_polar                         ? " (azimuth and distance)"
                               : column.source.ends_with("/pi") ? " (a circumference)"
                               : column.source.ends_with("*2")  ? " (a radius)"
                                                                : "";
    text += fmt::format("{}{}{}{}{}{}{}",
                        text.empty() ? "" : ", ",
                        column.name,
                        text.empty() ? " is read from column " : " from ",
                        has_comma ? "'" : "",
                        column.source,
                        has_comma ? "'" : "",
                        remark);
  }
  const KnownTable* const known = known_table(header);
  if (text.empty() || known == nullptr) return text;
  return fmt::format("the table is {}: {}", known->title, text);
}

std::vector<ColumnMapping> parse_column_mappings(const std::vector<std::string>& entries) {
  return parse_column_mappings(fmt::format("{}", fmt::join(entries, ",")));
}

std::vector<ColumnMapping> parse_column_mappings(std::string_view text) {
  std::vector<ColumnMapping> mappings;
  if (data::trimmed(text).empty()) return mappings;
  for (const std::string_view part : data::split_at(text, ',')) {
    ColumnMapping mapping = mapping_of(part);
    const bool known = std::ranges::any_of(
        mappings, [&mapping](const ColumnMapping& other) { return other.name == mapping.name; });
    if (known) {
      throw UsageError(fmt::format("'{}' is given twice", mapping.name),
                       {.column = kColumnsOption});
    }
    mappings.push_back(std::move(mapping));
  }
  return mappings;
}

}  // namespace silvafit::stand
