// SPDX-License-Identifier: MIT
// The mean function of a model on the rows of a table, for parameters that differ by row.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/program.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/model_specification.hpp"
#include "silvafit/fit/parameter_design.hpp"

namespace silvafit::fit {

/// f(phi; data) and its derivatives by phi and by columns that are not known exactly.
///
/// N rows, p coefficients, K parameters of the formula, U uncertain columns.
class RowMean {
 public:
  /// \throws UsageError if a column is missing
  RowMean(const ModelSpecification& specification,
          const data::Table& table,
          const std::vector<std::string>& uncertain = {});

  Index rows() const { return rows_; }
  Index parameter_count() const { return parameters_; }
  Index argument_count() const { return parameters_ + static_cast<Index>(uncertain_.size()); }
  /// How the parameters follow from the coefficients.
  const ParameterDesign& design() const { return design_; }
  /// (N x K + U) parameters by row, and the uncertain columns behind them.
  /// \param coefficients  (p x M)
  /// \param set_of_row    (N) column of coefficients of each row
  MatrixXd arguments(const MatrixXd& coefficients, const std::vector<Index>& set_of_row) const;
  /// (N) the mean; NaN if a column that it needs is missing.
  VectorXd mean(const MatrixXd& arguments) const;
  /// (N x K + U) its derivatives by the arguments.
  MatrixXd gradient(const MatrixXd& arguments) const;

 private:
  MatrixXd run(const data::Program& program, const MatrixXd& arguments) const;

  Index rows_ = 0;
  Index parameters_ = 0;
  ParameterDesign design_;
  std::vector<std::vector<double>> columns_;  ///< predictors of the mean
  std::vector<Index> uncertain_;              ///< numbers of columns_
  std::vector<bool> is_complete_;
  data::Program mean_;
  data::Program gradient_;
};

}  // namespace silvafit::fit
