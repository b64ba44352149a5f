// SPDX-License-Identifier: MIT
// Functions of the coefficients of a fit, with standard errors.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/expression.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

struct FittedModel;

/// A function of the coefficients: a height at some age, an age of largest growth, a difference
/// between levels of a factor.
struct DerivedQuantity {
  std::string name{};
  data::Expression value;

  /// \param names, estimate  (p) all coefficients that it uses, and their values
  double at(const std::vector<std::string>& names, const Eigen::VectorXd& estimate) const;
  /// (p) derivatives by them.
  Eigen::VectorXd gradient(const std::vector<std::string>& names,
                           const Eigen::VectorXd& estimate) const;
};

/// Reads "h30 = 1.3 + a*(1 - exp(-b*30))", or an expression alone, which is then its own name.
/// Names that are no words stand between backquotes, as in `a:(species == "SM")`.
/// \throws FormulaError if the text cannot be read, a name in it is not a coefficient, or its own
///   name is that of a coefficient or of another parameter
DerivedQuantity parse_derived_quantity(std::string_view text,
                                       const std::vector<std::string>& coefficients);

/// Reads an expression of coefficients.
/// \param begin  where it begins in the text
/// \throws FormulaError as parse_derived_quantity
data::Expression parse_derived_expression(std::string_view text,
                                          std::size_t begin,
                                          const std::vector<std::string>& coefficients);

/// The estimate of a derived quantity; NaN where it is not known.
struct DerivedValue {
  double estimate = 0.0;
  double standard_error = 0.0;  ///< by the delta method
  /// The fewest of the coefficients that it depends on; one that varies between groups has at most
  /// their number less 1.
  double degrees_of_freedom = 0.0;
};

/// Those of a fit, in the order of its specification. Coefficients that are held have no error; the
/// error is unknown if one of the others is not identifiable.
/// Source: Casella and Berger 2002, Statistical inference, theorem 5.5.28 (the delta method).
std::vector<DerivedValue> derived_values(const FittedModel& fit);

}  // namespace silvafit::fit
