// SPDX-License-Identifier: MIT
#include "least_squares/least_squares_curvature.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "model/row_program.hpp"

namespace silvafit::fit {
namespace {

constexpr Index kBlock = 1024;  // rows at a time

/// (rows x K) values of the model's parameters.
/// \param coefficients  (column_count())
MatrixXd parameter_values(const NonlinearModel& model,
                          const VectorXd& coefficients,
                          Index begin,
                          Index rows) {
  MatrixXd values(rows, std::ssize(model.specification().parameters));
  for (Index k = 0; k < values.cols(); ++k) {
    const auto value = [&coefficients](Index j) { return coefficients[j]; };
    model.design().fill(k, begin, rows, value, values.col(k).data());
  }
  return values;
}

/// Second derivatives of the mean by pairs of parameters, i >= j, in that order.
data::Program second_derivatives(const NonlinearModel& model) {
  const ModelSpecification& specification = model.specification();
  std::vector<data::Program::Input> inputs;
  std::vector<data::Expression> outputs;
  for (const ParameterModel& parameter : specification.parameters) {
    inputs.push_back({.name = parameter.name});
  }
  for (const std::string& name : model.variables()) inputs.push_back({.name = name});
  for (std::size_t i = 0; i < specification.parameters.size(); ++i) {
    const data::Expression first =
        specification.formula.right.derivative(specification.parameters[i].name);
    for (std::size_t j = 0; j <= i; ++j) {
      outputs.push_back(first.derivative(specification.parameters[j].name));
    }
  }
  return {outputs, inputs};
}

/// (rows x K(K+1)/2) the second derivatives of some rows.
MatrixXd evaluate(const NonlinearModel& model,
                  const data::Program& program,
                  const MatrixXd& parameters,
                  Index begin) {
  std::vector<const double*> inputs;
  for (Index k = 0; k < parameters.cols(); ++k) inputs.push_back(parameters.col(k).data());
  const MatrixXd& columns = model.variable_values();
  for (Index k = 0; k < columns.cols(); ++k) inputs.push_back(columns.col(k).data() + begin);
  return values_of(program, inputs, parameters.rows());
}

}  // namespace

MatrixXd residual_curvature(const NonlinearModel& model,
                            const VectorXd& coefficients,
                            const VectorXd& residuals) {
  const data::Program program = second_derivatives(model);
  const Index p = coefficients.size();
  const VectorXd all = model.extended(coefficients);
  MatrixXd result = MatrixXd::Zero(p, p);
  for (Index begin = 0; begin < model.observations(); begin += kBlock) {
    const Index rows = std::min(kBlock, model.observations() - begin);
    const MatrixXd second =
        evaluate(model, program, parameter_values(model, all, begin, rows), begin);
    for (Index i = 0; i < p; ++i) {
      VectorXd moved = residuals.segment(begin, rows);
      model.design().differentiate(i, begin, rows, moved.data(), moved.data());
      for (Index j = 0; j <= i; ++j) {
        if (model.is_bilinear(i, j)) continue;
        const Index large =
            std::max(model.design().parameter_of(i), model.design().parameter_of(j));
        const Index small =
            std::min(model.design().parameter_of(i), model.design().parameter_of(j));
        VectorXd term = second.col(large * (large + 1) / 2 + small).cwiseProduct(moved);
        model.design().differentiate(j, begin, rows, term.data(), term.data());
        result(i, j) += term.sum();
      }
    }
  }
  return result.selfadjointView<Eigen::Lower>();
}

MatrixXd least_squares_hessian(const NonlinearModel& model, const VectorXd& coefficients) {
  const auto [mean, jacobian] = model.curve_at(coefficients);
  return jacobian.transpose() * jacobian -
         residual_curvature(model, coefficients, model.response() - mean);
}

}  // namespace silvafit::fit
