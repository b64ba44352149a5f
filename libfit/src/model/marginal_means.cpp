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
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::fit {
namespace {

using Names = std::vector<std::string>;

/// The levels of factors and the means of numbers in the rows of a fit.
class ReferenceGrid {
 public:
  ReferenceGrid(const ModelSpecification& specification, const data::Table& table) : table_(table) {
    std::set<std::string> columns;
    for (const std::string& name : specification.predictors())
      columns.insert(data::column_of(name));
    columns.insert(specification.formula.left);
    std::erase_if(columns, [&table](const std::string& name) { return !table.has(name); });
    complete_ = complete_rows({columns.begin(), columns.end()}, table);
  }

  Names levels_of(const std::string& column) const;
  double mean_of(const std::string& column) const;
  /// All combinations of the levels of factors, at the means of numbers.
  data::Table combinations(const std::map<std::string, Names>& levels,
                           const std::set<std::string>& numbers) const;

 private:
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

/// The columns of a parameter's covariates: those compared with texts, and numbers.
struct CovariateColumns {
  std::set<std::string> factors{};
  std::set<std::string> numbers{};
};

CovariateColumns columns_of(const ParameterModel& parameter) {
  CovariateColumns columns;
  for (const Covariate& covariate : parameter.covariates) {
    for (const std::string& name : covariate.value.variables()) {
      data::TextMatch match;
      const bool is_factor = data::is_text_match(name, match);
      is_factor ? columns.factors.insert(match.column) : columns.numbers.insert(name);
    }
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
    const std::string name = parameter.coefficient_name(covariate);
    if (name.find('`') != std::string::npos) {
      throw UsageError(fmt::format("the coefficient {} has a backquote; rename the level", name),
                       {.column = "`means`"});
    }
    sum += fmt::format("{}{}*{}",
                       sum.empty() ? "" : " + ",
                       data::shortest(weight),
                       data::Expression::variable(name).text());
  }
  return data::Expression::parse(sum);
}

}  // namespace

std::vector<DerivedQuantity> marginal_means(const ModelSpecification& specification,
                                            const std::string& factor,
                                            const data::Table& table) {
  const ReferenceGrid grid(specification, table);
  std::vector<DerivedQuantity> means;
  std::set<std::string> factors;
  for (const ParameterModel& parameter : specification.parameters) {
    CovariateColumns columns = columns_of(parameter);
    factors.insert(columns.factors.begin(), columns.factors.end());
    if (!columns.factors.contains(factor)) continue;
    std::map<std::string, Names> levels;
    for (const std::string& column : columns.factors) levels[column] = grid.levels_of(column);
    for (const std::string& level : grid.levels_of(factor)) {
      levels[factor] = {level};
      means.push_back({.name = fmt::format("{} ({} {})", parameter.name, factor, level),
                       .value = mean_over(grid.combinations(levels, columns.numbers), parameter)});
    }
  }
  if (!means.empty()) return means;
  const Names known(factors.begin(), factors.end());
  throw UsageError(fmt::format("'{}' is not a factor of a sub-model{}",
                               factor,
                               known.empty() ? "" : "; factors: " + data::list_of(known)),
                   {.column = "`means`"});
}

}  // namespace silvafit::fit
