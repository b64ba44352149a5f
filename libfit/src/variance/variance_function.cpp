// SPDX-License-Identifier: MIT
#include "silvafit/fit/variance_function.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/program.hpp"
#include "text/text_parts.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

using Eigen::ArrayXd;

std::vector<std::string_view> names_of_kinds() {
  std::vector<std::string_view> names;
  for (const VarianceKind* const kind : variance_kinds()) names.push_back(kind->name());
  return names;
}

VarianceFactor::Kind parse_kind(std::string_view text, Part part) {
  const std::vector<std::string_view> names = names_of_kinds();
  const auto found = std::ranges::find(names, of(text, part));
  if (found == names.end()) {
    throw FormulaError(fmt::format("unknown variance function '{}'; available: none, {}",
                                   of(text, part),
                                   fmt::join(names, ", ")),
                       text,
                       part.begin + 1);
  }
  return static_cast<VarianceFactor::Kind>(found - names.begin());
}

/// Reads `delta = 0.5`.
void hold_parameter(std::string_view text, Part part, VarianceFactor& factor) {
  const std::size_t sign = text.substr(0, part.end).find('=', part.begin);
  const std::string_view name = of(text, trimmed(text, part.begin, sign));
  const bool has_delta = kind_of(factor).has_delta();
  const bool has_constant = kind_of(factor).has_constant();
  double value = 0.0;
  const std::string_view digits = of(text, trimmed(text, sign + 1, part.end));
  if (!data::parse_number(digits, value) || !std::isfinite(value)) {
    throw FormulaError(fmt::format("'{}' is not a number", digits), text, sign + 2);
  }
  if (name == "delta" && has_delta) {
    factor.delta = value;
  } else if (name == "constant" && has_constant && value >= 0.0) {
    factor.constant = value;
  } else {
    throw FormulaError(fmt::format("'{}' cannot be fixed here; delta can be fixed in all "
                                   "functions, and a constant of 0 or more in constant-plus-power",
                                   of(text, part)),
                       text,
                       part.begin + 1);
  }
}

/// Reads `dbh | species, delta = 0.5`.
void parse_arguments(std::string_view text, Part whole, VarianceFactor& factor) {
  bool first = true;
  for (const Part part : split(text, whole.begin, whole.end, ',')) {
    if (find_outside(text, part, "=") < part.end) {
      hold_parameter(text, part, factor);
    } else if (first) {
      const std::vector<Part> sides = split(text, part.begin, part.end, '|');
      if (of(text, sides.front()) != "fitted") factor.column = column_name(text, sides.front());
      if (sides.size() > 1) factor.stratum = column_name(text, sides[1]);
    } else {
      throw FormulaError("expected delta = VALUE or constant = VALUE", text, part.begin + 1);
    }
    first = false;
  }
}

VarianceFactor parse_factor(std::string_view text, Part part) {
  const std::size_t parenthesis = text.substr(0, part.end).find('(', part.begin);
  const bool has_arguments = parenthesis != std::string_view::npos;
  const Part name = trimmed(text, part.begin, has_arguments ? parenthesis : part.end);
  VarianceFactor factor{.kind = parse_kind(text, name)};
  if (has_arguments) {
    if (text[part.end - 1] != ')') throw FormulaError("expected )", text, part.end);
    parse_arguments(text, trimmed(text, parenthesis + 1, part.end - 1), factor);
  }
  if (!kind_of(factor).reads_value()) {
    factor.stratum = std::exchange(factor.column, "");
    if (factor.stratum.empty()) {
      throw FormulaError(
          "stratum needs a column, for example stratum(species)", text, part.begin + 1);
    }
  }
  return factor;
}

std::string arguments_text(const VarianceFactor& factor) {
  if (!kind_of(factor).reads_value()) return column_text(factor.stratum);
  std::string text = column_text(factor.column);
  if (!factor.stratum.empty()) {
    text = fmt::format("{} | {}", text.empty() ? "fitted" : text, column_text(factor.stratum));
  }
  const auto append = [&text](const char* name, std::optional<double> value) {
    if (!value) return;
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", name, data::shortest(*value));
  };
  append("delta", factor.delta);
  append("constant", factor.constant);
  return text;
}

/// (N) the number of the stratum of each row, -1 if the factor does not have it.
std::vector<Index> strata_of(const VarianceFactorEstimate& estimate, const data::Table& table) {
  std::vector<Index> strata(table.rows(), 0);
  if (estimate.factor.stratum.empty()) return strata;
  const data::TextColumn labels = table.labels(estimate.factor.stratum);
  for (std::size_t row = 0; row < strata.size(); ++row) {
    const auto found = labels.is_missing(row) ? estimate.strata.end()
                                              : std::ranges::find(estimate.strata, labels[row]);
    strata[row] = found == estimate.strata.end() ? -1 : found - estimate.strata.begin();
  }
  return strata;
}

}  // namespace

int VarianceFactor::parameter_count() const {
  const VarianceKind& of = kind_of(kind);
  if (!of.has_delta()) return 1;
  return (delta ? 0 : 1) + (of.has_constant() && !constant ? 1 : 0);
}

std::string VarianceFactor::text() const {
  const std::string name(kind_of(kind).name());
  const std::string arguments = arguments_text(*this);
  return arguments.empty() ? name : fmt::format("{}({})", name, arguments);
}

int VarianceFunction::parameter_count() const {
  int count = 0;
  for (const VarianceFactor& factor : factors) count += factor.parameter_count();
  return count;
}

std::string VarianceFunction::text() const {
  if (factors.empty()) return "none";
  std::vector<std::string> texts;
  for (const VarianceFactor& factor : factors) texts.push_back(factor.text());
  return fmt::format("{}", fmt::join(texts, " * "));
}

VarianceFunction parse_variance_function(std::string_view text) {
  VarianceFunction function;
  if (of(text, trimmed(text, 0, text.size())) == "none") return function;
  for (const Part part : split(text, 0, text.size(), '*')) {
    function.factors.push_back(parse_factor(text, part));
  }
  return function;
}

VarianceFunction VarianceEstimate::function() const {
  VarianceFunction function;
  for (const VarianceFactorEstimate& estimate : factors) {
    function.factors.push_back(estimate.factor);
  }
  return function;
}

double VarianceEstimate::delta() const {
  const bool is_single = factors.size() == 1 && factors.front().delta.size() == 1;
  return is_single ? factors.front().delta[0] : kNaN;
}

double VarianceEstimate::constant() const {
  const bool is_single = factors.size() == 1 && factors.front().constant.size() == 1;
  return is_single ? factors.front().constant[0] : kNaN;
}

VarianceEstimate VarianceEstimate::missing(const VarianceFunction& function) {
  VarianceEstimate estimate;
  for (const VarianceFactor& factor : function.factors) {
    VarianceFactorEstimate& added = estimate.factors.emplace_back();
    added.factor = factor;
    added.strata = {""};
    if (!kind_of(factor).has_delta()) {
      added.ratio.setConstant(1, kNaN);
      continue;
    }
    added.delta.setConstant(1, factor.delta.value_or(kNaN));
    if (kind_of(factor).has_constant()) {
      added.constant.setConstant(1, factor.constant.value_or(kNaN));
    }
  }
  return estimate;
}

VectorXd relative_sd(const VarianceEstimate& estimate,
                     const Eigen::Ref<const VectorXd>& fitted,
                     const data::Table& table) {
  ArrayXd result = fitted.array().isNaN().select(kNaN, ArrayXd::Ones(fitted.size()));
  for (const VarianceFactorEstimate& factor : estimate.factors) {
    const std::vector<Index> strata = strata_of(factor, table);
    std::vector<double> column;
    if (!factor.factor.column.empty()) column = data::variable_values(factor.factor.column, table);
    for (Index i = 0; i < result.size(); ++i) {
      const auto row = static_cast<std::size_t>(i);
      const Index stratum = strata[row];
      const double v = column.empty() ? fitted[i] : column[row];
      result[i] *= stratum < 0 ? kNaN : kind_of(factor.factor).value(factor, stratum, v);
    }
  }
  return result;
}

}  // namespace silvafit::fit
