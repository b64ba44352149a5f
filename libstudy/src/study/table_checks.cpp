// SPDX-License-Identifier: MIT
#include "silvafit/study/table_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>
#include <utility>

#include "silvafit/base/text.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/study/structure_columns.hpp"

namespace silvafit::study {
namespace {

/// "", or " (and 3 more)".
std::string others(std::size_t count) {
  return count > 1 ? fmt::format(" (and {} more)", count - 1) : "";
}

/// The rows where a condition is false, except rows with missing values, where it is always false.
std::vector<std::size_t> rows_against(const data::Expression& condition, const data::Table& table) {
  const std::vector<std::string> names = condition.variables();
  const std::vector<double> holds = data::evaluate(condition, table);
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < holds.size(); ++row) {
    const bool complete = std::ranges::none_of(
        names, [&](const std::string& name) { return std::isnan(table.numbers(name)[row]); });
    if (complete && holds[row] != 1.0) rows.push_back(row);
  }
  return rows;
}

/// \throws DomainError at the first row where a condition of the model's domain does not hold
void require_condition(const BaseModel& model,
                       const data::Expression& condition,
                       const data::Table& table) {
  const std::vector<std::size_t> rows = rows_against(condition, table);
  if (rows.empty()) return;
  const std::string column = condition.variables().front();
  Place place = data::place_of(table, rows.front(), column);
  place.model = model.id;
  throw DomainError(fmt::format("{} is outside the domain of the model {}{}",
                                data::shortest(table.numbers(column)[rows.front()]),
                                condition.text(),
                                others(rows.size())),
                    place);
}

/// A hint on columns that are not in an inventory.
/// \param needed  columns, of which others may be missing as well
std::string origin_of(const std::string& name,
                      const std::vector<std::string>& needed,
                      const data::Table& table) {
  if (!is_structure_name(name)) return "";
  const std::vector<std::string> computable = structure_names_in(needed, table);
  if (computable.empty() && is_plot_value_name(name)) {
    return ". It is a value of the plot, from the dbh of its trees and its area; the "
           "predictions.csv of a study contains it";
  }
  if (computable.empty()) {
    return ". It is a structural index: `silvafit indices` computes it from x, y and dbh; the "
           "predictions.csv of a study contains it";
  }
  std::vector<std::string> mappings;
  mappings.reserve(computable.size());
  for (const std::string& index : computable) mappings.push_back(fmt::format("{0}={0}", index));
  return fmt::format(
      ". The predictions.csv of a study contains its indices; without a window they can be "
      "computed here: `columns={}`",
      fmt::join(mappings, ","));
}

bool is_size(const std::string& response) {
  return response == "h" || response == "hcb" || response == "cw";
}

/// The heights of trees whose crown base is above them; empty if they are not known.
std::span<const double> heights_for(const std::string& response, const data::Table& table) {
  const bool are_known = response == "hcb" && table.has("h") && table.is_numeric("h");
  return are_known ? table.numbers("h") : std::span<const double>();
}

/// The rows where a size of a tree cannot have been measured; none for other responses.
std::vector<std::size_t> impossible_rows(const std::string& response, const data::Table& table) {
  std::vector<std::size_t> rows;
  if (!is_size(response) || !table.has(response)) return rows;
  require_numbers(table, {response});
  const std::span<const double> values = table.numbers(response);
  const std::span<const double> heights = heights_for(response, table);
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (std::isnan(values[row])) continue;
    const double h_m = heights.empty() ? data::kMissing : heights[row];
    if (!is_possible_value(response, values[row], h_m)) rows.push_back(row);
  }
  return rows;
}

std::string impossible_value(const std::string& response,
                             const data::Table& table,
                             std::size_t row) {
  const double value = table.numbers(response)[row];
  const stand::TreeColumn* const column = stand::tree_column(response);
  if (!column->is_possible(value)) return fmt::format("{} m is not {}", value, column->range.text);
  return fmt::format("{} m is not below h {} m", value, heights_for(response, table)[row]);
}

/// The rows of a table of trees in which a size is negative.
std::vector<std::size_t> negative_rows(const std::string& response, const data::Table& table) {
  std::vector<std::size_t> rows;
  if (!is_size(response) || !table.has(response) || !table.has("dbh") ||
      !table.is_numeric(response))
    return rows;
  const std::span<const double> values = table.numbers(response);
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (values[row] < 0.0) rows.push_back(row);
  }
  return rows;
}

std::string leave_out(const std::vector<std::size_t>& rows,
                      const std::string& response,
                      data::Table& table) {
  if (rows.empty()) return {};
  const std::string first = describe(data::place_of(table, rows.front(), response),
                                     impossible_value(response, table, rows.front()));
  const auto read = table.numbers(response);
  std::vector<double> values(read.begin(), read.end());
  for (const std::size_t row : rows) values[row] = data::kMissing;
  table.set(response, std::move(values));
  return fmt::format(
      "{} skipped, the first: {}", counted(rows.size(), "row is", "rows are"), first);
}

/// \throws DomainError at the first of the rows
void refuse_rows(const std::vector<std::size_t>& rows,
                 const std::string& response,
                 const data::Table& table) {
  if (rows.empty()) return;
  throw DomainError(fmt::format("{}; leave the field empty if {} was not measured",
                                impossible_value(response, table, rows.front()),
                                response),
                    data::place_of(table, rows.front(), response));
}

}  // namespace

std::string origin_of_missing(const std::vector<std::string>& columns, const data::Table& table) {
  const auto index = std::ranges::find_if(columns, is_structure_name);
  return index == columns.end() ? std::string() : origin_of(*index, columns, table);
}

std::vector<std::string> add_columns(const std::vector<stand::ColumnMapping>& columns,
                                     data::Table& table,
                                     const stand::StructuralUnitOptions& options) {
  std::vector<std::string> notes;
  std::vector<std::string> computed;
  for (const stand::ColumnMapping& mapping : columns) {
    if (!table.has(mapping.source)) {
      const std::vector<std::string> names = structure_names_in({mapping.source}, table);
      for (std::string& note : add_structure_columns(names, table, options)) {
        if (std::ranges::find(notes, note) == notes.end()) notes.push_back(std::move(note));
      }
      computed.insert(computed.end(), names.begin(), names.end());
    }
    // C=C asks for the index under its own name.
    if (mapping.name == mapping.source && table.has(mapping.name)) continue;
    if (table.has(mapping.source)) {
      data::copy_column(mapping.name, table, mapping.source, table);
    } else {
      std::vector<double> values = data::checked_values(mapping.source, table);
      const bool has_codes =
          stand::is_zero_missing(mapping.name) && std::ranges::find(values, 0.0) != values.end();
      if (has_codes) {
        std::ranges::replace(values, 0.0, data::kMissing);
        notes.push_back(
            fmt::format("0 in {} by {} is read as missing", mapping.name, mapping.source));
      }
      table.set(mapping.name, std::move(values));
    }
  }
  const char* const where = options.scope == stand::SearchScope::kStand ? "the stand" : "each plot";
  const auto middle = std::ranges::stable_partition(computed, is_of_neighbors).begin();
  const auto note = [&](auto begin, auto end, const std::string& trees) {
    if (begin == end) return;
    notes.push_back(fmt::format(
        "{}: computed from {} of {}, without a window", fmt::join(begin, end, ", "), trees, where));
  };
  note(computed.begin(), middle, fmt::format("the {} nearest trees", options.neighbors));
  note(middle, computed.end(), "all trees");
  return notes;
}

void require_numbers(const data::Table& table, const std::vector<std::string>& variables) {
  for (const std::string& name : variables) {
    data::TextMatch match;
    if (data::is_text_match(name, match) || table.has(name)) continue;
    throw InputError(fmt::format("unknown column '{}'; available: {}{}",
                                 name,
                                 data::list_of(table.names()),
                                 origin_of(name, variables, table)),
                     {.file = table.file()});
  }
  data::require_numeric(table, variables);
}

void require_domain(const BaseModel& model, const data::Table& table) {
  std::vector<std::string> columns = model.covariates;
  columns.push_back(model.response);
  require_numbers(table, columns);
  for (const data::Expression& condition : model.domain) {
    require_condition(model, condition, table);
  }
}

bool is_possible_value(const std::string& response, double value, double h_m) {
  if (!is_size(response)) return true;
  const bool is_above_top = response == "hcb" && value >= h_m;
  return stand::tree_column(response)->is_possible(value) && !is_above_top;
}

void require_possible(const std::string& response, const data::Table& table) {
  refuse_rows(impossible_rows(response, table), response, table);
}

void require_not_negative(const std::string& response, const data::Table& table) {
  refuse_rows(negative_rows(response, table), response, table);
}

std::string leave_out_impossible(const std::string& response, data::Table& table) {
  return leave_out(impossible_rows(response, table), response, table);
}

std::string leave_out_negative(const std::string& response, data::Table& table) {
  return leave_out(negative_rows(response, table), response, table);
}

void use_base_model(const BaseModel& model,
                    const data::Table& table,
                    fit::ModelTexts& texts,
                    fit::FitModelOptions& options) try {
  require_domain(model, table);
  require_possible(model.response, table);
  texts.formula = model.formula;
  const std::vector<double> starts = start_values(model, table);
  for (std::size_t k = 0; k < starts.size(); ++k) {
    options.rule[model.parameters[k].name] = starts[k];
  }
} catch (const UsageError& error) {
  // Too few rows are an error of the table.
  Place place = error.place();
  place.file = table.file();
  place.model = model.id;
  throw InputError(error.message(), place);
}

void require_domain_of_covariates(const BaseModel& model, const data::Table& table) {
  for (const data::Expression& condition : model.domain) {
    const std::vector<std::string> names = condition.variables();
    const bool is_of_covariates = std::ranges::all_of(names, [&](const std::string& name) {
      return std::ranges::find(model.covariates, name) != model.covariates.end() &&
             table.has(name) && table.is_numeric(name);
    });
    if (is_of_covariates) require_condition(model, condition, table);
  }
}

const BaseModel* base_model_of(const fit::FittedModel& fit, const Catalogue* catalogue) {
  if (catalogue == nullptr) return nullptr;
  const auto model = std::ranges::find(catalogue->models(), fit.model, &BaseModel::id);
  return model == catalogue->models().end() ? nullptr : &*model;
}

}  // namespace silvafit::study
