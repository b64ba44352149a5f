// SPDX-License-Identifier: MIT
// What a model is, before any data: a formula, linear sub-models of its parameters, random effects,
// variance.
#pragma once

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
  /// A term of the sub-model, e.g. "C", "log(dbh)" or "C:U"; of a factor, the comparison with one
  /// of its levels: `(species == "SM")`.
  std::string label{};
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
  /// Terms, as lme4's: one grouping, or two nested ones with the coarser one first, within whose
  /// groups those of the second are told apart. Empty without random effects.
  std::vector<RandomEffects> random{};
  VarianceFunction variance{};
  /// Columns that sub-models use as factors: other values than those of the fit have no prediction.
  std::vector<std::string> factors{};

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
///
/// The formula is arithmetic. The right sides of sub-models mean what they mean in R: terms of
/// variables, with + - : * ( ) and ^ of sums; columns of text and factor(column) are factors with
/// contrasts to their first level. What R reads otherwise than as arithmetic (x^2, x/10) is refused
/// outside of I(...) and function calls. docs/formula-language.md has the rules.
/// \param sub_models  texts such as "b ~ 1 + C + U", "b ~ C*species" or "b ~ 0 + I(dbh^2)"
/// \throws FormulaError if a text cannot be read, the formula has no parameter, or a sub-model is
///   for none of them; InputError if a covariate is no column, or a factor none that can be coded
ModelSpecification specify_model(std::string_view formula,
                                 const std::vector<std::string>& sub_models,
                                 const data::Table& table);

/// Makes sure that there is something to fit to; a model to simulate from needs no response.
/// \throws InputError if the response is no column of the table; FormulaError if the mean or a
///   sub-model depends on it
void check_response(const ModelSpecification& specification, const data::Table& table);

/// Reads one sub-model without a table: all columns are taken for numbers.
/// \throws FormulaError also if there is a factor()
ParameterModel parse_parameter_model(std::string_view text);

/// Reads what ParameterModel::text() wrote: columns joined by +, one coefficient each, where `:` is
/// a product and all else arithmetic.
ParameterModel parse_stored_parameter_model(const std::string& name, std::string_view columns);

/// The columns that a sub-model reads.
struct SubModelColumns {
  std::vector<std::string> as_numbers{};  ///< or as factors, if they hold text
  std::vector<std::string> as_names{};    ///< factor(column), and what is compared with text
};
/// \throws FormulaError if the text cannot be read
SubModelColumns sub_model_columns(std::string_view text);

/// Gives a model the random effects of a text.
/// \throws FormulaError that points at what is no coefficient of the model or is named twice;
///   InputError if the group is no column of the table
void add_random_effects(ModelSpecification& specification,
                        std::string_view text,
                        const data::Table& table);

}  // namespace silvafit::fit
