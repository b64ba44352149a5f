// SPDX-License-Identifier: MIT
#include "prediction/row_mean.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "model/row_program.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {

RowMean::RowMean(const ModelSpecification& specification,
                 const data::Table& table,
                 const std::vector<std::string>& uncertain)
    : rows_(static_cast<Index>(table.rows())),
      parameters_(static_cast<Index>(specification.parameters.size())),
      is_complete_(table.rows(), true) {
  std::vector<std::size_t> rows(table.rows());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  design_ = ParameterDesign(specification.parameters, table, rows);
  std::vector<data::Program::Input> inputs;
  for (const ParameterModel& parameter : specification.parameters) {
    inputs.push_back({.name = parameter.name});
  }
  std::vector<std::string> arguments;
  for (const ParameterModel& parameter : specification.parameters) {
    arguments.push_back(parameter.name);
  }
  for (const std::string& name : specification.predictors()) {
    columns_.push_back(data::variable_values(name, table));
    inputs.push_back({.name = name});
    // A formula may ignore a missing value (min(), ifelse()); the prediction is missing
    // nevertheless.
    for (std::size_t row = 0; row < table.rows(); ++row) {
      if (std::isnan(columns_.back()[row])) is_complete_[row] = false;
    }
    if (std::ranges::find(uncertain, name) == uncertain.end()) continue;
    uncertain_.push_back(static_cast<Index>(columns_.size()) - 1);
    arguments.push_back(name);
  }
  mean_ = data::Program({&specification.formula.right, 1}, inputs);
  // Rows to predict may have zeros where those of the fit had none.
  const data::Expression mean = specification.formula.right.with_limits();
  std::vector<data::Expression> derivatives;
  derivatives.reserve(arguments.size());
  for (const std::string& name : arguments) derivatives.push_back(mean.derivative(name));
  gradient_ = data::Program(derivatives, inputs);
}

MatrixXd RowMean::arguments(const MatrixXd& coefficients,
                            const std::vector<Index>& set_of_row) const {
  MatrixXd result(rows_, argument_count());
  for (Index k = 0; k < parameters_; ++k) {
    for (Index row = 0; row < rows_; ++row) {
      const Index set = set_of_row[static_cast<std::size_t>(row)];
      const auto value = [&coefficients, set](Index j) { return coefficients(j, set); };
      design_.fill(k, row, 1, value, &result(row, k));
    }
  }
  for (std::size_t k = 0; k < uncertain_.size(); ++k) {
    const std::vector<double>& column = columns_[static_cast<std::size_t>(uncertain_[k])];
    result.col(parameters_ + static_cast<Index>(k)) =
        Eigen::Map<const VectorXd>(column.data(), rows_);
  }
  return result;
}

MatrixXd RowMean::run(const data::Program& program, const MatrixXd& arguments) const {
  std::vector<const double*> inputs;
  for (Index k = 0; k < parameters_; ++k) inputs.push_back(arguments.col(k).data());
  for (const std::vector<double>& column : columns_) inputs.push_back(column.data());
  for (std::size_t k = 0; k < uncertain_.size(); ++k) {
    inputs[static_cast<std::size_t>(parameters_ + uncertain_[k])] =
        arguments.col(parameters_ + static_cast<Index>(k)).data();
  }
  return values_of(program, inputs, rows_);
}

VectorXd RowMean::mean(const MatrixXd& arguments) const {
  VectorXd result = run(mean_, arguments);
  for (Index row = 0; row < rows_; ++row) {
    if (!is_complete_[static_cast<std::size_t>(row)]) result[row] = kNaN;
  }
  return result;
}

MatrixXd RowMean::gradient(const MatrixXd& arguments) const { return run(gradient_, arguments); }

}  // namespace silvafit::fit
