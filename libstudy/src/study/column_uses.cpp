// SPDX-License-Identifier: MIT
#include "silvafit/study/column_uses.hpp"

#include <algorithm>
#include <iterator>

#include "silvafit/data/expression.hpp"
#include "silvafit/fit/formula_parts.hpp"
#include "silvafit/fit/model_specification.hpp"
#include "silvafit/fit/response.hpp"

namespace silvafit::study {
namespace {

void add_uses(const data::Expression& expression, ColumnUses& uses) {
  for (const std::string& variable : expression.variables()) {
    data::TextMatch match;
    if (data::is_text_match(variable, match)) {
      uses.as_names.insert(match.column);
    } else {
      uses.as_numbers.insert(variable);
    }
  }
}

void add_uses(const std::vector<fit::BarTerm>& bars, ColumnUses& uses) {
  for (const fit::BarTerm& bar : bars) {
    add_uses(data::Expression::parse(bar.effects), uses);
    for (const std::string& column : bar.group_columns()) uses.as_names.insert(column);
  }
}

}  // namespace

ColumnUses column_uses(const ColumnTexts& texts) {
  ColumnUses uses;
  for (const std::string& text : texts.formulas) {
    const fit::FormulaParts parts = fit::split_formula(text);
    add_uses(parts.bars, uses);
    const data::Formula formula = data::parse_formula(parts.fixed);
    uses.as_numbers.insert(formula.left);
    for (const std::string& column : fit::response_columns(formula.left)) {
      uses.as_numbers.insert(column);
    }
    add_uses(formula.right, uses);
  }
  if (!texts.where.empty()) add_uses(data::Expression::parse(texts.where), uses);
  for (const std::string& text : texts.parameters) {
    const fit::SubModelColumns columns = fit::sub_model_columns(text);
    uses.as_numbers.insert(columns.as_numbers.begin(), columns.as_numbers.end());
    uses.as_names.insert(columns.as_names.begin(), columns.as_names.end());
  }
  if (!texts.random.empty()) {
    for (const fit::RandomEffects& effects : fit::parse_random_effects(texts.random)) {
      uses.as_names.insert(effects.group);
      uses.as_names.insert(effects.within.begin(), effects.within.end());
    }
  }
  if (!texts.variance.empty()) {
    for (const auto& factor : fit::parse_variance_function(texts.variance).factors) {
      if (!factor.column.empty()) uses.as_numbers.insert(factor.column);
      if (!factor.stratum.empty()) uses.as_names.insert(factor.stratum);
    }
  }
  if (!texts.correlation.empty() && texts.correlation != "none") {
    const fit::Correlation correlation = fit::parse_correlation(texts.correlation);
    uses.as_numbers.insert(correlation.columns.begin(), correlation.columns.end());
    if (!correlation.group.empty()) uses.as_names.insert(correlation.group);
  }
  return uses;
}

std::vector<std::string> name_columns(const ColumnTexts& texts) {
  ColumnUses uses = column_uses(texts);
  uses.as_names.insert({"plot", "tree", "species"});
  std::vector<std::string> names;
  std::ranges::set_difference(uses.as_names, uses.as_numbers, std::back_inserter(names));
  return names;
}

}  // namespace silvafit::study
