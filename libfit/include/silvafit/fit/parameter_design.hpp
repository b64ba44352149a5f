// SPDX-License-Identifier: MIT
// The parameters of a mean function by row, as they follow from coefficients.
#pragma once

#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/model_specification.hpp"

namespace silvafit::fit {

/// The design of a nonlinear mixed model: phi = A (beta + b), in which the row of A for a parameter
/// has 1 for its intercept and the covariates of its other coefficients.
///
/// N rows, p coefficients, those with random effects only last; K parameters. Source: Pinheiro and
/// Bates 2000, equation 7.3.
class ParameterDesign {
 public:
  ParameterDesign() = default;
  /// Parameters without covariates.
  explicit ParameterDesign(Eigen::Index parameters, Eigen::Index rows);
  /// \param rows  of the table, in their order
  /// \throws UsageError if a column is missing
  ParameterDesign(const std::vector<ParameterModel>& parameters,
                  const data::Table& table,
                  const std::vector<std::size_t>& rows);

  Eigen::Index coefficient_count() const { return std::ssize(covariate_of_); }
  /// The number of a coefficient's parameter.
  Eigen::Index parameter_of(Eigen::Index coefficient) const {
    return parameter_of_[static_cast<std::size_t>(coefficient)];
  }
  const std::vector<Eigen::Index>& coefficients_of(Eigen::Index parameter) const {
    return coefficients_of_[static_cast<std::size_t>(parameter)];
  }
  bool has_covariates(Eigen::Index parameter) const;
  /// (N) the covariate of a coefficient, null for an intercept.
  const double* multiplier(Eigen::Index coefficient) const {
    const Eigen::Index covariate = covariate_of_[static_cast<std::size_t>(coefficient)];
    return covariate < 0 ? nullptr : covariates_.col(covariate).data();
  }
  double multiplier(Eigen::Index coefficient, Eigen::Index row) const {
    const double* const values = multiplier(coefficient);
    return values == nullptr ? 1.0 : values[row];
  }

  /// A parameter in consecutive rows.
  /// \param value   gives the value of a coefficient in them
  /// \param target  (rows) result
  template <class Value>
  void fill(Eigen::Index parameter,
            Eigen::Index begin,
            Eigen::Index rows,
            const Value& value,
            double* target) const;
  /// The derivatives of consecutive rows by a coefficient.
  /// \param by_parameter  (rows) those by its parameter
  /// \param target        (rows) result, which may be the same
  void differentiate(Eigen::Index coefficient,
                     Eigen::Index begin,
                     Eigen::Index rows,
                     const double* by_parameter,
                     double* target) const;
  /// The design of some of the rows.
  ParameterDesign part(const std::vector<Eigen::Index>& rows) const;

 private:
  void add(Eigen::Index parameter, Eigen::Index covariate);

  std::vector<Eigen::Index> parameter_of_;                  ///< (p)
  std::vector<Eigen::Index> covariate_of_;                  ///< (p) -1 for an intercept
  std::vector<std::vector<Eigen::Index>> coefficients_of_;  ///< (K) an intercept first
  Eigen::MatrixXd covariates_;                              ///< (N x covariates)
};

template <class Value>
void ParameterDesign::fill(Eigen::Index parameter,
                           Eigen::Index begin,
                           Eigen::Index rows,
                           const Value& value,
                           double* target) const {
  Eigen::Map<Eigen::ArrayXd> values(target, rows);
  values.setZero();
  for (const Eigen::Index j : coefficients_of(parameter)) {
    const double* const multiplier = this->multiplier(j);
    if (multiplier == nullptr) {
      values.setConstant(value(j));  // an intercept is first
    } else {
      values += value(j) * Eigen::Map<const Eigen::ArrayXd>(multiplier + begin, rows);
    }
  }
}

}  // namespace silvafit::fit
