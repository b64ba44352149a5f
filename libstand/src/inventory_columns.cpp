// SPDX-License-Identifier: MIT
#include "inventory_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "fia_columns.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/near_names.hpp"
#include "silvafit/data/column_reference.hpp"
#include "usual_names.hpp"

namespace silvafit::stand {
namespace {

constexpr std::string_view kStatus = "status";

constexpr std::array<KnownColumn, kLabelCount> kLabels{
    {{"plot", "plot"}, {"tree", "tree number"}, {"species", "species"}}};

constexpr std::array<KnownColumn, kMeasureCount> kMeasures{
    {{"x", "position to the east in m"},
     {"y", "position to the north in m"},
     {"z", "elevation in m"},
     {"dbh", "diameter at breast height in cm"},
     {"h", "total height in m"},
     {"hcb", "height to crown base in m"},
     {"cw", "crown width in m"},
     {"cr_e", "crown radius to the east in m"},
     {"cr_w", "crown radius to the west in m"},
     {"cr_s", "crown radius to the south in m"},
     {"cr_n", "crown radius to the north in m"}}};

constexpr std::array<std::vector<double> Inventory::*, kMeasureCount> kMembers{&Inventory::x,
                                                                               &Inventory::y,
                                                                               &Inventory::z,
                                                                               &Inventory::dbh_cm,
                                                                               &Inventory::h_m,
                                                                               &Inventory::hcb_m,
                                                                               &Inventory::cw_m,
                                                                               &Inventory::cr_e_m,
                                                                               &Inventory::cr_w_m,
                                                                               &Inventory::cr_s_m,
                                                                               &Inventory::cr_n_m};

std::string lower(std::string_view text) {
  std::string result(text);
  std::ranges::transform(
      result, result.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

/// The field of a standard column under another usual spelling.
/// \throws UsageError if there are two such fields; of several status columns the first is used
std::optional<std::size_t> usual_field(std::string_view name,
                                       const std::vector<std::string>& header,
                                       const std::string& file) {
  std::optional<std::size_t> found;
  std::optional<std::size_t> other;
  NameFit best = NameFit::kVague;
  for (std::size_t i = 0; i < header.size(); ++i) {
    const std::optional<MeantName> meant = meant_name(header[i]);
    if (!meant || meant->name != name) continue;
    if (found && (meant->fit > best || (meant->fit == best && name == kStatus))) continue;
    other = found && meant->fit == best ? found : std::nullopt;
    found = i;
    best = meant->fit;
  }
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

/// The unit of a column, by its header or by a row of units.
std::optional<LengthUnit> unit_of(std::size_t field,
                                  const std::vector<std::string>& header,
                                  const std::vector<std::string>& units) {
  if (const auto unit = unit_in_header(header[field])) return unit;
  if (field < units.size()) {
    if (const auto unit = unit_of_length(units[field])) return unit;
  }
  return is_fia_tree_table(header) ? unit_of_length(fia_unit(header[field])) : std::nullopt;
}

/// A column, converted to the standard unit if it has another one.
std::string in_our_unit(std::string_view name,
                        const std::string& column,
                        const std::optional<LengthUnit>& unit) {
  constexpr double kCentimeter = 0.01;
  if (!unit || !is_measure(name)) return column;
  const double ours_m = name == kMeasures[kDbh].name ? kCentimeter : 1.0;
  if (unit->meters == ours_m) return column;
  const std::string text = data::Expression::variable(column).text();
  const double divisor = std::round(ours_m / unit->meters);
  const bool is_decimal_part = unit->name != "in" && unit->name != "ft" && divisor > 1.0;
  if (is_decimal_part) return fmt::format("{}/{}", text, divisor);
  return fmt::format("{}*{:.6g}", text, unit->meters / ours_m);
}

/// Builds the plan; an object, because most functions need the header and the file.
class Planner {
 public:
  Planner(const std::vector<std::string>& header,
          const std::vector<std::string>& units,
          const InventoryOptions& options,
          const std::string& file)
      : header_(header),
        units_(units),
        options_(options),
        file_(file),
        fia_(fia_columns(header, options.keeps_measurements || !options.period.empty())) {}

  ColumnPlan plan();

 private:
  std::optional<std::size_t> field_named(std::string_view name) const;
  const ColumnMapping* mapping_to(std::string_view name) const;
  Source source_of(const KnownColumn& column);
  Source guessed(const KnownColumn& column);
  Source mapped(const ColumnMapping& mapping) const;
  Source recognized(const ColumnMapping& mapping);
  void require_column(const ColumnMapping& mapping, const std::optional<std::size_t>& field) const;
  void add_expansion(ColumnPlan& plan) const;
  Source source_in_our_unit(std::string_view name, std::size_t field);
  std::optional<std::size_t> time_field() const;
  std::optional<std::size_t> stand_field(const ColumnPlan& plan) const;
  std::optional<std::size_t> status_field();
  std::vector<std::size_t> filled_down(const ColumnPlan& plan) const;
  void require(const Source& source, const KnownColumn& column) const;
  void require_needed(const ColumnPlan& plan) const;
  void collect_expression_fields(ColumnPlan& plan) const;
  void refuse_unread(const std::string& name) const;
  void collect_others(ColumnPlan& plan) const;
  bool is_used(const ColumnPlan& plan, std::string_view name) const;

  const std::vector<std::string>& header_;
  const std::vector<std::string>& units_;
  const InventoryOptions& options_;
  const std::string& file_;
  std::vector<ColumnMapping> fia_;
  std::vector<ColumnMapping> usual_{};
};

const ColumnMapping* mapping_named(std::string_view name,
                                   const std::vector<ColumnMapping>& mappings) {
  const auto found = std::ranges::find(mappings, name, &ColumnMapping::name);
  return found == mappings.end() ? nullptr : &*found;
}

bool is_label_name(std::string_view name) {
  return std::ranges::find(kLabels, name, &KnownColumn::name) != kLabels.end();
}

/// Whether FIA's columns are used for a standard column: `plot` in lower case is FIA's PLOT, which
/// is unique within a county only.
bool is_fia_preferred(std::string_view name, const std::vector<std::string>& header) {
  return is_label_name(name) || std::ranges::find(header, name) == header.end();
}

std::optional<std::size_t> field_in_any_case(std::string_view name,
                                             const std::vector<std::string>& header) {
  const auto found = std::ranges::find(header, name, &lower);
  if (found == header.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header.begin());
}

std::optional<std::size_t> Planner::field_named(std::string_view name) const {
  const auto found = std::ranges::find(header_, name);
  if (found == header_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header_.begin());
}

const ColumnMapping* Planner::mapping_to(std::string_view name) const {
  return mapping_named(name, options_.columns);
}

Source Planner::mapped(const ColumnMapping& mapping) const {
  const std::vector<std::string> parts = is_label_name(mapping.name)
                                             ? joined_columns(mapping.source, header_)
                                             : std::vector<std::string>();
  if (!parts.empty()) {
    Source source{.text = mapping.source};
    for (const std::string& part : parts) source.joined.push_back(*field_named(part));
    return source;
  }
  data::ColumnReference reference =
      data::column_reference(mapping.name, mapping.source, header_, file_);
  Source source{.text = std::move(reference.text), .expression = std::move(reference.expression)};
  if (!source.expression) source.field = field_named(source.text);
  return source;
}

/// A field of the file, converted if its header or the row of units names a nonstandard unit.
Source Planner::source_in_our_unit(std::string_view name, std::size_t field) {
  const std::string text = in_our_unit(name, header_[field], unit_of(field, header_, units_));
  const bool is_ours = text == name;
  if (!is_ours) usual_.push_back({std::string(name), text});
  if (text == header_[field]) return {.text = text, .field = field};
  return {.text = text, .expression = data::Expression::parse(text)};
}

/// A column of FIA.
Source Planner::recognized(const ColumnMapping& mapping) {
  if (const auto field = field_named(mapping.source)) {
    return source_in_our_unit(mapping.name, *field);
  }
  usual_.push_back(mapping);
  return mapped(mapping);
}

Source Planner::guessed(const KnownColumn& column) {
  const ColumnMapping* const fia = mapping_named(column.name, fia_);
  if (fia != nullptr && is_fia_preferred(column.name, header_)) return recognized(*fia);
  std::optional<std::size_t> field = field_named(column.name);
  if (!field) field = usual_field(column.name, header_, file_);
  return field ? source_in_our_unit(column.name, *field) : Source{};
}

Source Planner::source_of(const KnownColumn& column) {
  const ColumnMapping* const mapping = mapping_to(column.name);
  if (mapping == nullptr) return guessed(column);
  const auto field = field_named(mapping->source);
  const bool is_converted =
      field && in_our_unit(column.name, header_[*field], unit_of(*field, header_, units_)) !=
                   header_[*field];
  return is_converted ? source_in_our_unit(column.name, *field) : mapped(*mapping);
}

/// Times and statuses are columns, because expressions make numbers.
void Planner::require_column(const ColumnMapping& mapping,
                             const std::optional<std::size_t>& field) const {
  if (field) return;
  const std::string remedy =
      mapping.name == kStatus
          ? "name the column and explain its values, such as `columns=status=COLUMN` and "
            "`dead_codes=DS`"
          : fmt::format("name the column: `columns={}=COLUMN`", mapping.name);
  throw UsageError(fmt::format("{} must be a column, not the expression '{}'; {}; available: {}",
                               mapping.name,
                               mapping.source,
                               remedy,
                               data::list_of(header_)),
                   {.file = file_, .column = "`columns`"});
}

/// Field of the column year, else date, or of the source mapped to such a name.
std::optional<std::size_t> Planner::time_field() const {
  if (!options_.period.empty()) {
    if (const auto field = field_named(options_.period)) return field;
    throw InputError(data::no_such_column(options_.period, header_),
                     {.file = file_, .column = "`period`"});
  }
  for (const std::string_view name : {"year", "date"}) {
    if (const ColumnMapping* const mapping = mapping_to(name)) {
      const auto field = field_named(mapping->source);
      require_column(*mapping, field);
      return field;
    }
    if (const auto field = field_in_any_case(name, header_)) return field;
  }
  const ColumnMapping* const fia = mapping_named("year", fia_);
  return fia == nullptr ? std::nullopt : field_named(fia->source);
}

/// Field of the column stand, unless it is read as a standard label.
std::optional<std::size_t> Planner::stand_field(const ColumnPlan& plan) const {
  if (const ColumnMapping* const mapping = mapping_to("stand")) {
    const auto field = field_named(mapping->source);
    require_column(*mapping, field);
    return field;
  }
  for (std::size_t i = 0; i < header_.size(); ++i) {
    const auto holds = [i](const Source& source) { return source.field == i; };
    if (lower(header_[i]) == "stand" && std::ranges::none_of(plan.labels, holds)) return i;
  }
  return std::nullopt;
}

/// Field of the status column (alive, dead, cut).
std::optional<std::size_t> Planner::status_field() {
  std::optional<std::size_t> field;
  if (const ColumnMapping* const mapping = mapping_to(kStatus)) {
    field = field_named(mapping->source);
    require_column(*mapping, field);
  } else {
    field = usual_field(kStatus, header_, file_);
  }
  if (!field && !options_.status_codes.empty()) {
    throw UsageError(
        fmt::format("no column of the status was found; name it with `columns=status=COLUMN`; "
                    "available: {}",
                    data::list_of(header_)),
        {.file = file_, .column = "`dead_codes`"});
  }
  return field;
}

/// FIA's factors become a column per hectare.
void Planner::add_expansion(ColumnPlan& plan) const {
  constexpr char kName[] = "trees_per_ha";
  const ColumnMapping* const factor = mapping_named("expansion", fia_);
  if (factor == nullptr || field_named(kName) || mapping_to(kName) != nullptr) return;
  plan.expansion = kName;
  if (options_.keeps_expansion) plan.others.push_back({.name = kName, .source = factor->source});
}

/// The fields of --fill-down, by their standard names or the names in the file.
std::vector<std::size_t> Planner::filled_down(const ColumnPlan& plan) const {
  std::vector<std::size_t> fields;
  for (const std::string& name : options_.fill_down) {
    const auto label = std::ranges::find(kLabels, name, &KnownColumn::name);
    std::optional<std::size_t> field = field_named(name);
    if (!field && label != kLabels.end()) {
      field = plan.labels[static_cast<std::size_t>(label - kLabels.begin())].field;
    }
    if (!field) throw UsageError(data::no_such_column(name, header_), {.column = "`fill_down`"});
    fields.push_back(*field);
  }
  return fields;
}

void Planner::require(const Source& source, const KnownColumn& column) const {
  if (source.exists()) return;
  throw InputError(
      fmt::format("no column {} ({}) was found; name it with `columns={}=COLUMN`; available: {}",
                  column.name,
                  column.meaning,
                  column.name,
                  data::list_of(header_)),
      {.file = file_});
}

void Planner::require_needed(const ColumnPlan& plan) const {
  require(plan.measures[kDbh], kMeasures[kDbh]);
  if (options_.needs_coordinates) {
    require(plan.measures[kX], kMeasures[kX]);
    require(plan.measures[kY], kMeasures[kY]);
  }
  for (const std::string& name : options_.needs) {
    const auto measure = std::ranges::find(kMeasures, name, &KnownColumn::name);
    if (measure == kMeasures.end()) {
      throw UsageError(fmt::format("'{}' is not a column of an inventory", name));
    }
    const bool has_radii = std::ranges::all_of(
        kRadii, [&plan](Measure radius) { return plan.measures[radius].exists(); });
    if (name == "cw" && has_radii) continue;
    require(plan.measures[static_cast<std::size_t>(measure - kMeasures.begin())], *measure);
  }
}

void Planner::collect_expression_fields(ColumnPlan& plan) const {
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const Source& source = plan.measures[i];
    if (!source.expression) continue;
    const bool is_position = i == kX || i == kY || i == kZ;
    for (const std::string& variable : source.expression->variables()) {
      data::TextMatch match;
      const bool is_text = data::is_text_match(variable, match);
      const std::string& name = is_text ? match.column : variable;
      const auto same = [&](const ExpressionField& field) { return field.name == name; };
      const auto found = std::ranges::find_if(plan.expression_fields, same);
      if (found == plan.expression_fields.end()) {
        plan.expression_fields.push_back({.name = name,
                                          .field = *field_named(name),
                                          .is_text = is_text,
                                          .is_position = is_position});
      } else if (found->is_text != is_text) {
        throw UsageError(fmt::format("'{}' is used as a number and as text", name),
                         {.file = file_, .column = "`columns`"});
      }
    }
  }
}

/// Whether a column of the file is already used as a standard column.
bool Planner::is_used(const ColumnPlan& plan, std::string_view name) const {
  const auto holds = [name](const Source& source) { return source.field && source.text == name; };
  return std::ranges::any_of(plan.labels, holds) || std::ranges::any_of(plan.measures, holds);
}

/// A name that nothing reads is a misspelt one.
void Planner::refuse_unread(const std::string& name) const {
  std::vector<std::string> read{std::string(kStatus), "year", "date", "stand"};
  for (const KnownColumn& column : kLabels) read.emplace_back(column.name);
  for (const KnownColumn& column : kMeasures) read.emplace_back(column.name);
  read.insert(read.end(), options_.keep.begin(), options_.keep.end());
  if (std::ranges::find(read, name) != read.end()) return;
  throw UsageError(
      fmt::format("nothing reads a column '{}' here{}", name, did_you_mean(name, read)),
      {.column = "`columns`"});
}

void Planner::collect_others(ColumnPlan& plan) const {
  const auto is_ours = [](std::string_view name) {
    return std::ranges::find(kLabels, name, &KnownColumn::name) != kLabels.end() ||
           std::ranges::find(kMeasures, name, &KnownColumn::name) != kMeasures.end();
  };
  for (const ColumnMapping& mapping : options_.columns) {
    if (is_ours(mapping.name)) continue;
    if (options_.refuses_unread) refuse_unread(mapping.name);
    mapped(mapping);  // reports missing columns at once
    plan.others.push_back(mapping);
  }
  for (const std::string& name : options_.keep_all ? header_ : options_.keep) {
    const bool is_taken =
        std::ranges::find(plan.others, name, &ColumnMapping::name) != plan.others.end();
    if (name.empty() || is_taken || is_ours(name) || (options_.keep_all && is_used(plan, name)))
      continue;
    if (!field_named(name)) {
      throw InputError(data::no_such_column(name, header_), {.file = file_});
    }
    plan.others.push_back({.name = name, .source = name});
  }
}

ColumnPlan Planner::plan() {
  ColumnPlan plan;
  for (std::size_t i = 0; i < kLabelCount; ++i) {
    plan.labels[i] = source_of(kLabels[i]);
    if (plan.labels[i].expression) {
      throw UsageError(fmt::format("{} must be a column, or columns joined as in SUBP+TREE, not "
                                   "'{}'; available: {}",
                                   kLabels[i].name,
                                   plan.labels[i].text,
                                   data::list_of(header_)),
                       {.file = file_, .column = "`columns`"});
    }
  }
  for (std::size_t i = 0; i < kMeasureCount; ++i) plan.measures[i] = source_of(kMeasures[i]);
  plan.time_field = time_field();
  plan.stand_field = stand_field(plan);
  plan.status_field = status_field();
  plan.filled_down = filled_down(plan);
  require_needed(plan);
  collect_expression_fields(plan);
  collect_others(plan);
  add_expansion(plan);
  const ColumnMapping* const place = mapping_named("x", fia_);
  plan.is_placed_by_subplots = place != nullptr && plan.measures[kX].text == place->source;
  plan.usual = std::move(usual_);
  return plan;
}

}  // namespace

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

std::vector<ColumnMapping> usual_columns(const std::vector<std::string>& header,
                                         const std::function<bool(const std::string&)>& is_wanted,
                                         const std::string& file,
                                         const std::vector<std::string>& units) {
  std::vector<ColumnMapping> found;
  const std::vector<ColumnMapping> fia_table = fia_columns(header, false);
  const auto look = [&](const KnownColumn& column) {
    std::string name(column.name);
    if (!is_wanted(name)) return;
    const ColumnMapping* const fia = mapping_named(name, fia_table);
    if (fia != nullptr && is_fia_preferred(name, header)) {
      found.push_back(in_our_unit(*fia, header, units));
      return;
    }
    const auto own = std::ranges::find(header, name);
    const auto field = own == header.end() ? usual_field(name, header, file)
                                           : static_cast<std::size_t>(own - header.begin());
    if (!field) return;
    std::string source = in_our_unit(name, header[*field], unit_of(*field, header, units));
    if (source != name) found.push_back({std::move(name), std::move(source)});
  };
  std::ranges::for_each(kLabels, look);
  std::ranges::for_each(kMeasures, look);
  return found;
}

ColumnMapping in_our_unit(ColumnMapping mapping,
                          const std::vector<std::string>& header,
                          const std::vector<std::string>& units) {
  const auto field = std::ranges::find(header, mapping.source);
  if (field == header.end()) return mapping;
  const auto index = static_cast<std::size_t>(field - header.begin());
  mapping.source = in_our_unit(mapping.name, mapping.source, unit_of(index, header, units));
  return mapping;
}

std::optional<std::string> usual_time_column(const std::vector<std::string>& header) {
  for (const std::string_view name : {"year", "date"}) {
    if (const auto field = field_in_any_case(name, header)) return header[*field];
  }
  const std::vector<ColumnMapping> fia_table = fia_columns(header, false);
  const ColumnMapping* const fia = mapping_named("year", fia_table);
  return fia == nullptr ? std::nullopt : std::optional(fia->source);
}

std::optional<std::string> usual_status_column(const std::vector<std::string>& header) {
  const auto field = usual_field(kStatus, header, {});
  return field ? std::optional(header[*field]) : std::nullopt;
}

bool is_measure(std::string_view name) {
  return std::ranges::find(kMeasures, name, &KnownColumn::name) != kMeasures.end();
}

std::string describe_usual_columns(const std::vector<ColumnMapping>& columns,
                                   const std::vector<std::string>& header) {
  constexpr std::size_t kLongest = 60;
  std::string text;
  for (ColumnMapping column : columns) {
    if (column.source.size() > kLongest) {
      const std::vector<std::string> names = data::Expression::parse(column.source).variables();
      column.source = fmt::format("{}", fmt::join(names, ", "));
    }
    const bool has_comma = column.source.find(',') != std::string::npos;
    text += fmt::format("{}{}{}{}{}{}",
                        text.empty() ? "" : ", ",
                        column.name,
                        text.empty() ? " is read from column " : " from ",
                        has_comma ? "'" : "",
                        column.source,
                        has_comma ? "'" : "");
  }
  if (text.empty() || !is_fia_tree_table(header)) return text;
  return "the table is FIA's TREE, in inches and feet: " + text;
}

const KnownColumn& known_label(std::size_t label) { return kLabels[label]; }
const KnownColumn& known_measure(std::size_t measure) { return kMeasures[measure]; }

std::vector<double>& values_of(Inventory& inventory, std::size_t measure) {
  return inventory.*kMembers[measure];
}

const std::vector<double>& values_of(const Inventory& inventory, std::size_t measure) {
  return inventory.*kMembers[measure];
}

ColumnPlan plan_columns(const std::vector<std::string>& header,
                        const std::vector<std::string>& units,
                        const InventoryOptions& options,
                        const std::string& file) {
  return Planner(header, units, options, file).plan();
}

}  // namespace silvafit::stand
