// SPDX-License-Identifier: MIT
#include "prediction/fitted_labels.hpp"

#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/expression.hpp"

namespace silvafit::study {

void unify_spelling(const std::string& column,
                    const std::vector<std::string>& known_labels,
                    data::Table& table) {
  const std::set<std::string_view> known(known_labels.begin(), known_labels.end());
  const data::TextColumn labels = table.labels(column);
  data::TextColumn unified;
  for (std::size_t row = 0; row < labels.size(); ++row) {
    double number = 0.0;
    if (labels.is_missing(row)) {
      unified.append_missing();
    } else if (!known.contains(labels[row]) && data::parse_number(labels[row], number) &&
               known.contains(data::shortest(number))) {
      unified.append(data::shortest(number));
    } else {
      unified.append(labels[row]);
    }
  }
  table.set(column, std::move(unified));
}

void unify_spelling(const fit::FittedModel& fit, data::Table& table) {
  for (const fit::VarianceFactorEstimate& factor : fit.variance.factors) {
    const std::string& column = factor.factor.stratum;
    if (table.has(column)) unify_spelling(column, factor.strata, table);
  }
  std::map<std::string, std::vector<std::string>> known;
  for (const fit::ColumnLevels& levels : fit.levels) known[levels.column] = levels.labels;
  for (const std::string& variable : fit.specification.predictors()) {
    data::TextMatch match;
    if (data::is_text_match(variable, match)) known[match.column].push_back(match.value);
  }
  for (const auto& [column, labels] : known) {
    if (table.has(column) && !table.is_numeric(column)) unify_spelling(column, labels, table);
  }
}

std::vector<bool> has_unknown_label(const fit::ColumnLevels& levels, const data::Table& table) {
  const std::set<std::string_view> known(levels.labels.begin(), levels.labels.end());
  const data::TextColumn labels = table.labels(levels.column);
  std::vector<bool> is_unknown;
  for (const std::string& label : labels.levels()) is_unknown.push_back(!known.contains(label));
  std::vector<bool> result(table.rows(), false);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    result[row] = !labels.is_missing(row) && is_unknown[labels.code(row)];
  }
  return result;
}

}  // namespace silvafit::study
