// SPDX-License-Identifier: MIT
#include "name_columns.hpp"

#include <algorithm>
#include <iterator>
#include <set>

#include "silvafit/data/expression.hpp"
#include "silvafit/fit/model_specification.hpp"

namespace silvafit::cli {
namespace {

struct Uses {
  std::set<std::string> as_numbers{};
  std::set<std::string> as_names{"plot", "tree", "species"};

  void add(const data::Expression& expression) {
    for (const std::string& variable : expression.variables()) {
      data::TextMatch match;
      if (data::is_text_match(variable, match)) {
        as_names.insert(match.column);
      } else {
        as_numbers.insert(variable);
      }
    }
  }
};

}  // namespace

std::vector<std::string> name_columns(const ColumnTexts& texts) {
  Uses uses;
  for (const std::string& text : texts.formulas) uses.add(data::parse_formula(text).right);
  if (!texts.where.empty()) uses.add(data::Expression::parse(texts.where));
  for (const std::string& text : texts.parameters) {
    const fit::SubModelColumns columns = fit::sub_model_columns(text);
    uses.as_numbers.insert(columns.as_numbers.begin(), columns.as_numbers.end());
    uses.as_names.insert(columns.as_names.begin(), columns.as_names.end());
  }
  if (!texts.random.empty()) {
    for (const fit::RandomEffects& effects : fit::parse_random_effects(texts.random)) {
      uses.as_names.insert(effects.group);
    }
  }
  if (!texts.variance.empty()) {
    for (const auto& factor : fit::parse_variance_function(texts.variance).factors) {
      if (!factor.column.empty()) uses.as_numbers.insert(factor.column);
      if (!factor.stratum.empty()) uses.as_names.insert(factor.stratum);
    }
  }
  std::vector<std::string> names;
  std::ranges::set_difference(uses.as_names, uses.as_numbers, std::back_inserter(names));
  return names;
}

}  // namespace silvafit::cli
