// SPDX-License-Identifier: MIT
#include "trees/known_tables.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <utility>

#include "silvafit/base/words.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/data/json_reader.hpp"
#include "trees/column_sources.hpp"
#include "trees/folded_text.hpp"

namespace silvafit::stand {
namespace {

using data::JsonReader;
using Header = std::vector<std::string>;

constexpr std::array<std::pair<std::string_view, TreeStatus>, 4> kStatuses{
    {{"alive", TreeStatus::kAlive},
     {"dead", TreeStatus::kDead},
     {"cut", TreeStatus::kGone},
     {"not_in_sample", TreeStatus::kNotInSample}}};

KnownHeader header_of(const JsonReader& json) {
  KnownHeader header{.all = json.at("all").texts()};
  if (json.has("some")) {
    header.some = json.at("some").texts();
    header.at_least = json.has("at_least") ? json.at("at_least").count() : 1;
  }
  return header;
}

void read_status(const JsonReader& json, KnownTable& table) {
  const JsonReader column = json.at("column");
  table.status_columns = column.is_list() ? column.texts() : std::vector{column.text()};
  for (const auto& [name, status] : kStatuses) {
    if (!json.has(name)) continue;
    for (const std::string& code : json.at(name).texts()) table.status.emplace(code, status);
  }
  if (const auto others = json.find("others")) {
    table.other_status =
        kStatuses[others->one_of({"alive", "dead", "cut", "not_in_sample"})].second;
  }
}

KnownTable read_known_table(std::string_view text) {
  const JsonReader json = JsonReader::parse(text, "models/sources");
  json.allow_only({"schema",
                   "title",
                   "source",
                   "recognized",
                   "columns",
                   "units",
                   "status",
                   "plots",
                   "species"});
  KnownTable table{.title = json.at("title").text(), .has_fia_species = json.has("species")};
  if (table.has_fia_species) json.at("species").one_of({"FIA"});
  for (const JsonReader& one : json.at("recognized").items()) {
    table.recognized.push_back(header_of(one));
  }
  for (const auto& [name, sources] : json.at("columns").members()) {
    table.columns.emplace(name, sources.texts());
  }
  if (const auto units = json.find("units")) {
    for (const auto& [column, unit] : units->members()) table.units.emplace(column, unit.text());
  }
  if (const auto status = json.find("status")) read_status(*status, table);
  if (const auto plots = json.find("plots")) {
    for (const JsonReader& one : plots->items()) {
      table.plots.emplace_back(header_of(one), one.at("plot").text());
    }
  }
  return table;
}

const std::vector<KnownTable>& known_tables() {
  static const std::vector<KnownTable> tables = [] {
    std::vector<KnownTable> read;
    for (const std::string_view text : known_table_texts()) read.push_back(read_known_table(text));
    return read;
  }();
  return tables;
}

/// The column of a name, which some databases write in other cases.
std::optional<std::string> column_named(std::string_view name, const Header& header) {
  auto field = field_named(name, header);
  if (!field) field = field_in_any_case(name, header);
  return field ? std::optional(header[*field]) : std::nullopt;
}

bool fits(const KnownHeader& known, const Header& header) {
  const auto exists = [&header](const std::string& name) {
    return column_named(name, header).has_value();
  };
  return std::ranges::all_of(known.all, exists) &&
         static_cast<std::size_t>(std::ranges::count_if(known.some, exists)) >= known.at_least;
}

/// The columns of `STATECD?+PLOT` that exist, joined; empty if a needed one does not.
std::string joined_source(std::string_view source, const Header& header) {
  std::string joined;
  for (std::size_t begin = 0; begin <= source.size();) {
    const std::size_t end = std::min(source.find('+', begin), source.size());
    std::string_view name = source.substr(begin, end - begin);
    const bool may_lack = name.ends_with('?');
    if (may_lack) name.remove_suffix(1);
    const auto column = column_named(name, header);
    if (!column && !may_lack) return {};
    if (column) joined += (joined.empty() ? "" : "+") + *column;
    begin = end + 1;
  }
  return joined;
}

/// A column or an expression with the names of the header; empty if a column is missing.
std::string source_in(const std::string& source, const Header& header) {
  if (const auto column = column_named(source, header)) return *column;
  data::Expression expression = data::Expression::parse(source);
  const Header variables = expression.variables();
  if (variables == Header{source}) return {};
  for (const std::string& name : variables) {
    const auto column = column_named(name, header);
    if (!column) return {};
    if (*column != name) {
      expression = expression.substitute(name, data::Expression::variable(*column));
    }
  }
  return expression.text();
}

}  // namespace

const KnownTable* known_table(const Header& header) {
  for (const KnownTable& table : known_tables()) {
    const auto is_it = [&header](const KnownHeader& known) { return fits(known, header); };
    if (std::ranges::any_of(table.recognized, is_it)) return &table;
  }
  return nullptr;
}

bool may_have_fia_species(const Header& header) {
  const KnownTable* const table = known_table(header);
  return table == nullptr || table->has_fia_species;
}

std::vector<ColumnMapping> known_columns(const Header& header, bool by_location) {
  std::vector<ColumnMapping> columns;
  const KnownTable* const table = known_table(header);
  if (table == nullptr) return columns;
  for (const auto& [name, sources] : table->columns) {
    const bool is_plot = name == "plot" || name == "location";
    const bool has_location = table->columns.contains("location");
    if (is_plot && has_location && (name == "location") != by_location) continue;
    for (const std::string& text : sources) {
      const std::string standard = is_plot ? "plot" : name;
      const std::string source =
          is_label(standard) ? joined_source(text, header) : source_in(text, header);
      if (source.empty()) continue;
      columns.push_back({.name = standard, .source = source});
      break;
    }
  }
  return columns;
}

std::string_view known_unit(const std::string& column, const Header& header) {
  const KnownTable* const table = known_table(header);
  if (table == nullptr) return {};
  const auto found = std::ranges::find_if(
      table->units, [&column](const auto& unit) { return are_equal_words(unit.first, column); });
  return found == table->units.end() ? std::string_view() : found->second;
}

std::optional<std::string> known_status_column(const Header& header) {
  const KnownTable* const table = known_table(header);
  if (table == nullptr) return std::nullopt;
  Header columns;
  for (const std::string& name : table->status_columns) {
    if (const auto column = column_named(name, header)) columns.push_back(*column);
  }
  if (columns.empty()) return std::nullopt;
  return columns.size() == 1 ? columns.front() : fmt::format("first({})", fmt::join(columns, ", "));
}

const KnownTable* known_status_table(std::string_view column, const Header& header) {
  const auto has_it = [&column](const KnownTable& table) {
    return std::ranges::any_of(table.status_columns, [&column](const std::string& known) {
      return are_equal_words(known, column);
    });
  };
  const KnownTable* const own = known_table(header);
  if (own != nullptr && (has_it(*own) || known_status_column(header) == column)) return own;
  if (are_equal_words(column, "status")) return nullptr;
  const auto found = std::ranges::find_if(known_tables(), has_it);
  return found == known_tables().end() ? nullptr : &*found;
}

std::optional<TreeStatus> known_status(const KnownTable& table, std::string_view code) {
  for (const auto& [known, status] : table.status) {
    if (is_same_code(known, code)) return status;
  }
  return table.other_status;
}

std::optional<std::string> known_plot_column(const Header& header) {
  for (const KnownTable& table : known_tables()) {
    for (const auto& [known, plot] : table.plots) {
      if (fits(known, header)) return column_named(plot, header);
    }
  }
  return std::nullopt;
}

}  // namespace silvafit::stand
