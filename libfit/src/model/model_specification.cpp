// SPDX-License-Identifier: MIT
#include "silvafit/fit/model_specification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <set>
#include <utility>

#include "model/factor_columns.hpp"
#include "model/formula_advice.hpp"
#include "model/held_coefficients.hpp"
#include "model/sub_model_terms.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/expression_parts.hpp"
#include "silvafit/fit/response.hpp"
#include "text/text_parts.hpp"

namespace silvafit::fit {
namespace {

/// A column of a model in its stored form: `:` is the product, all else is arithmetic.
Covariate stored_covariate(std::string_view text, Part part) {
  std::string with_products(text);
  Quotes quotes;
  for (std::size_t i = part.begin; i < part.end; ++i) {
    if (!quotes.cover(text[i]) && text[i] == ':') with_products[i] = '*';
  }
  return {.label = std::string(of(text, part)),
          .value = data::Expression::parse(with_products, part.begin, part.end)};
}

/// The columns that a variable of an expression is read from: its own, or one compared with text.
std::string column_of(const std::string& variable) {
  data::TextMatch match;
  return data::is_text_match(variable, match) ? match.column : variable;
}

bool equal_but_for_case(std::string_view a, std::string_view b) {
  const auto lower = [](char byte) { return std::tolower(static_cast<unsigned char>(byte)); };
  return std::ranges::equal(a, b, {}, lower, lower);
}

/// A missing column is an input error, not a usage error; the position in the text is shown as for
/// other errors.
[[noreturn]] void refuse_missing_column(std::string_view name,
                                        std::string_view text,
                                        std::size_t position,
                                        const data::Table& table) {
  const FormulaError shown(data::no_such_column(name, table.names()), text, position);
  throw InputError(shown.what(), {.file = table.file()});
}

void check_parameter_name(const std::string& name,
                          std::string_view formula,
                          const std::vector<std::string>& columns) {
  // Single letters are the usual names of parameters: c beside a column C is not a typing error.
  if (name.size() == 1) return;
  for (const std::string& column : columns) {
    if (!equal_but_for_case(column, name)) continue;
    throw FormulaError(fmt::format("unknown column '{}'; did you mean '{}'?", name, column),
                       formula,
                       formula.find(name, formula.find('~')) + 1);
  }
}

void check_columns(const TermFormula& formula, std::string_view text, const data::Table& table) {
  for (const TermVariable& variable : formula.variables) {
    for (const std::string& name : variable.value.variables()) {
      const std::string column = column_of(name);
      if (table.has(column)) continue;
      refuse_missing_column(column, text, text.find(column, variable.position - 1) + 1, table);
    }
  }
}

/// Adds sub-models to a model: their terms become columns, for which factors need the data.
class SubModels {
 public:
  SubModels(ModelSpecification& model,
            const std::vector<std::string>& texts,
            const data::Table& table)
      : model_(model), texts_(texts), table_(table) {
    for (const std::string& text : texts) {
      formulas_.push_back(parse_terms(text));
      static_cast<void>(target(formulas_.back(), text));
      check_columns(formulas_.back(), text, table);
    }
  }

  void add() {
    const bool needs_rows = std::ranges::any_of(
        formulas_, [this](const TermFormula& formula) { return has_factor(formula, table_); });
    std::vector<bool> complete;
    if (needs_rows) complete = complete_rows(columns(), table_);
    for (std::size_t k = 0; k < texts_.size(); ++k) {
      target(formulas_[k], texts_[k]) =
          expanded(formulas_[k], texts_[k], table_, complete, model_.factors);
    }
  }

 private:
  ParameterModel& target(const TermFormula& formula, const std::string& text) const {
    const auto found =
        std::ranges::find(model_.parameters, formula.parameter, &ParameterModel::name);
    if (found != model_.parameters.end()) return *found;
    throw FormulaError(
        fmt::format(
            "unknown parameter '{}' of the formula {}", formula.parameter, model_.formula.text),
        text,
        1);
  }

  /// Columns that must have a value in each row that is used for the mean.
  std::vector<std::string> columns() const {
    std::vector<std::string> names = model_.predictors();
    names.push_back(model_.formula.left);
    for (const TermFormula& formula : formulas_) {
      for (const TermVariable& variable : formula.variables) {
        for (const std::string& name : variable.value.variables()) names.push_back(name);
      }
    }
    for (std::string& name : names) name = column_of(name);
    std::erase_if(names, [this](const std::string& name) { return !table_.has(name); });
    return names;
  }

  ModelSpecification& model_;
  const std::vector<std::string>& texts_;
  const data::Table& table_;
  std::vector<TermFormula> formulas_;
};

void check_random_effects(const RandomEffects& random,
                          const ModelSpecification& specification,
                          std::string_view text,
                          const data::Table& table) {
  const std::vector<std::string> known = specification.coefficient_names();
  std::size_t position = 0;
  const auto& effects = random.coefficients;
  for (auto effect = effects.begin(); effect != effects.end(); ++effect) {
    position = text.find(*effect, position);
    if (std::ranges::find(known, *effect) == known.end()) {
      throw FormulaError(no_such_coefficient(specification, *effect, known), text, position + 1);
    }
    if (std::find(effects.begin(), effect, *effect) != effect) {
      throw FormulaError(fmt::format("'{}' is given twice", *effect), text, position + 1);
    }
    position += effect->size();
  }
  std::vector<std::string> columns = random.within;
  columns.push_back(random.group);
  for (const std::string& column : columns) {
    if (!table.has(column)) refuse_missing_column(column, text, text.rfind(column) + 1, table);
  }
}

/// The labels of one column that occur together with several labels of another.
struct RecurringLabels {
  std::size_t labels = 0;     ///< of the column
  std::size_t recurring = 0;  ///< of these
  bool is_complete = true;    ///< whether each occurs with all labels of the other column
  std::string label{};        ///< the first recurring one
  std::string first{};        ///< two that it occurs with
  std::string second{};
};

RecurringLabels recurring_labels(const data::TextColumn& inner, const data::TextColumn& outer) {
  std::vector<std::set<std::uint32_t>> with(inner.levels().size());
  std::set<std::uint32_t> all;
  for (std::size_t row = 0; row < inner.size(); ++row) {
    if (inner.is_missing(row) || outer.is_missing(row)) continue;
    with[inner.code(row)].insert(outer.code(row));
    all.insert(outer.code(row));
  }
  RecurringLabels result;
  for (std::size_t code = 0; code < with.size(); ++code) {
    const std::set<std::uint32_t>& found = with[code];
    if (found.empty()) continue;
    ++result.labels;
    if (found.size() < all.size()) result.is_complete = false;
    if (found.size() < 2) continue;
    if (++result.recurring > 1) continue;
    result.label = inner.levels()[code];
    result.first = outer.levels()[*found.begin()];
    result.second = outer.levels()[*std::next(found.begin())];
  }
  return result;
}

/// The text of two nested terms, such as "a | stand/plot" or "a | stand; a + b | stand/plot".
std::string nested_text(const RandomEffects& coarser, const RandomEffects& finer) {
  const std::string groups = coarser.group + "/" + finer.group;
  if (coarser.text() == finer.text()) return finer.text() + " | " + groups;
  return fmt::format("{} | {}; {} | {}", coarser.text(), coarser.group, finer.text(), groups);
}

std::string crossed_text(const RandomEffects& first, const RandomEffects& second) {
  if (first.text() == second.text()) {
    return fmt::format("{} | {} + {}", first.text(), first.group, second.group);
  }
  return fmt::format(
      "({} | {}) + ({} | {})", first.text(), first.group, second.text(), second.group);
}

/// "yr recurs in every site".
std::string recurrence_text(const RecurringLabels& found,
                            const std::string& finer,
                            const std::string& coarser) {
  if (found.is_complete) return fmt::format("{} recurs in every {}", finer, coarser);
  return fmt::format("{} of {} labels of {} recur in several groups of {}",
                     found.recurring,
                     found.labels,
                     finer,
                     coarser);
}

/// A list of three or more groupings, `a | region; a | stand; a | plot`, may be meant as nested
/// levels, as nlme's lists are, unless labels do not recur.
void check_list(const std::vector<RandomEffects>& terms,
                std::string_view text,
                const data::Table& table) {
  const bool is_list = split(text, 0, text.size(), ';').size() == terms.size();
  if (!is_list || are_bars(text)) return;
  std::vector<std::string> columns;
  std::vector<std::string> bars;
  for (const RandomEffects& term : terms) {
    columns.push_back(term.group);
    bars.push_back(fmt::format("({} | {})", term.text(), term.group_text()));
  }
  for (std::size_t t = 1; t < terms.size(); ++t) {
    if (!terms[t].within.empty()) continue;
    const RecurringLabels found =
        recurring_labels(table.labels(columns[t]), table.labels(columns[t - 1]));
    if (found.recurring == 0) continue;
    throw FormulaError(
        fmt::format("{}: nested levels are written with all columns, as in `{} | {}`, and crossed "
                    "groups in parentheses, `{}`",
                    recurrence_text(found, columns[t], columns[t - 1]),
                    terms[t].text(),
                    fmt::join(columns, "/"),
                    fmt::join(bars, "; ")),
        text,
        text.rfind(columns[t]) + 1);
  }
}

/// Labels of the finer grouping that recur in several of the coarser groups are those of crossed
/// effects if the terms are written as lme4 does; else either may be meant, and has to be written.
void decide_nesting(std::vector<RandomEffects>& terms,
                    std::string_view text,
                    const data::Table& table) {
  if (terms.size() > 2) return check_list(terms, text, table);
  if (terms.size() < 2 || are_crossed(terms) || !terms.back().within.empty()) return;
  const RandomEffects& coarser = terms.front();
  const RandomEffects& finer = terms.back();
  const data::TextColumn outer = table.labels(coarser.group);
  const data::TextColumn inner = table.labels(finer.group);
  const RecurringLabels found = recurring_labels(inner, outer);
  if (found.recurring == 0) return;
  if (are_bars(text)) {
    for (RandomEffects& term : terms) term.is_crossed = true;
    return;
  }
  const std::size_t position = text.rfind(finer.group) + 1;
  if (recurring_labels(outer, inner).recurring == 0) {
    throw FormulaError(fmt::format("each group of {0} is in one of {1}, so {1} is the coarser "
                                   "grouping; write it first: `{2}`",
                                   coarser.group,
                                   finer.group,
                                   nested_text(finer, coarser)),
                       text,
                       position);
  }
  throw FormulaError(
      fmt::format(
          "{}: for {} within {}, where '{}' in '{}' and in '{}' are different groups, write "
          "`{}`; if it is the same group everywhere (crossed random effects), `{}`",
          recurrence_text(found, finer.group, coarser.group),
          finer.group,
          coarser.group,
          found.label,
          found.first,
          found.second,
          nested_text(coarser, finer),
          crossed_text(coarser, finer)),
      text,
      position);
}

}  // namespace

std::vector<std::string> ParameterModel::coefficient_names() const {
  std::vector<std::string> names;
  if (has_intercept) names.push_back(name);
  for (const Covariate& covariate : covariates) names.push_back(coefficient_name(covariate));
  return names;
}

std::string ParameterModel::text() const {
  std::string result = has_intercept ? "1" : "0";
  for (const Covariate& covariate : covariates) result += " + " + covariate.label;
  return result;
}

std::vector<std::string> ModelSpecification::coefficient_names() const {
  std::vector<std::string> names;
  for (const ParameterModel& parameter : parameters) {
    for (std::string& name : parameter.coefficient_names()) names.push_back(std::move(name));
  }
  return names;
}

std::vector<std::string> ModelSpecification::random_only_names() const {
  std::vector<std::string> names;
  for (const ParameterModel& parameter : parameters) {
    for (const Covariate& covariate : parameter.random_only) {
      names.push_back(parameter.coefficient_name(covariate));
    }
  }
  return names;
}

std::vector<std::string> ModelSpecification::label_columns() const {
  std::vector<std::string> numbers;
  std::vector<std::string> labels;
  const auto add = [](const std::string& name, std::vector<std::string>& names) {
    if (!name.empty() && std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  for (const std::string& variable : predictors()) {
    data::TextMatch match;
    const bool is_match = data::is_text_match(variable, match);
    add(is_match ? match.column : variable, is_match ? labels : numbers);
  }
  for (const VarianceFactor& factor : variance.factors) {
    add(factor.column, numbers);
    add(factor.stratum, labels);
  }
  if (correlation) {
    for (const std::string& column : correlation->columns) add(column, numbers);
    add(correlation->group, labels);
  }
  for (const RandomEffects& term : random) {
    for (const std::string& column : term.within) add(column, labels);
    add(term.group, labels);
  }
  std::erase_if(labels, [&](const std::string& name) {
    return std::ranges::find(numbers, name) != numbers.end();
  });
  return labels;
}

std::vector<std::string> ModelSpecification::predictors() const {
  std::vector<std::string> names;
  const auto add = [&names](const std::string& name) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  for (const std::string& name : formula.right.variables()) {
    if (std::ranges::find(parameters, name, &ParameterModel::name) == parameters.end()) add(name);
  }
  for (const ParameterModel& parameter : parameters) {
    for (const auto* const covariates : {&parameter.covariates, &parameter.random_only}) {
      for (const Covariate& covariate : *covariates) {
        for (const std::string& name : covariate.value.variables()) add(name);
      }
    }
  }
  return names;
}

ParameterModel parse_parameter_model(std::string_view text) {
  return expanded(parse_terms(text), text);
}

ParameterModel parse_stored_parameter_model(const std::string& name, std::string_view columns) {
  ParameterModel model{.name = name};
  for (const Part part : split(columns, 0, columns.size(), '+')) {
    const std::string_view term = of(columns, part);
    if (term.empty()) throw FormulaError("expected a covariate", columns, part.begin + 1);
    if (term == "0" || term == "1") {
      model.has_intercept = term == "1";
    } else {
      model.covariates.push_back(stored_covariate(columns, part));
    }
  }
  if (!model.has_intercept && model.covariates.empty()) {
    throw FormulaError("a sub-model needs an intercept or a covariate", columns, 1);
  }
  return model;
}

SubModelColumns sub_model_columns(std::string_view text) {
  SubModelColumns result;
  for (const TermVariable& variable : parse_terms(text).variables) {
    for (const std::string& name : variable.value.variables()) {
      const std::string column = column_of(name);
      const bool is_name = variable.is_factor || column != name;
      (is_name ? result.as_names : result.as_numbers).push_back(column);
    }
  }
  return result;
}

ModelSpecification specify_model(std::string_view formula,
                                 const std::vector<std::string>& sub_models,
                                 const data::Table& table,
                                 const std::vector<std::string>& columns) {
  data::refuse_column_pi(formula, table.names());
  for (const std::string& text : sub_models) data::refuse_column_pi(text, table.names());
  ModelSpecification specification{.formula = data::parse_formula(formula)};
  for (const std::string& name : specification.formula.right.variables()) {
    data::TextMatch match;
    if (data::is_text_match(name, match) || table.has(name)) continue;
    check_parameter_name(name, formula, columns.empty() ? table.names() : columns);
    specification.parameters.push_back({.name = name});
  }
  for (const data::NamePlace& place : data::vanished_names(formula)) {
    if (table.has(place.name)) continue;
    throw FormulaError(
        fmt::format("the value does not depend on '{}' here; leave it out", place.name),
        formula,
        place.position);
  }
  if (specification.parameters.empty()) {
    throw FormulaError(
        without_parameters(specification.formula, {}, table), formula, formula.find('~') + 1);
  }
  SubModels(specification, sub_models, table).add();
  return specification;
}

void check_response(const ModelSpecification& specification, const data::Table& table) {
  const data::Formula& formula = specification.formula;
  const std::vector<std::string> own = response_columns(formula.left);
  std::vector<std::string> read = specification.predictors();
  std::ranges::move(specification.label_columns(), std::back_inserter(read));
  for (const VarianceFactor& factor : specification.variance.factors) read.push_back(factor.column);
  if (const auto& correlation = specification.correlation) {
    std::ranges::copy(correlation->columns, std::back_inserter(read));
  }
  const auto is_read = [&read](const std::string& name) {
    return std::ranges::find(read, name) != read.end();
  };
  // A column may predict its ratio to another one.
  if (is_read(formula.left) || (own.size() == 1 && is_read(own.front()))) {
    throw FormulaError(
        fmt::format("'{}' cannot predict itself; remove it from the right-hand side, "
                    "the sub-models, the groups, and the functions of the variance "
                    "and the correlation",
                    own.size() == 1 ? own.front() : formula.left),
        formula.text,
        formula.text.find(formula.left) + 1);
  }
  if (table.has(formula.left)) return;
  for (const std::string& name : own) {
    if (!table.has(name)) {
      refuse_missing_column(name, formula.text, formula.text.find(name) + 1, table);
    }
  }
}

void add_random_effects(ModelSpecification& specification,
                        std::string_view text,
                        const data::Table& table) {
  std::vector<RandomEffects> terms = parse_random_effects(text);
  for (const RandomEffects& term : terms) {
    check_random_effects(term, specification, text, table);
  }
  decide_nesting(terms, text, table);
  specification.random = std::move(terms);
}

}  // namespace silvafit::fit
