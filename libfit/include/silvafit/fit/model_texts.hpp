// SPDX-License-Identifier: MIT
// A model as texts, for the program, R and Python.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/model_specification.hpp"

namespace silvafit::fit {

/// The texts of a model; docs/fit-command.md explains them.
struct ModelTexts {
  /// "h ~ 1.3 + a*(1 - exp(-b*dbh))"; a summand may be a bar term, as in "h ~ a + b*dbh + (1 |
  /// plot)", if each of its effects is that of one coefficient.
  std::string formula{};
  std::vector<std::string> sub_models{};  ///< "b ~ 1 + C"
  std::string random{};                   ///< "a + b | plot"; empty: no random effects
  /// general, diagonal, identity or compound-symmetry: one for all groupings, or one for each with
  /// the coarser first; empty: general, or the blocks of `random`.
  std::vector<std::string> covariance{};
  std::string variance{};     ///< "power"; empty: constant
  std::string correlation{};  ///< of the residuals, "car1(age)"; empty or "none": independent
  std::vector<std::string> derived{};  ///< "h30 = 1.3 + a*(1 - exp(-b*30))"
  /// Further columns whose levels the texts compare, as factors.
  std::vector<std::string> factors{};
  /// Factors at whose levels the means of parameters are derived quantities, too.
  std::vector<std::string> means{};
  /// Names of all columns of the data, if the table has some of them only; for messages.
  std::vector<std::string> columns{};
};

/// The model of the texts for a table.
/// \throws FormulaError if a text cannot be read; UsageError if `covariance` has another length
///   than the groupings; InputError if a column is missing or has text instead of numbers
ModelSpecification specify_model(const ModelTexts& texts, const data::Table& table);

}  // namespace silvafit::fit
