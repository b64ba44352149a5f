// SPDX-License-Identifier: MIT
#include "fit_model/doubts.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <ranges>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "model/name_doubts.hpp"
#include "silvafit/data/missing_codes.hpp"

namespace silvafit::fit {
namespace {

/// Parameters that the caller has named: those of the options' coefficients, b of b:C.
std::set<std::string> known_parameters(const FitModelOptions& options) {
  std::set<std::string> names;
  const auto add = [&names](const auto& values) {
    for (const auto& [name, value] : values) names.insert(name.substr(0, name.find(':')));
  };
  add(options.start);
  add(options.fixed);
  add(options.bounds);
  add(options.rule);
  return names;
}

VectorXd response_of(const data::Table& table, const FitResult& result) {
  const auto values = table.numbers(result.fit.specification.formula.left);
  VectorXd response(static_cast<Index>(result.rows.size()));
  for (std::size_t i = 0; i < result.rows.size(); ++i) {
    response[static_cast<Index>(i)] = values[result.rows[i]];
  }
  return response;
}

/// The number of rows of each value; of more than `most` values, those that come first.
std::map<double, int> value_counts(const VectorXd& response, std::size_t most) {
  std::map<double, int> counts;
  for (const double value : response) {
    ++counts[value];
    if (counts.size() > most) break;
  }
  return counts;
}

/// Two values that occur several times each, such as 0 and 1.
std::optional<Finding> two_values(const std::string& name, const VectorXd& response) {
  const std::map<double, int> counts = value_counts(response, 2);
  const bool are_two = counts.size() == 2 &&
                       std::ranges::all_of(counts, [](const auto& one) { return one.second > 1; });
  if (!are_two) return std::nullopt;
  return Finding{
      .kind = Finding::Kind::kTwoValues,
      .names = {
          name, data::shortest(counts.begin()->first), data::shortest(counts.rbegin()->first)}};
}

/// Whole numbers, some of them 0. Measurements in whole units rarely have zeros; the sentence is
/// conditional all the same. Counts without zeros are like measurements in whole units.
std::optional<Finding> zero_counts(const ModelSpecification& specification,
                                   const VectorXd& response) {
  const bool are_whole = (response.array() == response.array().round()).all();
  if (!are_whole || response.minCoeff() != 0.0 || response.maxCoeff() == 0.0) return std::nullopt;
  if (!specification.variance.is_constant()) return std::nullopt;
  return Finding{.kind = Finding::Kind::kCounts, .names = {specification.formula.left}};
}

std::optional<Finding> response_doubt(const data::Table& table, const FitResult& result) {
  const VectorXd response = response_of(table, result);
  if (response.size() == 0) return std::nullopt;
  const ModelSpecification& specification = result.fit.specification;
  const auto found = two_values(specification.formula.left, response);
  return found ? found : zero_counts(specification, response);
}

/// A value that may be a code of missing values; 0 as a response only.
void add_code_doubt(const data::Table& table, const std::string& column, FitResult& result) {
  if (!table.has(column) || !table.is_numeric(column)) return;
  std::vector<double> values;
  for (const std::size_t row : result.rows) values.push_back(table.numbers(column)[row]);
  const auto code = data::possible_code(values, column == result.fit.specification.formula.left);
  if (!code) return;
  const auto count = static_cast<double>(std::ranges::count(values, *code));
  Convergence& convergence = result.fit.convergence;
  convergence.find(
      {.kind = *code < 0.0 ? Finding::Kind::kMissingCode : Finding::Kind::kIsolatedCode,
       .names = {column, data::shortest(*code)},
       .values = {count}});
  convergence.evidence.push_back(
      {.kind = Evidence::Kind::kMissingCode, .term = column, .value = *code});
}

/// Responses that `silvafit impute` has filled in, as its own column says.
void add_imputed_doubt(const data::Table& table, FitResult& result) {
  const std::string& response = result.fit.specification.formula.left;
  const std::string source = response + "_source";
  if (!table.has(source) || table.is_numeric(source)) return;
  const data::TextColumn& sources = table.text(source);
  const auto count = std::ranges::count_if(
      result.rows, [&sources](std::size_t row) { return sources[row] == "imputed"; });
  if (count == 0) return;
  result.fit.convergence.find({.kind = Finding::Kind::kImputedRows,
                               .names = {response},
                               .values = {static_cast<double>(count)}});
  result.fit.convergence.add(Evidence::Kind::kResponseValues, {response});
}

}  // namespace

void add_name_doubts(const FitModelOptions& options, FittedModel& fit) {
  const ModelSpecification& specification = fit.specification;
  Convergence& convergence = fit.convergence;
  const std::set<std::string> known = known_parameters(options);
  const NameDoubts doubts = name_doubts(specification, known, options.fixed);
  // The last finding before the result comes first.
  for (const Finding& finding : doubts.findings | std::views::reverse) convergence.find(finding);
  convergence.add(Evidence::Kind::kTakenAsParameter, doubts.names);
  // That a likelihood has no maximum is a reason of its own.
  if (convergence.converged() || convergence.status == ConvergenceStatus::kNoMaximum) return;
  const std::vector<std::string> taken =
      parameters_taken(specification, known, {doubts.names.begin(), doubts.names.end()});
  if (!taken.empty()) convergence.find({.kind = Finding::Kind::kParametersTaken, .names = taken});
}

void add_doubts(const data::Table& table, const FitModelOptions& options, FitResult& result) {
  FittedModel& fit = result.fit;
  if (fit.specification.data_columns.empty()) return;
  if (auto doubt = response_doubt(table, result)) {
    fit.convergence.find(*std::move(doubt));
    fit.convergence.add(Evidence::Kind::kResponseValues, {fit.specification.formula.left});
  }
  add_imputed_doubt(table, result);
  std::set<std::string> columns{fit.specification.formula.left};
  for (const ColumnRange& range : fit.ranges) columns.insert(range.column);
  for (const VarianceFactor& factor : fit.specification.variance.factors) {
    columns.insert(factor.column);
  }
  for (const std::string& column : columns) add_code_doubt(table, column, result);
  add_name_doubts(options, fit);
}

}  // namespace silvafit::fit
