// SPDX-License-Identifier: MIT
#include "trees/inventory_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/near_names.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/stand/described_columns.hpp"
#include "silvafit/stand/prepared_table.hpp"
#include "silvafit/stand/unread_columns.hpp"
#include "trees/column_sources.hpp"
#include "trees/folded_text.hpp"
#include "trees/known_tables.hpp"
#include "trees/usual_names.hpp"

namespace silvafit::stand {
namespace {

/// Builds the plan; an object, because most functions need the header and the file.
class Planner {
 public:
  Planner(const std::vector<std::string>& header,
          const std::vector<std::string>& units,
          const InventoryOptions& options,
          const std::string& file)
      : header_(header), units_(units), options_(options), file_(file) {}

  ColumnPlan plan();

 private:
  std::optional<std::size_t> field_named(std::string_view name) const {
    return stand::field_named(name, header_);
  }
  std::optional<std::size_t> mapped_field(std::string_view name) const;
  Source source_of(const std::string& name);
  Source mapped(const ColumnMapping& mapping) const;
  void add_expansion(ColumnPlan& plan) const;
  std::optional<std::size_t> time_field() const;
  std::optional<std::size_t> tally_field(const ColumnPlan& plan) const;
  std::optional<std::size_t> factor_field(const ColumnPlan& plan) const;
  std::vector<std::size_t> location_of_visits(const ColumnPlan& plan,
                                              const std::vector<ColumnMapping>& known) const;
  std::vector<std::size_t> unit_fields(const ColumnPlan& plan) const;
  void require(const ColumnPlan& plan, Measure measure) const;
  void require_needed(const ColumnPlan& plan) const;
  std::optional<std::size_t> genus_field(const ColumnPlan& plan) const;
  std::vector<std::size_t> unread_fields(const ColumnPlan& plan) const;
  void collect_expression_fields(ColumnPlan& plan) const;
  void refuse_unread(const std::string& name) const;
  void collect_others(ColumnPlan& plan) const;
  bool is_used(const ColumnPlan& plan, std::string_view name) const;

  const std::vector<std::string>& header_;
  const std::vector<std::string>& units_;
  const InventoryOptions& options_;
  const std::string& file_;
  std::vector<ColumnMapping> found_{};  ///< usual_columns()
  std::vector<ColumnMapping> usual_{};
};

constexpr std::string_view kTrees =
    "trees arboles arvores arbres pies baume individuals individuos plants treecount stammzahl "
    "baumzahl stamantal";
constexpr std::string_view kStems = "stems tiges stamme stemcount";

/// Whether a name says that it counts trees or stems: `trees`, `num_stems`, `No. of trees`.
bool is_count_of(std::string_view things, std::string_view letters) {
  constexpr std::string_view kCounts =
      "n no nr nb num number nombre numero qty quantity cantidad antal antall anzahl";
  if (has_word(things, letters)) return true;
  for (std::size_t length = letters.size(); length-- > 1;) {
    std::string_view rest = letters.substr(length);
    if (!has_word(kCounts, letters.substr(0, length))) continue;
    for (const std::string_view joint : {"of", "de"}) {
      if (rest.starts_with(joint)) rest.remove_prefix(joint.size());
    }
    if (has_word(things, rest)) return true;
  }
  return false;
}

/// Field of the column that is mapped to a name; none if there is no such mapping.
std::optional<std::size_t> Planner::mapped_field(std::string_view name) const {
  const ColumnMapping* const mapping = mapping_to(name, options_.columns);
  if (mapping == nullptr || is_no_column(*mapping, header_)) return std::nullopt;
  require_column(*mapping, header_, file_);
  return field_named(mapping->source);
}

Source Planner::mapped(const ColumnMapping& mapping) const {
  const std::vector<std::string> parts =
      is_label(mapping.name) ? joined_columns(mapping.source, header_) : std::vector<std::string>();
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

/// As mapped, or as found; a measure in our unit.
Source Planner::source_of(const std::string& name) {
  if (const ColumnMapping* const mapping = mapping_to(name, options_.columns)) {
    if (is_no_column(*mapping, header_)) return {};
    ColumnMapping ours = in_our_unit(*mapping, header_, units_);
    if (ours.source != mapping->source) usual_.push_back(ours);
    return mapped(ours);
  }
  if (const ColumnMapping* const found = mapping_to(name, found_)) {
    usual_.push_back(*found);
    return mapped(*found);
  }
  return field_named(name) ? mapped({.name = name, .source = name}) : Source{};
}

/// Field of the column year, else date, or of the source mapped to such a name.
std::optional<std::size_t> Planner::time_field() const {
  if (!options_.period.empty()) {
    if (const auto field = field_named(options_.period)) return field;
    throw InputError(data::no_such_column(options_.period, header_),
                     {.file = file_, .column = "`period`"});
  }
  for (const std::string_view name : {"year", "date"}) {
    if (mapping_to(name, options_.columns) != nullptr) return mapped_field(name);
  }
  const auto column = usual_time_column(header_);
  return column ? field_named(*column) : std::nullopt;
}

/// Fields of stands and other units of several plots, but those that are read as standard labels.
std::vector<std::size_t> Planner::unit_fields(const ColumnPlan& plan) const {
  if (const auto field = mapped_field("stand")) return {*field};
  std::vector<std::size_t> fields = fields_of_units(header_);
  std::erase_if(fields, [&plan](std::size_t field) {
    return std::ranges::any_of(plan.labels, [field](const Source& source) {
      return source.field == field ||
             std::ranges::find(source.joined, field) != source.joined.end();
    });
  });
  return fields;
}

/// The factors of a known table become a column per hectare.
void Planner::add_expansion(ColumnPlan& plan) const {
  constexpr char kName[] = "trees_per_ha";
  const std::vector<ColumnMapping> known = known_columns(header_, true);
  const ColumnMapping* const factor = mapping_to(kName, known);
  const bool is_taken = field_named(kName) || mapping_to(kName, options_.columns) != nullptr;
  if (factor == nullptr || is_taken) return;
  plan.expansion = kName;
  if (options_.keeps_expansion) plan.others.push_back({.name = kName, .source = factor->source});
}

void Planner::require(const ColumnPlan& plan, Measure measure) const {
  if (plan.measures[measure].exists()) return;
  throw InputError(no_standard_column(known_measure(measure), header_), {.file = file_});
}

void Planner::require_needed(const ColumnPlan& plan) const {
  require(plan, kDbh);
  if (options_.needs_coordinates) {
    require(plan, kX);
    require(plan, kY);
  }
  for (const std::string& name : options_.needs) {
    if (!is_measure(name)) {
      throw UsageError(fmt::format("'{}' is not a column of an inventory", name));
    }
    const bool has_radii = std::ranges::all_of(
        kRadii, [&plan](Measure radius) { return plan.measures[radius].exists(); });
    if (name == "cw" && has_radii) continue;
    require(plan, measure_named(name));
  }
}

/// Epithets alone do not name species: `glabra` is of many genera.
std::optional<std::size_t> Planner::genus_field(const ColumnPlan& plan) const {
  constexpr std::string_view kNames = "genus gattung genre genero gen genusname 属 屬";
  if (!plan.labels[kSpecies].field) return std::nullopt;
  for (std::size_t field = 0; field < header_.size(); ++field) {
    const std::string letters = folded_letters(header_[field]);
    const bool is_genus = !letters.empty() && has_word(kNames, letters);
    if (is_genus && field != *plan.labels[kSpecies].field) return field;
  }
  return std::nullopt;
}

void Planner::collect_expression_fields(ColumnPlan& plan) const {
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const Source& source = plan.measures[i];
    if (!source.expression) continue;
    const bool is_position = known_measure(i).is_position();
    for (const std::string& variable : source.expression->variables()) {
      const std::string name = data::column_of(variable);
      const bool is_text = name != variable;
      const auto same = [&](const ExpressionField& field) { return field.name == name; };
      const auto found = std::ranges::find_if(plan.expression_fields, same);
      if (found == plan.expression_fields.end()) {
        plan.expression_fields.push_back(
            {.name = name,
             .field = *field_named(name),
             .is_text = is_text,
             .is_position = is_position,
             .polar = is_position
                          ? polar_column(name, source.text, header_, units_, options_.columns)
                          : PolarColumn()});
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
  std::vector<std::string> read{"year", "date", "stand"};
  for (const TreeColumn& column : tree_columns()) read.emplace_back(column.name);
  read.insert(read.end(), options_.keep.begin(), options_.keep.end());
  if (std::ranges::find(read, name) != read.end()) return;
  throw UsageError(
      fmt::format("nothing reads a column '{}' here{}", name, did_you_mean(name, read)),
      {.column = "`columns`"});
}

void Planner::collect_others(ColumnPlan& plan) const {
  const auto is_ours = [](std::string_view name) {
    const TreeColumn* const column = tree_column(name);
    return column != nullptr && name != "status";
  };
  for (const ColumnMapping& mapping : options_.columns) {
    if (is_ours(mapping.name) || is_no_column(mapping, header_)) continue;
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

/// Empty if the plots are not the visits of a known table.
std::vector<std::size_t> Planner::location_of_visits(
    const ColumnPlan& plan, const std::vector<ColumnMapping>& known) const {
  std::vector<std::size_t> fields;
  const ColumnMapping* const visit = mapping_to("plot", known);
  const std::vector<ColumnMapping> by_location = known_columns(header_, true);
  const ColumnMapping* const location = mapping_to("plot", by_location);
  if (visit == nullptr || location == nullptr || visit->source == location->source) return fields;
  if (plan.labels[kPlot].text != visit->source) return fields;
  for (const std::string& column : joined_columns(location->source, header_)) {
    fields.push_back(*field_named(column));
  }
  return fields;
}

/// The column of a tally, which has a row for each class of trees and their number. Trees with
/// numbers and positions are no classes.
std::optional<std::size_t> Planner::tally_field(const ColumnPlan& plan) const {
  constexpr std::string_view kNames =
      "n nst count counts frequency freq tally anzahl nombre "
      "stuckzahl stuck stuckz effectif cantidad abundance abundancia "
      "quantidade kpl runkoluku lukumaara antal liczba pocet aantal adet 株数 株數 本数 "
      "nb number qty quantity qtde qtd stk antall multiplicity";
  const bool are_placed = plan.measures[kX].exists() && plan.measures[kY].exists();
  const bool is_of_trees = plan.labels[kTree].exists() && are_placed;
  if (is_of_trees || options_.trust_units || options_.has_expansion) return std::nullopt;
  for (std::size_t field = 0; field < header_.size(); ++field) {
    const std::string letters = folded_letters(header_[field]);
    const bool is_tally =
        !letters.empty() &&
        (has_word(kNames, letters) || is_count_of(kTrees, letters) || is_count_of(kStems, letters));
    if (is_tally && !is_used(plan, header_[field])) return field;
  }
  return std::nullopt;
}

/// A column of expansion factors that is not used.
std::optional<std::size_t> Planner::factor_field(const ColumnPlan& plan) const {
  if (options_.trust_units || options_.has_expansion || !plan.expansion.empty()) {
    return std::nullopt;
  }
  for (std::size_t field = 0; field < header_.size(); ++field) {
    if (is_expansion_name(header_[field]) && !is_used(plan, header_[field])) return field;
  }
  return std::nullopt;
}

/// Fields that nothing reads. Columns that are only kept for models are among them.
std::vector<std::size_t> Planner::unread_fields(const ColumnPlan& plan) const {
  std::vector<char> is_read(header_.size(), 0);
  const auto note = [&is_read](const std::optional<std::size_t>& field) {
    if (field) is_read[*field] = 1;
  };
  const auto note_all = [&is_read](const std::vector<std::size_t>& fields) {
    for (const std::size_t field : fields) is_read[field] = 1;
  };
  for (const Source& label : plan.labels) {
    note(label.field);
    note_all(label.joined);
  }
  for (const Source& measure : plan.measures) note(measure.field);
  for (const ExpressionField& used : plan.expression_fields) is_read[used.field] = 1;
  for (const auto& field : {plan.time_field,
                            plan.status_field,
                            plan.tally_field,
                            plan.factor_field,
                            plan.genus_field}) {
    note(field);
  }
  note_all(plan.stem_fields);
  note_all(plan.unit_fields);
  note_all(plan.location);
  std::vector<std::size_t> fields;
  for (std::size_t field = 0; field < header_.size(); ++field) {
    if (is_read[field] == 0 && !header_[field].empty()) fields.push_back(field);
  }
  return fields;
}

ColumnPlan Planner::plan() {
  ColumnPlan plan;
  const auto is_looked_for = [this](const std::string& name) {
    return mapping_to(name, options_.columns) == nullptr;
  };
  const bool by_location = options_.keeps_measurements || !options_.period.empty();
  found_ = usual_columns(header_, is_looked_for, file_, units_, by_location, options_.columns);
  for (std::size_t i = 0; i < kLabelCount; ++i) {
    const std::string name(known_label(i).name);
    plan.labels[i] = source_of(name);
    if (plan.labels[i].expression) {
      throw UsageError(fmt::format("{} must be a column, or columns joined as in SUBP+TREE, not "
                                   "'{}'; available: {}",
                                   name,
                                   plan.labels[i].text,
                                   data::list_of(header_)),
                       {.file = file_, .column = "`columns`"});
    }
  }
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    plan.measures[i] = source_of(std::string(known_measure(i).name));
  }
  plan.time_field = time_field();
  const auto subplot = options_.subplot.empty() ? std::nullopt : field_named(options_.subplot);
  if (subplot) plan.stem_fields.push_back(*subplot);
  if (const auto stem = usual_stem_column(header_)) {
    plan.stem_fields.push_back(*field_named(*stem));
  }
  plan.unit_fields = unit_fields(plan);
  const auto status =
      status_column(header_, options_.columns, options_.status_codes, options_.dead, file_);
  if (status) plan.status_field = field_named(*status);
  plan.filled_down = filled_fields(options_, header_, file_);
  require_needed(plan);
  collect_expression_fields(plan);
  collect_others(plan);
  add_expansion(plan);
  // Positions from subplots are made of their numbers.
  const std::vector<ColumnMapping> known = known_columns(header_, by_location);
  const ColumnMapping* const place = mapping_to("x", known);
  plan.is_placed_by_subplots = place != nullptr && plan.measures[kX].text == place->source &&
                               place->source.find("ifelse") != std::string::npos;
  plan.location = location_of_visits(plan, known);
  plan.tally_field = tally_field(plan);
  plan.tally_counts_trees =
      plan.tally_field && is_count_of(kTrees, folded_letters(header_[*plan.tally_field]));
  plan.factor_field = factor_field(plan);
  plan.genus_field = genus_field(plan);
  plan.unread = unread_fields(plan);
  const ColumnMapping* const azimuth = mapping_to("azimuth", options_.columns);
  const bool is_read = plan.measures[kX].expression && azimuth != nullptr;
  if (is_read) plan.azimuth = mapped(*azimuth).expression;
  plan.usual = std::move(usual_);
  return plan;
}

}  // namespace

Measure measure_named(std::string_view name) {
  return static_cast<Measure>(tree_column(name) - tree_columns().data() - kLabelCount);
}

ColumnPlan plan_columns(const std::vector<std::string>& header,
                        const std::vector<std::string>& units,
                        const InventoryOptions& options,
                        const std::string& file) {
  return Planner(header, units, options, file).plan();
}

}  // namespace silvafit::stand
