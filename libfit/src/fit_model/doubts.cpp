// SPDX-License-Identifier: MIT
#include "fit_model/doubts.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "model/name_doubts.hpp"
#include "silvafit/base/median.hpp"
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

/// Whether a number is written with nines only, such as 999 and 99.9.
bool is_all_nines(double value) {
  std::string text = data::shortest(std::abs(value));
  std::erase(text, '.');
  return text.find_first_not_of('9') == std::string::npos;
}

/// The value at an end of a column that may be a code: it is repeated, and far from all others.
/// \param values  ascending
/// \param code    whether a value is one of those that people take
template <class Condition>
std::optional<double> isolated_end(const std::vector<double>& values, Condition code) {
  constexpr std::ptrdiff_t kRepeated = 3;
  constexpr std::size_t kFewestOthers = 10;
  constexpr double kIsolated = 20.0;  // typical distances of neighbors
  std::vector<double> distinct = values;
  distinct.erase(std::ranges::unique(distinct).begin(), distinct.end());
  if (distinct.size() < kFewestOthers) return std::nullopt;
  std::vector<double> gaps(distinct.size());
  std::adjacent_difference(distinct.begin(), distinct.end(), gaps.begin());
  gaps.erase(gaps.begin());
  const double typical = median(gaps);
  for (const auto& [end, gap] :
       {std::pair(distinct.front(), gaps.front()), std::pair(distinct.back(), gaps.back())}) {
    if (!code(end) || gap < kIsolated * typical) continue;
    if (std::ranges::count(values, end) >= kRepeated) return end;
  }
  return std::nullopt;
}

/// A code of missing values: the only negative value of a column, or nines, or 0 as a response,
/// away from all other values.
void add_code_doubt(const data::Table& table, const std::string& column, FitResult& result) {
  if (!table.has(column) || !table.is_numeric(column)) return;
  Convergence& convergence = result.fit.convergence;
  std::vector<double> values;
  for (const std::size_t row : result.rows) values.push_back(table.numbers(column)[row]);
  std::ranges::sort(values);
  const auto below = std::ranges::lower_bound(values, 0.0) - values.begin();
  const bool is_one = below > 0 && values[static_cast<std::size_t>(below) - 1] == values.front();
  const auto add = [&](Finding::Kind kind, double code) {
    const auto count = static_cast<double>(std::ranges::count(values, code));
    convergence.find({.kind = kind, .names = {column, data::shortest(code)}, .values = {count}});
    convergence.evidence.push_back(
        {.kind = Evidence::Kind::kMissingCode, .term = column, .value = code});
  };
  if (is_one &&
      (data::is_missing_code(values.front()) || data::is_likely_missing_code(values.front()))) {
    return add(Finding::Kind::kMissingCode, values.front());
  }
  const bool is_response = column == result.fit.specification.formula.left;
  const auto code = isolated_end(
      values, [&](double value) { return value == 0.0 ? is_response : is_all_nines(value); });
  if (code) add(Finding::Kind::kIsolatedCode, *code);
}

}  // namespace

void add_name_doubts(const FitModelOptions& options, FittedModel& fit) {
  const ModelSpecification& specification = fit.specification;
  Convergence& convergence = fit.convergence;
  const std::set<std::string> known = known_parameters(options);
  const NameDoubts doubts = name_doubts(specification, known, options.fixed);
  if (!doubts.text.empty())
    convergence.find({.kind = Finding::Kind::kNameDoubt, .names = {doubts.text}});
  convergence.add(Evidence::Kind::kTakenAsParameter, doubts.names);
  if (convergence.converged()) return;
  const std::string taken =
      parameters_taken(specification, known, {doubts.names.begin(), doubts.names.end()});
  if (!taken.empty()) convergence.find({.kind = Finding::Kind::kParametersTaken, .names = {taken}});
}

void add_doubts(const data::Table& table, const FitModelOptions& options, FitResult& result) {
  FittedModel& fit = result.fit;
  if (fit.specification.data_columns.empty()) return;
  if (auto doubt = response_doubt(table, result)) {
    fit.convergence.find(*std::move(doubt));
    fit.convergence.add(Evidence::Kind::kResponseValues, {fit.specification.formula.left});
  }
  std::set<std::string> columns{fit.specification.formula.left};
  for (const ColumnRange& range : fit.ranges) columns.insert(range.column);
  for (const VarianceFactor& factor : fit.specification.variance.factors) {
    columns.insert(factor.column);
  }
  for (const std::string& column : columns) add_code_doubt(table, column, result);
  add_name_doubts(options, fit);
}

}  // namespace silvafit::fit
