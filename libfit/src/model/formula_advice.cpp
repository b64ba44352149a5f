// SPDX-License-Identifier: MIT
#include "model/formula_advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/data/expression_parts.hpp"
#include "text/text_parts.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;
using Names = std::vector<std::string>;

bool is_among(const std::string& name, const Names& names) {
  return std::ranges::find(names, name) != names.end();
}

/// The parameter by which the mean has this derivative; no value unless there is exactly one.
std::optional<std::string> parameter_of_effect(const Expression& effect,
                                               const Expression& mean,
                                               const Names& parameters) {
  std::optional<std::string> found;
  for (const std::string& name : parameters) {
    if (mean.derivative(name).text() != effect.text()) continue;
    if (found) return std::nullopt;
    found = name;
  }
  return found;
}

/// The effects of a bar term. An intercept is implied, as in lme4, unless a term is 0 or -1 or all
/// terms are parameters, as in nlmer.
struct Effects {
  std::vector<Expression> terms{};
  bool has_intercept = true;
};

/// No value if a term has another meaning in R than in arithmetic.
std::optional<Effects> effects_of(const BarTerm& bar, const Names& parameters) {
  const std::string& text = bar.effects;
  if (text.find_first_of("*/^:|") != std::string::npos) return std::nullopt;
  Effects effects;
  bool are_parameters = true;
  for (const Part part : split(text, 0, text.size(), '+')) {
    if (of(text, part) == "0") effects.has_intercept = false;
  }
  for (const Expression& term : summands(Expression::parse(text))) {
    if (term.is_constant()) {
      are_parameters = false;
      if (term.constant_value() == -1.0) effects.has_intercept = false;
      continue;
    }
    are_parameters = are_parameters && is_among(term.text(), parameters);
    effects.terms.push_back(term);
  }
  if (are_parameters && !effects.terms.empty()) effects.has_intercept = false;
  return effects;
}

/// The coefficients of a bar term.
std::optional<Names> coefficients_of(const BarTerm& bar,
                                     const Expression& mean,
                                     const Names& parameters) {
  const std::optional<Effects> effects = effects_of(bar, parameters);
  if (!effects) return std::nullopt;
  Names result;
  std::vector<Expression> terms = effects->terms;
  if (effects->has_intercept) terms.insert(terms.begin(), Expression::constant(1.0));
  for (const Expression& term : terms) {
    const bool is_parameter = is_among(term.text(), parameters);
    const auto name =
        is_parameter ? std::optional(term.text()) : parameter_of_effect(term, mean, parameters);
    if (!name || is_among(*name, result)) return std::nullopt;
    result.push_back(*name);
  }
  if (result.empty()) return std::nullopt;
  return result;
}

/// One grouping of the text, its effects in blocks without correlations between them.
struct BarGrouping {
  std::string group{};
  Names blocks{};
};

void add_blocks(const BarTerm& bar, const Names& coefficients, BarGrouping& grouping) {
  if (bar.is_uncorrelated) {
    for (const std::string& name : coefficients) grouping.blocks.push_back(name);
  } else {
    grouping.blocks.push_back(fmt::format("{}", fmt::join(coefficients, " + ")));
  }
}

/// stand:plot beside stand is plot within stand, stand/plot.
std::string group_text(const BarTerm& bar, const std::vector<BarTerm>& bars) {
  const std::size_t colon = bar.group.find(':');
  if (colon == std::string::npos) return bar.group;
  const Part outer = trimmed(bar.group, 0, colon);
  const bool has_outer = std::ranges::any_of(
      bars, [&](const BarTerm& other) { return other.group == of(bar.group, outer); });
  if (!has_outer) return bar.group;
  const Part inner = trimmed(bar.group, colon + 1, bar.group.size());
  return fmt::format("{}/{}", of(bar.group, outer), of(bar.group, inner));
}

/// Groups of several columns are the finest ones.
std::size_t group_levels(const std::string& group, const data::Table& table) {
  if (group.find_first_of("/:") != std::string::npos) return table.rows();
  return table.has(group) ? table.labels(group).levels().size() : 0;
}

std::string grouping_text(const BarGrouping& grouping) {
  if (grouping.blocks.size() == 1)
    return fmt::format("{} | {}", grouping.blocks[0], grouping.group);
  return fmt::format("({}) | {}", fmt::join(grouping.blocks, ") + ("), grouping.group);
}

/// Names b0, b1, ... that are not columns.
std::string parameter_name(std::size_t number, const data::Table& table) {
  std::string name = fmt::format("b{}", number);
  while (table.has(name)) name += '_';
  return name;
}

/// A linear model: its formula, the names of its parameters and its factors.
struct LinearModel {
  std::string right{};
  Names parameters{};
  Names factors{};
};

void add_term(const std::string& term, const data::Table& table, LinearModel& model) {
  model.parameters.push_back(parameter_name(model.parameters.size(), table));
  const std::string& name = model.parameters.back();
  if (!model.right.empty()) model.right += " + ";
  model.right += term.empty() ? name : fmt::format("{}*{}", name, term);
}

/// In R's formulas x*z has the effects of x, z and their product.
std::vector<Expression> terms_of(const Expression& summand) {
  const std::vector<Expression> parts = data::factors(summand);
  const bool is_pair = parts.size() == 2 && data::is_name(parts[0]) && data::is_name(parts[1]) &&
                       parts[0].text() != parts[1].text();
  if (!is_pair) return {summand};
  return {parts[0], parts[1], parts[0] * parts[1]};
}

std::string as_factor(const Expression& term) {
  // A sum of columns in I() or a function is one term.
  const bool is_sum = data::summands(term).size() > 1;
  return is_sum ? fmt::format("({})", term.text()) : term.text();
}

LinearModel linear_model(const Expression& right, const data::Table& table) {
  LinearModel model;
  std::vector<Expression> terms;
  bool has_intercept = true;
  for (const Expression& summand : data::summands(right)) {
    if (summand.is_constant()) {
      if (summand.constant_value() == -1.0) has_intercept = false;
    } else {
      for (const Expression& term : terms_of(summand)) terms.push_back(term);
    }
  }
  if (has_intercept) add_term("", table, model);
  Names known;
  for (const Expression& term : terms) {
    const std::string text = as_factor(term);
    if (is_among(text, known)) continue;
    known.push_back(text);
    const bool is_factor = data::is_name(term) && table.has(text) && !table.is_numeric(text);
    if (is_factor) {
      model.factors.push_back(text);
    } else {
      add_term(text, table, model);
    }
  }
  if (model.parameters.empty()) add_term("", table, model);
  return model;
}

}  // namespace

std::optional<std::string> random_text_of(const std::vector<BarTerm>& bars,
                                          const Expression& mean,
                                          const Names& parameters,
                                          const data::Table& table) {
  std::vector<BarGrouping> groupings;
  for (const BarTerm& bar : bars) {
    const auto coefficients = coefficients_of(bar, mean, parameters);
    const std::string group = group_text(bar, bars);
    if (!coefficients) return std::nullopt;
    auto grouping = std::ranges::find(groupings, group, &BarGrouping::group);
    if (grouping == groupings.end()) {
      groupings.push_back({.group = group});
      grouping = groupings.end() - 1;
    }
    add_blocks(bar, *coefficients, *grouping);
  }
  // The coarser grouping is first.
  std::ranges::stable_sort(groupings, {}, [&](const BarGrouping& grouping) {
    return group_levels(grouping.group, table);
  });
  if (groupings.size() == 1) return grouping_text(groupings.front());
  std::string text;
  for (const BarGrouping& grouping : groupings) {
    text += fmt::format("{}({})", text.empty() ? "" : "; ", grouping_text(grouping));
  }
  return text;
}

std::string without_parameters(const data::Formula& formula,
                               const std::vector<BarTerm>& bars,
                               const data::Table& table) {
  const LinearModel model = linear_model(formula.right, table);
  std::string call = fmt::format("{} ~ {}", formula.left, model.right);
  if (!model.factors.empty()) {
    call += fmt::format(
        " with `parameters={} ~ {}`", model.parameters.front(), fmt::join(model.factors, " + "));
  }
  if (!bars.empty()) {
    const auto random =
        random_text_of(bars, Expression::parse(model.right), model.parameters, table);
    call += fmt::format(" {} `random={}`",
                        model.factors.empty() ? "with" : "and",
                        random.value_or(model.parameters.front() + " | " + bars.front().group));
  }
  return fmt::format(
      "every name in the formula is a column, so that there is nothing to estimate; "
      "the parameters are written out, as in R's nls: {}",
      call);
}

std::string unclear_bars(const std::vector<BarTerm>& bars, const Names& parameters) {
  return fmt::format(
      "{0} is not the effect of one coefficient; remove it from the formula and name the "
      "coefficients that vary between the groups, such as `random={1} | {2}` (coefficients: "
      "{3})",
      bars.front().text,
      parameters.front(),
      bars.front().group,
      fmt::join(parameters, ", "));
}

}  // namespace silvafit::fit
