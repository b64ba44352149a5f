// SPDX-License-Identifier: MIT
#include "silvafit/fit/response.hpp"

#include <algorithm>
#include <cmath>

#include "model/factor_columns.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/fit/formula_parts.hpp"

namespace silvafit::fit {

std::string response_of(std::string_view formula) {
  return data::parse_formula(split_formula(formula).fixed).left;
}

std::vector<std::string> response_columns(const std::string& response) {
  try {
    std::vector<std::string> columns = data::Expression::parse(response).variables();
    if (!columns.empty()) return columns;
  } catch (const FormulaError&) {
    // A name in backquotes need not be an expression.
  }
  return {response};
}

void add_response(const std::string& response, data::Table& table) {
  const std::vector<std::string> columns = response_columns(response);
  const auto has = [&table](const std::string& name) { return table.has(name); };
  if (table.has(response) || !std::ranges::all_of(columns, has)) return;
  std::vector<double> values = data::checked_values(response, table);
  const std::vector<bool> complete = complete_rows(columns, table);
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (!complete[row] || std::isfinite(values[row])) continue;
    throw InputError("the response is not defined here", data::place_of(table, row, response));
  }
  table.set(response, std::move(values));
}

}  // namespace silvafit::fit
