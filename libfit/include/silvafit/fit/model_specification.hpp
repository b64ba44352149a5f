// SPDX-License-Identifier: MIT
// A model without data: a formula, linear sub-models of its parameters, random effects, variance.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/expression.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/correlation.hpp"
#include "silvafit/fit/derived_quantity.hpp"
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
  /// Covariates whose coefficients have random effects but no fixed one: deviations around zero.
  /// The label of an intercept is empty. In models of which coefficients are held only.
  std::vector<Covariate> random_only{};

  /// Name of a coefficient: "b" for an intercept, "b:C" for a covariate.
  std::string coefficient_name(const Covariate& covariate) const {
    return covariate.label.empty() ? name : name + ":" + covariate.label;
  }
  /// Names of its coefficients with a fixed effect.
  std::vector<std::string> coefficient_names() const;
  /// The right side as text: "1 + C + U".
  std::string text() const;
};

struct ModelSpecification {
  data::Formula formula;
  std::vector<ParameterModel> parameters{};
  /// Terms as in lme4: one grouping; two nested ones with the coarser one first, whose groups
  /// contain those of the second; or crossed ones. Empty without random effects.
  std::vector<RandomEffects> random{};
  VarianceFunction variance{};
  /// Functions of the coefficients that are reported with them.
  std::vector<DerivedQuantity> derived{};
  std::optional<Correlation> correlation{};  ///< of the residuals; none: independent
  /// Columns that sub-models use as factors: values that the fit does not have give no prediction.
  std::vector<std::string> factors{};
  /// Names of all columns of the data, for doubts about names that were taken as parameters; empty
  /// if the model is not from texts of a user.
  std::vector<std::string> data_columns{};

  /// All coefficients in the order of the parameters.
  std::vector<std::string> coefficient_names() const;
  /// Those with random effects only.
  std::vector<std::string> random_only_names() const;
  /// The columns that the mean reads: those of the formula, then those of covariates. The
  /// comparison of a column with text is one of them; see data::is_text_match.
  std::vector<std::string> predictors() const;
  /// Columns whose values are names, not numbers: groups, strata, and columns compared with text,
  /// except those that the model also reads as numbers.
  std::vector<std::string> label_columns() const;
};

/// A model of a formula: the names in it that are not columns of the table are its parameters, in
/// the order of their first appearance, each constant unless a sub-model is given for it.
///
/// The formula is arithmetic. The right sides of sub-models have the meaning of R: terms of
/// variables, with + - : * ( ) and ^ of sums; columns of text and factor(column) are factors with
/// contrasts to their first level. Operators with another meaning in R than in arithmetic (x^2,
/// x/10) are refused outside of I(...) and function calls. docs/formula-language.md has the rules.
/// \param sub_models  texts such as "b ~ 1 + C + U", "b ~ C*species" or "b ~ 0 + I(dbh^2)"
/// \param columns     names of all columns of the data; those of the table if it is empty
/// \throws FormulaError if a text cannot be read, the formula has no parameter, or a sub-model is
///   for none of them; InputError if a covariate is not a column, or a factor cannot be coded
ModelSpecification specify_model(std::string_view formula,
                                 const std::vector<std::string>& sub_models,
                                 const data::Table& table,
                                 const std::vector<std::string>& columns = {});

/// Checks the response, which a model for simulation does not need.
/// \throws InputError if the response is not a column of the table; FormulaError if the
///   model reads it, also as a group or in the functions of variance and correlation
void check_response(const ModelSpecification& specification, const data::Table& table);

/// Reads one sub-model without a table: all columns are assumed to be numeric.
/// \throws FormulaError also if there is a factor()
ParameterModel parse_parameter_model(std::string_view text);

/// Reads the text of ParameterModel::text(): columns joined by +, one coefficient each, where `:`
/// is a product and all else arithmetic.
ParameterModel parse_stored_parameter_model(const std::string& name, std::string_view columns);

/// The columns that a sub-model reads.
struct SubModelColumns {
  std::vector<std::string> as_numbers{};  ///< or as factors, if they contain text
  std::vector<std::string> as_names{};    ///< factor(column), and columns compared with text
};
/// \throws FormulaError if the text cannot be read
SubModelColumns sub_model_columns(std::string_view text);

/// Sets the random effects of a model from a text.
/// \throws FormulaError with the position of a name that is not a coefficient of the model or is
///   given twice, or of a finer grouping whose labels recur in several of the coarser groups unless
///   it is written `stand/plot`; InputError if the group is not a column of the table
void add_random_effects(ModelSpecification& specification,
                        std::string_view text,
                        const data::Table& table);

}  // namespace silvafit::fit
