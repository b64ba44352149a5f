// SPDX-License-Identifier: MIT
#include "study_work.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "silvafit/base/error.hpp"

namespace silvafit::study {

bool has_numbers(const data::Table& table, const std::string& name) {
  return table.has(name) && table.is_numeric(name);
}

namespace {

bool all_present(const data::Table& table,
                 const std::vector<std::string>& columns,
                 std::size_t row) {
  return std::ranges::none_of(
      columns, [&](const std::string& name) { return std::isnan(table.numbers(name)[row]); });
}

/// Columns among those wanted that the table has with values that differ.
std::vector<std::string> varying_columns(const data::Table& table,
                                         const std::vector<std::string>& wanted,
                                         const std::vector<std::size_t>& rows,
                                         std::vector<std::string>& notes) {
  std::vector<std::string> result;
  for (const std::string& name : wanted) {
    if (!has_numbers(table, name)) continue;
    std::set<double> values;
    for (const std::size_t row : rows) {
      const double value = table.numbers(name)[row];
      if (!std::isnan(value)) values.insert(value);
      if (values.size() > 1) break;
    }
    if (values.size() > 1) {
      result.push_back(name);
    } else {
      notes.push_back(
          fmt::format("{} is {} for all of these trees: left out as a covariate.",
                      name,
                      values.empty() ? std::string("missing") : data::shortest(*values.begin())));
    }
  }
  return result;
}

std::vector<std::size_t> rows_of_species(const data::Table& table, const std::string& species) {
  std::vector<std::size_t> rows;
  const data::TextColumn column = table.labels("species");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bool counts = !has_numbers(table, "core") || table.numbers("core")[row] == 1.0;
    if (counts && !column.is_missing(row) && column[row] == species) rows.push_back(row);
  }
  return rows;
}

std::vector<std::size_t> complete_rows(const data::Table& table,
                                       const std::vector<std::size_t>& rows,
                                       const std::vector<std::string>& columns) {
  std::vector<std::size_t> complete;
  for (const std::size_t row : rows) {
    if (all_present(table, columns, row)) complete.push_back(row);
  }
  return complete;
}

std::size_t count_groups(const data::Table& table, const std::string& group) {
  return table.labels(group).levels().size();
}

bool is_formula(const std::string& text) { return text.find('~') != std::string::npos; }

/// \throws UsageError if a candidate is neither in the catalogue nor a formula, or is for another
/// response
std::vector<BaseCandidate> candidates_of(const std::string& response,
                                         const Catalogue& catalogue,
                                         const StudyOptions& options) {
  std::vector<BaseCandidate> candidates;
  const auto chosen = options.candidates.find(response);
  if (chosen == options.candidates.end()) {
    for (const BaseModel* model : catalogue.candidates(response)) {
      candidates.push_back({.entry = model, .formula = model->formula});
    }
    return candidates;
  }
  for (const std::string& text : chosen->second) {
    BaseCandidate candidate{.formula = text};
    if (!is_formula(text)) {
      candidate.entry = &catalogue.find(text);
      candidate.formula = candidate.entry->formula;
    }
    if (data::parse_formula(candidate.formula).left != response) {
      throw UsageError(fmt::format("the candidate '{}' is no model of {}", text, response));
    }
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

}  // namespace

Work prepared(const data::Table& table,
              const Catalogue& catalogue,
              const StudyOptions& options,
              const std::string& species,
              const std::string& response) {
  Work work{.result = {.species = species, .response = response},
            .candidates = candidates_of(response, catalogue, options)};
  std::vector<std::string> columns{response};
  for (const BaseCandidate& candidate : work.candidates) {
    for (const std::string& name : candidate.columns(table)) columns.push_back(name);
  }
  if (!std::ranges::all_of(columns,
                           [&](const std::string& name) { return has_numbers(table, name); })) {
    return work;
  }
  const auto rows = complete_rows(table, rows_of_species(table, species), columns);
  work.covariates = varying_columns(table, options.covariates, rows, work.result.notes);
  columns.insert(columns.end(), work.covariates.begin(), work.covariates.end());
  work.result.rows = complete_rows(table, rows, columns);
  if (work.result.rows.size() < rows.size()) {
    work.result.notes.push_back(fmt::format("{} trees without structural unit were left out.",
                                            rows.size() - work.result.rows.size()));
  }
  work.table = table.select(work.result.rows);
  work.result.plots = count_groups(work.table, options.group);
  return work;
}

std::vector<std::string> species_of(const data::Table& table, const StudyOptions& options) {
  const data::TextColumn column = table.labels("species");
  if (options.species.empty()) return column.levels();
  for (const std::string& species : options.species) {
    if (column.code_of(species) == data::TextColumn::kMissingCode) {
      throw UsageError(fmt::format("there is no species '{}'; the species are {}",
                                   species,
                                   fmt::join(column.levels(), ", ")),
                       {.file = table.file()});
    }
  }
  return options.species;
}

}  // namespace silvafit::study
