// SPDX-License-Identifier: MIT
#include "model/factor_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::fit {
namespace {

constexpr std::size_t kMostLevels = 200;
constexpr std::size_t kMostColumns = 400;

/// One of the columns that a variable contributes to a product.
struct Column {
  std::string label{};
  data::Expression value;
};

char lower(char byte) {
  return byte >= 'A' && byte <= 'Z' ? static_cast<char>(byte - 'A' + 'a') : byte;
}

/// The order of R's usual locales: without regard to case, small letters first among equals.
bool comes_before(std::string_view a, std::string_view b) {
  const bool is_less = std::ranges::lexicographical_compare(a, b, {}, lower, lower);
  if (is_less || std::ranges::lexicographical_compare(b, a, {}, lower, lower)) return is_less;
  return a > b;
}

bool is_number(std::string_view level) {
  double value = 0.0;
  return data::parse_number(level, value) || !data::with_decimal_point(level).empty();
}

void sort_levels(std::vector<std::string>& levels) {
  const auto number = [](const std::string& level) {
    double value = 0.0;
    return data::parse_number(level, value) ? value : data::kMissing;
  };
  const bool are_numbers =
      std::ranges::none_of(levels, [&](const auto& level) { return std::isnan(number(level)); });
  if (are_numbers) {
    std::ranges::stable_sort(levels, {}, number);
  } else {
    std::ranges::sort(levels, comes_before);
  }
}

/// A column of numbers and texts is probably an error, not a factor. Numbers that are texts all the
/// same come from a file with typing errors in other rows; in a table of R or Python, whose columns
/// have types, they are names.
void refuse_numbers(const data::TextColumn& labels,
                    const std::string& column,
                    const data::Table& table) {
  std::optional<std::size_t> number;
  std::optional<std::size_t> text;
  for (std::size_t row = 0; row < labels.size() && !(number && text); ++row) {
    if (labels.is_missing(row)) continue;
    std::optional<std::size_t>& first = is_number(labels[row]) ? number : text;
    if (!first) first = row;
  }
  if (!number || (!text && table.file().empty())) return;
  const std::size_t row = text.value_or(*number);
  const Place place = data::place_of(table, row, column);
  throw InputError(
      fmt::format("'{}' is {}; correct it, or write factor({}) if the values are names",
                  labels[row],
                  text ? "not a number, as other values are" : "text that looks like a number",
                  column),
      place);
}

std::vector<std::string> levels_of(const TermVariable& variable,
                                   std::string_view text,
                                   const data::Table& table,
                                   const std::vector<bool>& complete) {
  const data::TextColumn labels = table.labels(variable.column);
  if (!variable.is_factor) refuse_numbers(labels, variable.column, table);
  std::vector<bool> is_used(labels.levels().size(), false);
  for (std::size_t row = 0; row < complete.size(); ++row) {
    if (complete[row]) is_used[labels.code(row)] = true;
  }
  std::vector<std::string> levels;
  for (std::size_t code = 0; code < is_used.size(); ++code) {
    if (is_used[code]) levels.push_back(labels.levels()[code]);
  }
  if (levels.size() < 2) {
    throw InputError(
        fmt::format(
            "a factor needs at least two levels, and there is {}; remove {} from the sub-model {}",
            levels.empty() ? "none" : fmt::format("only '{}'", levels.front()),
            variable.label,
            text),
        {.file = table.file(), .column = variable.column});
  }
  if (levels.size() > kMostLevels) {
    throw InputError(fmt::format("has {} values; a factor may have at most {}. Use random effects "
                                 "(`random`) for many groups",
                                 levels.size(),
                                 kMostLevels),
                     {.file = table.file(), .column = variable.column});
  }
  sort_levels(levels);
  return levels;
}

/// The comparison of a column with a level, in parentheses, so that it can stand in products.
Column level_column(const std::string& column, const std::string& level, const data::Table& table) {
  const bool has_double = level.find('"') != std::string::npos;
  if (has_double && level.find('\'') != std::string::npos) {
    throw InputError(
        fmt::format("the value {} contains both kinds of quotes and cannot be written in a formula",
                    level),
        {.file = table.file(), .column = column});
  }
  const char quote = has_double ? '\'' : '"';
  const std::string label =
      fmt::format("({0} == {1}{2}{1})", data::Expression::variable(column).text(), quote, level);
  return {.label = label, .value = data::Expression::parse(label)};
}

/// Codes the factors of terms and multiplies their columns.
class Expansion {
 public:
  Expansion(const TermFormula& formula, std::string_view text) : formula_(formula), text_(text) {
    for (const TermVariable& variable : formula_.variables) {
      columns_.push_back({{.label = variable.label, .value = variable.value}});
    }
  }

  /// More coefficients than complete rows cannot be estimated.
  void set_rows(std::size_t complete, const std::string& file) {
    complete_ = complete;
    file_ = file;
  }

  /// Gives a variable a column for each level.
  void set_levels(std::size_t variable,
                  const std::vector<std::string>& levels,
                  const data::Table& table) {
    columns_[variable].clear();
    for (const std::string& level : levels) {
      columns_[variable].push_back(level_column(formula_.variables[variable].column, level, table));
    }
  }

  ParameterModel run() {
    ParameterModel model{.name = formula_.parameter, .has_intercept = formula_.has_intercept};
    if (model.has_intercept) covered_.insert(std::set<std::size_t>{});
    for (std::size_t t = 0; t < formula_.terms.size(); ++t) {
      const std::vector<bool> is_full = coding(t);
      require_new_columns(formula_.terms[t], is_full);
      add_products(formula_.terms[t], is_full, model);
    }
    return model;
  }

 private:
  bool is_factor(std::size_t variable) const { return columns_[variable].size() > 1; }

  /// R's rule (terms.formula, "Statistical Models in S", page 38): contrasts if the product without
  /// the factor is part of an earlier term, or empty; else a column for each level.
  /// \return for each variable of the term, whether all its levels have a column
  std::vector<bool> coding(std::size_t t) const {
    const Term& term = formula_.terms[t];
    std::vector<bool> is_full(term.size(), false);
    for (std::size_t k = 0; k < term.size(); ++k) {
      if (!is_factor(term[k])) continue;
      is_full[k] = term.size() > 1 && !is_in_earlier_term(term, term[k], t);
    }
    // Without intercept the first factor replaces it.
    if (!formula_.has_intercept && t == first_term_with_factor()) {
      const auto first = std::ranges::min_element(term, {}, [&](std::size_t variable) {
        return is_factor(variable) ? variable : columns_.size();
      });
      is_full[static_cast<std::size_t>(first - term.begin())] = true;
    }
    return is_full;
  }

  bool is_in_earlier_term(const Term& term, std::size_t without, std::size_t t) const {
    const auto begin = formula_.terms.begin();
    return std::any_of(begin, begin + static_cast<std::ptrdiff_t>(t), [&](const Term& earlier) {
      return std::ranges::all_of(term, [&](std::size_t variable) {
        return variable == without || std::ranges::find(earlier, variable) != earlier.end();
      });
    });
  }

  std::size_t first_term_with_factor() const {
    const auto found = std::ranges::find_if(formula_.terms, [&](const Term& term) {
      return std::ranges::any_of(term, [&](std::size_t variable) { return is_factor(variable); });
    });
    return static_cast<std::size_t>(found - formula_.terms.begin());
  }

  /// All levels of a factor are the sum of a constant and of its contrasts, so that a term
  /// represents one product of contrasts for each subset of its fully coded factors. A repeated
  /// product makes columns dependent; for these R has coefficients NA, and nlme stops.
  void require_new_columns(const Term& term, const std::vector<bool>& is_full) {
    std::vector<std::set<std::size_t>> products{{}};
    for (std::size_t k = 0; k < term.size(); ++k) {
      const std::size_t count = products.size();
      for (std::size_t i = 0; i < count; ++i) {
        if (is_full[k]) products.push_back(products[i]);
        products[i].insert(term[k]);
      }
    }
    for (std::set<std::size_t>& one : products) {
      if (covered_.insert(std::move(one)).second) continue;
      refuse_redundant(term);
    }
  }

  [[noreturn]] void refuse_redundant(const Term& term) const {
    std::vector<std::string> labels;
    for (const std::size_t variable : term) labels.push_back(formula_.variables[variable].label);
    const TermVariable& first = formula_.variables[term.front()];
    throw FormulaError(
        fmt::format(
            "the columns of {0} are linearly dependent on the {1}: R would code all levels and set "
            "one coefficient to NA; {2}",
            product_label(labels),
            formula_.has_intercept ? "intercept and the terms before it" : "terms before it",
            formula_.has_intercept
                ? fmt::format("write {} or begin with 0 +", fmt::join(labels, "*"))
                : "leave out a term that it contains"),
        text_,
        first.position);
  }

  /// The products of the columns of a term's variables, the first variable fastest.
  void add_products(const Term& term,
                    const std::vector<bool>& is_full,
                    ParameterModel& model) const {
    std::vector<std::vector<Column>> factors;
    std::size_t count = 1;
    for (std::size_t k = 0; k < term.size(); ++k) {
      const std::vector<Column>& all = columns_[term[k]];
      const bool drops_first = is_factor(term[k]) && !is_full[k];
      factors.emplace_back(all.begin() + (drops_first ? 1 : 0), all.end());
      count *= factors.back().size();
      if (count > kMostColumns) break;
    }
    const std::size_t intercept = model.has_intercept ? 1 : 0;
    check_count(intercept + model.covariates.size() + count,
                formula_.variables[term.front()].position);
    for (std::size_t number = 0; number < count; ++number) {
      model.covariates.push_back(product(factors, number));
    }
  }

  /// Called before the columns are computed, because many columns take time.
  void check_count(std::size_t columns, std::size_t position) const {
    if (columns > kMostColumns) {
      throw FormulaError(fmt::format("there are more than {} coefficients; use fewer terms, or "
                                     "random effects (`random`) for many groups",
                                     kMostColumns),
                         text_,
                         position);
    }
    if (!complete_ || columns <= *complete_) return;
    throw InputError(fmt::format("{} coefficients of {} need at least as many rows, but only {} "
                                 "have all values; use fewer terms, or random effects (`random`) "
                                 "for many groups",
                                 columns,
                                 text_,
                                 counted(*complete_, "row", "rows")),
                     {.file = file_});
  }

  static Covariate product(const std::vector<std::vector<Column>>& factors, std::size_t number) {
    std::vector<std::string> labels;
    data::Expression value = data::Expression::constant(1.0);
    for (const std::vector<Column>& columns : factors) {
      const Column& column = columns[number % columns.size()];
      number /= columns.size();
      labels.push_back(column.label);
      value = value * column.value;
    }
    return {.label = product_label(labels), .value = value};
  }

  const TermFormula& formula_;
  std::string_view text_;
  std::vector<std::vector<Column>> columns_;  ///< of each variable
  std::optional<std::size_t> complete_{};
  std::string file_{};
  std::set<std::set<std::size_t>> covered_;  ///< products of contrasts that have a column
};

bool is_factor(const TermVariable& variable, const data::Table& table) {
  return variable.is_factor || (!variable.column.empty() && !table.is_numeric(variable.column));
}

/// The effect of a combination of levels without rows cannot be estimated.
void require_rows(const ParameterModel& model,
                  const data::Table& table,
                  const std::vector<bool>& complete) {
  for (const Covariate& covariate : model.covariates) {
    const std::vector<std::string> names = covariate.value.variables();
    data::TextMatch match;
    const auto matches = std::ranges::count_if(
        names, [&](const std::string& name) { return data::is_text_match(name, match); });
    if (matches < 2) continue;
    const std::vector<double> values = data::evaluate(covariate.value, table);
    bool is_there = false;
    for (std::size_t row = 0; row < values.size(); ++row) {
      is_there = is_there || (complete[row] && values[row] != 0.0);
    }
    if (is_there) continue;
    throw InputError(
        fmt::format("no row has a value of {} other than 0, so {}:{} cannot be estimated; write "
                    "the comparisons that occur, or remove the interaction",
                    covariate.label,
                    model.name,
                    covariate.label),
        {.file = table.file()});
  }
}

}  // namespace

bool has_factor(const TermFormula& formula, const data::Table& table) {
  return std::ranges::any_of(
      formula.variables, [&](const TermVariable& variable) { return is_factor(variable, table); });
}

std::vector<bool> complete_rows(const std::vector<std::string>& columns, const data::Table& table) {
  std::vector<bool> complete(table.rows(), true);
  for (const std::string& column : columns) {
    if (table.is_numeric(column)) {
      const auto values = table.numbers(column);
      for (std::size_t row = 0; row < values.size(); ++row) {
        if (std::isnan(values[row])) complete[row] = false;
      }
    } else {
      const data::TextColumn& values = table.text(column);
      for (std::size_t row = 0; row < values.size(); ++row) {
        if (values.is_missing(row)) complete[row] = false;
      }
    }
  }
  return complete;
}

ParameterModel expanded(const TermFormula& formula,
                        std::string_view text,
                        const data::Table& table,
                        const std::vector<bool>& complete,
                        std::vector<std::string>& factors) {
  Expansion expansion(formula, text);
  if (has_factor(formula, table)) {
    expansion.set_rows(static_cast<std::size_t>(std::ranges::count(complete, true)), table.file());
  }
  for (std::size_t k = 0; k < formula.variables.size(); ++k) {
    const TermVariable& variable = formula.variables[k];
    if (!is_factor(variable, table)) continue;
    expansion.set_levels(k, levels_of(variable, text, table, complete), table);
    if (std::ranges::find(factors, variable.column) == factors.end()) {
      factors.push_back(variable.column);
    }
  }
  ParameterModel model = expansion.run();
  if (has_factor(formula, table)) require_rows(model, table, complete);
  return model;
}

ParameterModel expanded(const TermFormula& formula, std::string_view text) {
  for (const TermVariable& variable : formula.variables) {
    if (!variable.is_factor) continue;
    throw FormulaError(
        "factors need data, and there are none here; write comparisons such as (species == \"SM\")",
        text,
        variable.position);
  }
  return Expansion(formula, text).run();
}

}  // namespace silvafit::fit
