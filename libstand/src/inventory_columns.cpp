// SPDX-License-Identifier: MIT
#include "inventory_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/data/column_reference.hpp"

namespace silvafit::stand {
namespace {

constexpr std::array<KnownColumn, kLabelCount> kLabels{
    {{"plot", "plot", {"plot_id", "plotid"}},
     {"tree", "tree number", {"tree_id", "treeid"}},
     {"species", "species", {"species_code", "spp"}}}};

constexpr std::array<KnownColumn, kMeasureCount> kMeasures{
    {{"x", "position to the east in m", {"x_m", ""}},
     {"y", "position to the north in m", {"y_m", ""}},
     {"z", "elevation in m", {"z_m", ""}},
     {"dbh", "diameter at breast height in cm", {"dbh_cm", ""}},
     {"h", "total height in m", {"h_m", "height"}},
     {"hcb", "height to crown base in m", {"hcb_m", ""}},
     {"cw", "crown width in m", {"cw_m", ""}},
     {"cr_e", "crown radius to the east in m", {"cr_e_m", ""}},
     {"cr_w", "crown radius to the west in m", {"cr_w_m", ""}},
     {"cr_s", "crown radius to the south in m", {"cr_s_m", ""}},
     {"cr_n", "crown radius to the north in m", {"cr_n_m", ""}}}};

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

/// The field that holds one of our columns under another usual spelling.
/// \throws UsageError if two fields could
std::optional<std::size_t> usual_field(const KnownColumn& column,
                                       const std::vector<std::string>& header,
                                       const std::string& file) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < header.size(); ++i) {
    const std::string name = lower(header[i]);
    if (name.empty()) continue;
    const bool is_usual =
        name == column.name || name == column.spellings[0] || name == column.spellings[1];
    if (!is_usual) continue;
    if (found) {
      throw UsageError(fmt::format("'{}' and '{}' could both be {}; name one with --columns {}={}",
                                   header[*found],
                                   header[i],
                                   column.name,
                                   column.name,
                                   header[*found]),
                       {.file = file});
    }
    found = i;
  }
  return found;
}

/// Builds the plan; one object so that header and file need not be handed around.
class Planner {
 public:
  Planner(const std::vector<std::string>& header,
          const InventoryOptions& options,
          const std::string& file)
      : header_(header), options_(options), file_(file) {}

  ColumnPlan plan();

 private:
  std::optional<std::size_t> field_named(std::string_view name) const;
  const ColumnMapping* mapping_to(std::string_view name) const;
  Source source_of(const KnownColumn& column);
  Source guessed(const KnownColumn& column);
  Source mapped(const ColumnMapping& mapping) const;
  std::optional<std::size_t> time_field() const;
  std::optional<std::size_t> stand_field(const ColumnPlan& plan) const;
  void require(const Source& source, const KnownColumn& column) const;
  void require_needed(const ColumnPlan& plan) const;
  void collect_expression_fields(ColumnPlan& plan) const;
  void collect_others(ColumnPlan& plan) const;
  bool is_used(const ColumnPlan& plan, std::string_view name) const;

  const std::vector<std::string>& header_;
  const InventoryOptions& options_;
  const std::string& file_;
  std::vector<std::string> notes_{};
};

std::optional<std::size_t> Planner::field_named(std::string_view name) const {
  const auto found = std::ranges::find(header_, name);
  if (found == header_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header_.begin());
}

const ColumnMapping* Planner::mapping_to(std::string_view name) const {
  const auto found = std::ranges::find(options_.columns, name, &ColumnMapping::name);
  return found == options_.columns.end() ? nullptr : &*found;
}

Source Planner::mapped(const ColumnMapping& mapping) const {
  data::ColumnReference reference =
      data::column_reference(mapping.name, mapping.source, header_, file_);
  Source source{.text = std::move(reference.text), .expression = std::move(reference.expression)};
  if (!source.expression) source.field = field_named(source.text);
  return source;
}

Source Planner::guessed(const KnownColumn& column) {
  if (const auto field = field_named(column.name)) {
    return {.text = std::string(column.name), .field = field};
  }
  const auto field = usual_field(column, header_, file_);
  if (!field) return {};
  notes_.push_back(describe_usual_column({std::string(column.name), header_[*field]}));
  return {.text = header_[*field], .field = field};
}

Source Planner::source_of(const KnownColumn& column) {
  if (const ColumnMapping* const mapping = mapping_to(column.name)) return mapped(*mapping);
  return guessed(column);
}

/// Of the column year, else date, or of what is mapped to such a name.
std::optional<std::size_t> Planner::time_field() const {
  for (const std::string_view name : {"year", "date"}) {
    if (const ColumnMapping* const mapping = mapping_to(name)) return field_named(mapping->source);
    for (std::size_t i = 0; i < header_.size(); ++i) {
      if (lower(header_[i]) == name) return i;
    }
  }
  return std::nullopt;
}

/// Of the column stand, unless it is one of our labels.
std::optional<std::size_t> Planner::stand_field(const ColumnPlan& plan) const {
  for (std::size_t i = 0; i < header_.size(); ++i) {
    const auto holds = [i](const Source& source) { return source.field == i; };
    if (lower(header_[i]) == "stand" && std::ranges::none_of(plan.labels, holds)) return i;
  }
  return std::nullopt;
}

void Planner::require(const Source& source, const KnownColumn& column) const {
  if (source.exists()) return;
  throw InputError(
      fmt::format("there is no column {} ({}); name yours with --columns {}=COLUMN; the columns "
                  "are {}",
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
      throw UsageError(fmt::format("'{}' is no measure of an inventory", name));
    }
    const bool has_radii = std::ranges::all_of(
        kRadii, [&plan](Measure radius) { return plan.measures[radius].exists(); });
    if (name == "cw" && has_radii) continue;
    require(plan.measures[static_cast<std::size_t>(measure - kMeasures.begin())], *measure);
  }
}

void Planner::collect_expression_fields(ColumnPlan& plan) const {
  for (const Source& source : plan.measures) {
    if (!source.expression) continue;
    for (const std::string& variable : source.expression->variables()) {
      data::TextMatch match;
      const bool is_text = data::is_text_match(variable, match);
      const std::string& name = is_text ? match.column : variable;
      const auto same = [&](const ExpressionField& field) { return field.name == name; };
      const auto found = std::ranges::find_if(plan.expression_fields, same);
      if (found == plan.expression_fields.end()) {
        plan.expression_fields.push_back(
            {.name = name, .field = *field_named(name), .is_text = is_text});
      } else if (found->is_text != is_text) {
        throw UsageError(fmt::format("'{}' is used as a number and as text", name),
                         {.file = file_, .column = "--columns"});
      }
    }
  }
}

/// Whether a column of the file already is one of ours.
bool Planner::is_used(const ColumnPlan& plan, std::string_view name) const {
  const auto holds = [name](const Source& source) { return source.field && source.text == name; };
  return std::ranges::any_of(plan.labels, holds) || std::ranges::any_of(plan.measures, holds);
}

void Planner::collect_others(ColumnPlan& plan) const {
  const auto is_ours = [](std::string_view name) {
    return std::ranges::find(kLabels, name, &KnownColumn::name) != kLabels.end() ||
           std::ranges::find(kMeasures, name, &KnownColumn::name) != kMeasures.end();
  };
  for (const ColumnMapping& mapping : options_.columns) {
    if (is_ours(mapping.name)) continue;
    mapped(mapping);  // says at once what the file does not have
    plan.others.push_back(mapping);
  }
  for (const std::string& name : options_.keep_all ? header_ : options_.keep) {
    const bool is_taken =
        std::ranges::find(plan.others, name, &ColumnMapping::name) != plan.others.end();
    if (is_taken || is_ours(name) || (options_.keep_all && is_used(plan, name))) continue;
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
      throw UsageError(fmt::format("{} must be a column, and '{}' is none; the columns are {}",
                                   kLabels[i].name,
                                   plan.labels[i].text,
                                   data::list_of(header_)),
                       {.file = file_, .column = "--columns"});
    }
  }
  for (std::size_t i = 0; i < kMeasureCount; ++i) plan.measures[i] = source_of(kMeasures[i]);
  plan.time_field = time_field();
  plan.stand_field = stand_field(plan);
  require_needed(plan);
  collect_expression_fields(plan);
  collect_others(plan);
  plan.notes = std::move(notes_);
  return plan;
}

}  // namespace

std::vector<ColumnMapping> usual_columns(const std::vector<std::string>& header,
                                         const std::function<bool(const std::string&)>& is_wanted,
                                         const std::string& file) {
  std::vector<ColumnMapping> found;
  const auto look = [&](const KnownColumn& column) {
    const std::string name(column.name);
    if (!is_wanted(name) || std::ranges::find(header, name) != header.end()) return;
    const auto field = usual_field(column, header, file);
    if (field) found.push_back({name, header[*field]});
  };
  std::ranges::for_each(kLabels, look);
  std::ranges::for_each(kMeasures, look);
  return found;
}

std::string describe_usual_column(const ColumnMapping& column) {
  return fmt::format("{} is read from column {}", column.name, column.source);
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
                        const InventoryOptions& options,
                        const std::string& file) {
  return Planner(header, options, file).plan();
}

}  // namespace silvafit::stand
