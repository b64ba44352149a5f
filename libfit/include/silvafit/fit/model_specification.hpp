// SPDX-License-Identifier: MIT
// What a model is, before any data: a formula, linear sub-models of its parameters, random effects,
// variance.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/expression.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/random_effects.hpp"
#include "silvafit/fit/variance_function.hpp"

namespace silvafit::fit {

/// A covariate of a parameter: any expression of data columns.
struct Covariate {
  std::string label{};  ///< as written, e.g. "C" or "log(dbh)"
  data::Expression value;
};

/// A parameter as a linear function of covariates: b = b_0 + b_C C + b_U U, written `b ~ 1 + C +
/// U`.
struct ParameterModel {
  std::string name{};
  bool has_intercept = true;
  std::vector<Covariate> covariates{};

  /// Names of its coefficients: "b" for the intercept, "b:C" for a covariate.
  std::vector<std::string> coefficient_names() const;
  /// The right side as text: "1 + C + U".
  std::string text() const;
};

struct ModelSpecification {
  data::Formula formula;
  std::vector<ParameterModel> parameters{};
  std::optional<RandomEffects> random{};  ///< of the only or the finer grouping
  /// Of a coarser grouping, within whose groups those of `random` are told apart.
  std::optional<RandomEffects> outer_random{};
  VarianceFunction variance{};

  /// All coefficients in the order of the parameters.
  std::vector<std::string> coefficient_names() const;
  /// What the mean reads from the data: columns of the formula, then those of covariates. The
  /// comparison of a column with text is one of them; see data::is_text_match.
  std::vector<std::string> predictors() const;
  /// Columns whose values are names, not numbers: groups, strata, and what is compared with text,
  /// but for those that the model also reads as numbers.
  std::vector<std::string> label_columns() const;
};

/// A model of a formula: the names in it that are no columns of the table are its parameters, in
/// the order of their first appearance, each constant unless a sub-model is given for it.
/// \param sub_models  texts such as "b ~ 1 + C + U" or "b ~ 0 + C"
/// \throws FormulaError if a text cannot be read, the formula has no parameter, or a sub-model is
///   for none of them; InputError if a covariate is no column
ModelSpecification specify_model(std::string_view formula,
                                 const std::vector<std::string>& sub_models,
                                 const data::Table& table);

/// Makes sure that there is something to fit to; a model to simulate from needs no response.
/// \throws InputError if the response is no column of the table; FormulaError if the mean or a
///   sub-model depends on it
void check_response(const ModelSpecification& specification, const data::Table& table);

/// Reads one sub-model; covariates are not checked against any table.
ParameterModel parse_parameter_model(std::string_view text);

/// Gives a model the random effects of a text.
/// \throws FormulaError that points at what is no coefficient of the model or is named twice;
///   InputError if the group is no column of the table
void add_random_effects(ModelSpecification& specification,
                        std::string_view text,
                        const data::Table& table);

}  // namespace silvafit::fit
