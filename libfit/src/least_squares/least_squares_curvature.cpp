// SPDX-License-Identifier: MIT
#include "least_squares/least_squares_curvature.hpp"

#include <string>
#include <vector>

#include "silvafit/data/program.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// (N x K) values of the model's parameters.
MatrixXd parameter_values(const NonlinearModel& model, const VectorXd& coefficients) {
  const auto count = static_cast<Index>(model.specification().parameters.size());
  MatrixXd values = MatrixXd::Zero(model.observations(), count);
  for (Index j = 0; j < coefficients.size(); ++j) {
    values.col(model.parameter_of(j)) += coefficients[j] * model.multiplier(j);
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

/// (N x K(K+1)/2)
MatrixXd evaluate(const NonlinearModel& model, const MatrixXd& parameters) {
  const data::Program program = second_derivatives(model);
  std::vector<const double*> inputs;
  for (Index k = 0; k < parameters.cols(); ++k) inputs.push_back(parameters.col(k).data());
  const MatrixXd& columns = model.variable_values();
  for (Index k = 0; k < columns.cols(); ++k) inputs.push_back(columns.col(k).data());
  MatrixXd result(model.observations(), static_cast<Index>(program.output_count()));
  std::vector<double*> outputs;
  for (Index k = 0; k < result.cols(); ++k) outputs.push_back(result.col(k).data());
  data::Program::Workspace workspace;
  program.evaluate(inputs, static_cast<std::size_t>(model.observations()), outputs, workspace);
  return result;
}

}  // namespace

MatrixXd least_squares_hessian(const NonlinearModel& model, const VectorXd& coefficients) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  MatrixXd jacobian;
  model.evaluate(coefficients, mean, &jacobian, workspace);
  const VectorXd residual = model.response() - mean;
  const MatrixXd second = evaluate(model, parameter_values(model, coefficients));
  MatrixXd hessian = jacobian.transpose() * jacobian;
  for (Index i = 0; i < coefficients.size(); ++i) {
    for (Index j = 0; j < coefficients.size(); ++j) {
      const Index large = std::max(model.parameter_of(i), model.parameter_of(j));
      const Index small = std::min(model.parameter_of(i), model.parameter_of(j));
      const VectorXd moved = model.multiplier(i).cwiseProduct(model.multiplier(j));
      hessian(i, j) -=
          second.col(large * (large + 1) / 2 + small).cwiseProduct(moved).dot(residual);
    }
  }
  return hessian;
}

}  // namespace silvafit::fit
