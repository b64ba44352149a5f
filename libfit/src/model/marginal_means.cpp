// SPDX-License-Identifier: MIT
#include "model/marginal_means.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "model/factor_columns.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/near_names.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::fit {
namespace {

using Names = std::vector<std::string>;

/// The levels of factors and the means of numbers in the rows of a fit.
class ReferenceGrid {
 public:
  ReferenceGrid(const ModelSpecification& specification, const data::Table& table)
      : factors_(specification.factors), table_(table) {
    std::set<std::string> columns;
    for (const std::string& name : specification.predictors())
      columns.insert(data::column_of(name));
    columns.insert(specification.formula.left);
    std::erase_if(columns, [&table](const std::string& name) { return !table.has(name); });
    complete_ = complete_rows({columns.begin(), columns.end()}, table);
  }

  bool is_factor(const std::string& column) const {
    return std::ranges::find(factors_, column) != factors_.end();
  }
  Names levels_of(const std::string& column) const;
  double mean_of(const std::string& column) const;
  /// All combinations of the levels of factors, at the means of numbers.
  data::Table combinations(const std::map<std::string, Names>& levels,
                           const std::set<std::string>& numbers) const;

 private:
  const Names& factors_;
  const data::Table& table_;
  std::vector<bool> complete_{};
};

Names ReferenceGrid::levels_of(const std::string& column) const {
  const data::TextColumn labels = table_.labels(column);
  std::set<std::string> levels;
  for (std::size_t row = 0; row < labels.size(); ++row) {
    if (complete_[row]) levels.emplace(labels[row]);
  }
  return {levels.begin(), levels.end()};
}

double ReferenceGrid::mean_of(const std::string& column) const {
  const auto values = table_.numbers(column);
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (!complete_[row]) continue;
    sum += values[row];
    ++count;
  }
  return sum / count;
}

data::Table ReferenceGrid::combinations(const std::map<std::string, Names>& levels,
                                        const std::set<std::string>& numbers) const {
  constexpr std::size_t kMost = 1'000'000;
  std::size_t rows = 1;
  for (const auto& [column, names] : levels) {
    rows *= names.size();
    if (rows <= kMost) continue;
    throw UsageError(fmt::format("the factors have more than {} combinations of levels", kMost),
                     {.column = "`means`"});
  }
  data::Table grid(rows);
  std::size_t repeated = 1;
  for (const auto& [column, names] : levels) {
    data::TextColumn labels;
    for (std::size_t row = 0; row < rows; ++row)
      labels.append(names[row / repeated % names.size()]);
    grid.set(column, std::move(labels));
    repeated *= names.size();
  }
  for (const std::string& column : numbers) {
    grid.set(column, std::vector<double>(rows, mean_of(column)));
  }
  return grid;
}

/// The columns of a parameter's covariates.
std::set<std::string> columns_of(const ParameterModel& parameter) {
  std::set<std::string> columns;
  for (const Covariate& covariate : parameter.covariates) {
    for (const std::string& name : covariate.value.variables())
      columns.insert(data::column_of(name));
  }
  return columns;
}

/// The mean of a parameter over a grid, a weighted sum of its coefficients.
data::Expression mean_over(const data::Table& grid, const ParameterModel& parameter) {
  std::string sum =
      parameter.has_intercept ? data::Expression::variable(parameter.name).text() : "";
  for (const Covariate& covariate : parameter.covariates) {
    const std::vector<double> values = data::evaluate(covariate.value, grid);
    const double weight =
        std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    if (weight == 0.0) continue;
    sum += fmt::format("{}{}*{}",
                       sum.empty() ? "" : " + ",
                       data::shortest(weight),
                       data::Expression::variable(parameter.coefficient_name(covariate)).text());
  }
  return data::Expression::parse(sum);
}

}  // namespace

std::vector<DerivedQuantity> marginal_means(const ModelSpecification& specification,
                                            const std::string& factor,
                                            const data::Table& table) {
  const ReferenceGrid grid(specification, table);
  if (!grid.is_factor(factor)) {
    throw UsageError(fmt::format("'{}' is not a factor of a sub-model{}",
                                 factor,
                                 specification.factors.empty()
                                     ? ""
                                     : "; factors: " + data::list_of(specification.factors)),
                     {.column = "`means`"});
  }
  std::vector<DerivedQuantity> means;
  for (const ParameterModel& parameter : specification.parameters) {
    std::map<std::string, Names> levels;
    std::set<std::string> numbers;
    for (const std::string& column : columns_of(parameter)) {
      if (grid.is_factor(column)) {
        levels.emplace(column, grid.levels_of(column));
      } else {
        numbers.insert(column);
      }
    }
    if (!levels.contains(factor)) continue;
    for (const std::string& level : grid.levels_of(factor)) {
      levels[factor] = {level};
      means.push_back({.name = fmt::format("{} ({} {})", parameter.name, factor, level),
                       .value = mean_over(grid.combinations(levels, numbers), parameter)});
    }
  }
  return means;
}

}  // namespace silvafit::fit
