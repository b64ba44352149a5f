// SPDX-License-Identifier: MIT
#include "silvafit/fit/model_texts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "model/formula_advice.hpp"
#include "model/marginal_means.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/fit/formula_parts.hpp"

namespace silvafit::fit {
namespace {

void set_covariance(ModelSpecification& specification, const std::vector<std::string>& covariance) {
  if (covariance.empty()) return;
  std::vector<RandomEffects>& terms = specification.random;
  if (covariance.size() != 1 && covariance.size() != terms.size()) {
    throw UsageError(fmt::format("give one form of the covariance, or one for each of the {} "
                                 "groupings, not {}",
                                 terms.size(),
                                 covariance.size()),
                     {.column = "covariance"});
  }
  for (std::size_t i = 0; i < terms.size(); ++i) {
    terms[i].covariance = parse_covariance(covariance[covariance.size() == 1 ? 0 : i]);
  }
}

void require_column(const data::Table& table, const std::string& name) {
  if (table.has(name)) return;
  throw InputError(data::no_such_column(name, table.names()), {.file = table.file()});
}

/// Checks that columns which the model reads as numbers are numbers.
void require_columns(const ModelSpecification& specification, const data::Table& table) {
  std::vector<std::string> columns = specification.predictors();
  columns.push_back(specification.formula.left);
  for (const VarianceFactor& factor : specification.variance.factors) {
    if (!factor.column.empty()) {
      require_column(table, factor.column);
      columns.push_back(factor.column);
    }
    if (!factor.stratum.empty()) require_column(table, factor.stratum);
  }
  if (specification.correlation) {
    for (const std::string& column : specification.correlation->columns) {
      require_column(table, column);
      columns.push_back(column);
    }
    const std::string& group = specification.correlation->group;
    if (!group.empty()) require_column(table, group);
  }
  data::require_numeric(table, columns);
}

/// A formula of columns only, with bar terms, as R's lme4 has it.
void require_parameters(const FormulaParts& parts,
                        std::string_view text,
                        const data::Table& table) {
  if (parts.bars.empty()) return;
  const data::Formula formula = data::parse_formula(parts.fixed);
  for (const std::string& name : formula.right.variables()) {
    data::TextMatch match;
    if (!data::is_text_match(name, match) && !table.has(name)) return;
  }
  throw FormulaError(
      without_parameters(formula, parts.bars, table), text, text.find(parts.bars.front().text) + 1);
}

/// The random effects: those of the texts, or those of bar terms in the formula.
std::string random_text(const ModelTexts& texts,
                        const FormulaParts& parts,
                        const ModelSpecification& specification,
                        const data::Table& table) {
  if (parts.bars.empty()) return texts.random;
  const std::size_t position = texts.formula.find(parts.bars.front().text) + 1;
  if (!texts.random.empty()) {
    throw FormulaError(
        "there are random effects in the formula and by `random`; remove those in "
        "the formula",
        texts.formula,
        position);
  }
  std::vector<std::string> names;
  for (const ParameterModel& parameter : specification.parameters) names.push_back(parameter.name);
  const auto random = random_text_of(parts.bars, specification.formula.right, names, table);
  if (!random) throw FormulaError(unclear_bars(parts.bars, names), texts.formula, position);
  return *random;
}

void add_derived(const ModelTexts& texts,
                 const data::Table& table,
                 ModelSpecification& specification) {
  std::vector<DerivedQuantity>& derived = specification.derived;
  const auto is_known = [&derived](const std::string& name) {
    return std::ranges::find(derived, name, &DerivedQuantity::name) != derived.end();
  };
  for (const std::string& text : texts.derived) {
    DerivedQuantity added = parse_derived_quantity(text, specification.coefficient_names());
    if (is_known(added.name)) {
      throw FormulaError(fmt::format("'{}' is given twice", added.name), text, 1);
    }
    derived.push_back(std::move(added));
  }
  for (const std::string& factor : texts.means) {
    for (DerivedQuantity& mean : marginal_means(specification, factor, table)) {
      if (is_known(mean.name)) {
        throw UsageError(fmt::format("'{}' is given twice", factor), {.column = "`means`"});
      }
      derived.push_back(std::move(mean));
    }
  }
}

}  // namespace

ModelSpecification specify_model(const ModelTexts& texts, const data::Table& table) {
  const FormulaParts parts = split_formula(texts.formula);
  require_parameters(parts, texts.formula, table);
  ModelSpecification specification =
      specify_model(parts.fixed, texts.sub_models, table, texts.columns);
  for (const std::string& factor : texts.factors) {
    const bool is_known =
        std::ranges::find(specification.factors, factor) != specification.factors.end();
    if (!is_known) specification.factors.push_back(factor);
  }
  specification.data_columns = texts.columns.empty() ? table.names() : texts.columns;
  const std::string random = random_text(texts, parts, specification, table);
  if (!random.empty()) add_random_effects(specification, random, table);
  set_covariance(specification, texts.covariance);
  if (!texts.variance.empty()) {
    specification.variance = parse_variance_function(texts.variance);
  }
  if (!texts.correlation.empty() && texts.correlation != "none") {
    specification.correlation = parse_correlation(texts.correlation);
  }
  check_response(specification, table);
  require_columns(specification, table);
  add_derived(texts, table, specification);
  return specification;
}

}  // namespace silvafit::fit
