// SPDX-License-Identifier: MIT
#include "study/study_work.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/fit/variance_function.hpp"
#include "silvafit/study/structure_columns.hpp"

namespace silvafit::study {

bool has_numbers(const data::Table& table, const std::string& name) {
  return table.has(name) && table.is_numeric(name);
}

namespace {

/// The wanted columns that are in the table and are not constant.
std::vector<std::string> varying_columns(const data::Table& table,
                                         const std::vector<std::string>& wanted,
                                         const std::vector<std::size_t>& rows,
                                         std::vector<std::string>& notes) {
  std::vector<std::string> result;
  for (const std::string& name : wanted) {
    if (!has_numbers(table, name)) continue;
    const std::span<const double> column = table.numbers(name);
    std::set<double> values;
    for (const std::size_t row : rows) {
      const double value = column[row];
      if (!std::isnan(value)) values.insert(value);
      if (values.size() > 1) break;
    }
    if (values.size() > 1) {
      result.push_back(name);
    } else {
      notes.push_back(
          fmt::format("{} is {} for all of these trees and is not used as a covariate.",
                      name,
                      values.empty() ? std::string("missing") : data::shortest(*values.begin())));
    }
  }
  return result;
}

std::vector<std::size_t> rows_of_species(const data::Table& table, const std::string& species) {
  std::vector<std::size_t> rows;
  const data::TextColumn column = table.labels("species");
  const std::uint32_t code = column.code_of(species);
  if (code == data::TextColumn::kMissingCode) return rows;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (column.code(row) == code) rows.push_back(row);
  }
  return rows;
}

/// The rows of core trees; all rows without structural units.
std::vector<std::size_t> core_rows(const data::Table& table, std::vector<std::size_t> rows) {
  if (!has_numbers(table, "core")) return rows;
  const std::span<const double> core = table.numbers("core");
  std::erase_if(rows, [core](std::size_t row) { return core[row] != 1.0; });
  return rows;
}

std::vector<std::size_t> complete_rows(const data::Table& table,
                                       const std::vector<std::size_t>& rows,
                                       const std::vector<std::string>& columns) {
  std::vector<std::span<const double>> values;
  values.reserve(columns.size());
  for (const std::string& name : columns) values.push_back(table.numbers(name));
  std::vector<std::size_t> complete;
  for (const std::size_t row : rows) {
    const bool is_complete = std::ranges::none_of(
        values, [row](std::span<const double> column) { return std::isnan(column[row]); });
    if (is_complete) complete.push_back(row);
  }
  return complete;
}

/// The covariates that some of the rows lack: "a structural unit", or their columns.
std::string lacking_covariates(const data::Table& table,
                               const std::vector<std::size_t>& rows,
                               const std::vector<std::string>& covariates) {
  std::set<std::string> lacking;
  for (const std::string& name : covariates) {
    const bool is_complete = complete_rows(table, rows, {name}).size() == rows.size();
    if (!is_complete) lacking.insert(is_structure_name(name) ? "a structural unit" : name);
  }
  return fmt::format("{}", fmt::join(lacking, " or "));
}

std::size_t count_groups(const data::Table& table, const std::string& group) {
  return table.labels(group).levels().size();
}

/// \throws UsageError if a column of groups is used as a number
void refuse_number(const std::vector<std::string>& numbers,
                   const std::string& group,
                   const std::string& option,
                   const std::string& response,
                   const std::string& file) {
  if (std::ranges::find(numbers, group) == numbers.end()) return;
  throw UsageError(
      fmt::format("the models for {} use '{}' as a number, so it cannot define the groups of the "
                  "random effects; name another column with {}",
                  response,
                  group,
                  option),
      {.file = file, .column = option});
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
      throw UsageError(fmt::format("the candidate '{}' is not a model for {}", text, response));
    }
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

/// Some columns of a table, as far as it has them.
data::Table with_columns(const data::Table& table, const std::vector<std::string>& names) {
  data::Table part(table.rows());
  for (const std::string& name : names) {
    if (!table.has(name) || part.has(name)) continue;
    data::copy_column(name, table, name, part);
  }
  std::vector<std::uint32_t> lines(table.rows());
  for (std::size_t row = 0; row < lines.size(); ++row) {
    lines[row] = static_cast<std::uint32_t>(table.line(row));
  }
  part.set_origin(table.file(), std::move(lines));
  return part;
}

}  // namespace

std::vector<std::string> variance_columns(const StudyOptions& options) {
  std::vector<std::string> names;
  for (const std::string& text : options.variance_functions) {
    for (const fit::VarianceFactor& factor : fit::parse_variance_function(text).factors) {
      for (const std::string& name : {factor.column, factor.stratum}) {
        if (!name.empty()) names.push_back(name);
      }
    }
  }
  return names;
}

std::string Work::objection_to_curves(const fit::FittedModel& fit) const {
  if (!plausibility) return "";
  const auto own = std::ranges::find_if(candidates, [&](const BaseCandidate& candidate) {
    return candidate.entry != nullptr && candidate.entry->id == fit.model;
  });
  return plausibility->objection(fit, own == candidates.end() ? nullptr : own->entry);
}

std::string tree_counts(const Work& work) {
  const std::size_t used = work.result.rows.size();
  if (used == work.measured) return std::to_string(used);
  const std::string core = counted(work.core, "core tree", "core trees");
  const std::string of_measured = fmt::format("{} of {} measured", core, work.measured);
  return used == work.core ? of_measured
                           : fmt::format("{} with {}; {}", used, work.lacking, of_measured);
}

bool Work::has_repeated_trees() const {
  if (!table.has(kTree)) return false;
  const data::TextColumn plots = table.has("plot") ? table.labels("plot") : data::TextColumn();
  const data::TextColumn trees = table.labels(kTree);
  std::set<std::pair<std::uint32_t, std::uint32_t>> known;
  for (std::size_t row = 0; row < trees.size(); ++row) {
    if (trees.is_missing(row)) return false;
    known.emplace(plots.size() > 0 ? plots.code(row) : 0, trees.code(row));
  }
  return known.size() < trees.size();
}

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
  // Periods are text, with which the models would be skipped.
  refuse_number(columns, options.period, "`period`", response, table.file());
  if (!std::ranges::all_of(columns,
                           [&](const std::string& name) { return has_numbers(table, name); })) {
    return work;
  }
  const auto measured = complete_rows(table, rows_of_species(table, species), columns);
  const auto rows = core_rows(table, measured);
  work.measured = measured.size();
  work.core = rows.size();
  work.covariates = varying_columns(table, options.covariates, rows, work.result.notes);
  columns.insert(columns.end(), work.covariates.begin(), work.covariates.end());
  work.result.rows = complete_rows(table, rows, columns);
  if (work.result.rows.size() < rows.size()) {
    work.lacking = lacking_covariates(table, rows, work.covariates);
    work.result.notes.push_back(
        fmt::format("{} without {} {} excluded.",
                    counted(rows.size() - work.result.rows.size(), "tree", "trees"),
                    work.lacking,
                    rows.size() - work.result.rows.size() == 1 ? "was" : "were"));
  }
  refuse_number(columns, options.group, "`group`", response, table.file());
  columns.push_back(options.group);
  if (!options.period.empty()) {
    columns.push_back(options.period);
    for (const std::string& name : {std::string("plot"), std::string(kTree)}) {
      if (table.has(name)) columns.push_back(name);
    }
  }
  for (const std::string& name : variance_columns(options)) columns.push_back(name);
  // With all columns, a study of a million trees would store each column nine times.
  work.table = with_columns(table, columns).select(work.result.rows);
  if (options.compared_trees > 0 && work.table.rows() > options.compared_trees) {
    work.sample =
        work.table.select(representative_rows(work.table, options.group, options.compared_trees));
    work.result.notes.push_back(
        fmt::format("Candidates were compared on a representative sample of {} of the {} trees; "
                    "the chosen models are fitted to all trees (compared_trees in study.json).",
                    work.sample.rows(),
                    work.table.rows()));
  }
  work.result.group = options.group;
  work.result.period = options.period;
  work.result.plots = count_groups(work.table, options.group);
  return work;
}

std::vector<std::string> species_of(const data::Table& table, const StudyOptions& options) {
  const data::TextColumn column = table.labels("species");
  if (options.species.empty()) return column.levels();
  for (const std::string& species : options.species) {
    if (column.code_of(species) == data::TextColumn::kMissingCode) {
      throw UsageError(
          fmt::format(
              "unknown species '{}'; available: {}", species, data::list_of(column.levels())),
          {.file = table.file()});
    }
  }
  return options.species;
}

}  // namespace silvafit::study
