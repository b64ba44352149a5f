// SPDX-License-Identifier: MIT
#include "least_squares/periodic_coefficients.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "model/row_program.hpp"

namespace silvafit::fit {
namespace {

/// Values of an expression of parameters and columns.
class RowValues {
 public:
  explicit RowValues(const NonlinearModel& model) : model_(model) {
    for (const ParameterModel& parameter : model.specification().parameters) {
      inputs_.push_back({.name = parameter.name, .is_scalar = true});
    }
    parameters_ = inputs_.size();
    for (const std::string& name : model.variables()) inputs_.push_back({.name = name});
  }

  /// \param values  of the parameters, in their order
  VectorXd of(const data::Expression& expression, const std::vector<double>& values) const {
    const data::Program program(std::array{expression}, inputs_);
    std::vector<const double*> inputs;
    for (std::size_t k = 0; k < parameters_; ++k) inputs.push_back(&values[k]);
    const MatrixXd& columns = model_.variable_values();
    for (Index k = 0; k < columns.cols(); ++k) inputs.push_back(columns.col(k).data());
    return values_of(program, inputs, columns.rows());
  }

 private:
  const NonlinearModel& model_;
  std::vector<data::Program::Input> inputs_;
  std::size_t parameters_ = 0;
};

/// The multiplier or divisor of a coefficient within an argument.
struct Multiplier {
  bool is_divided = false;
  VectorXd values{};  ///< (N)
};

/// By the slopes of the argument at 1 and 2: equal for w*x, a quarter for x/P.
std::optional<Multiplier> multiplier(const data::Expression& argument,
                                     std::size_t parameter,
                                     const NonlinearModel& model,
                                     const RowValues& rows) {
  constexpr double kRounding = 1e-12;
  const auto& parameters = model.specification().parameters;
  const data::Expression slope = argument.derivative(parameters[parameter].name);
  if (slope.is_zero()) return std::nullopt;
  std::vector<double> values(parameters.size(), 1.0);
  Multiplier result{.values = rows.of(slope, values)};
  values[parameter] = 2.0;
  const VectorXd at_two = rows.of(slope, values);
  if (!result.values.allFinite() || !at_two.allFinite()) return std::nullopt;
  const double size = kRounding * result.values.norm();
  if ((at_two - result.values).norm() <= size) return result;
  result.is_divided = true;
  if ((4.0 * at_two - result.values).norm() <= size) return result;
  return std::nullopt;
}

/// The only coefficient of a parameter; none if the parameter has covariates.
std::optional<Index> only_coefficient(const NonlinearModel& model, Index parameter) {
  std::optional<Index> result;
  for (Index j = 0; j < model.coefficient_count(); ++j) {
    if (model.design().parameter_of(j) != parameter) continue;
    if (result) return std::nullopt;
    result = j;
  }
  const auto k = static_cast<std::size_t>(parameter);
  const bool is_constant = model.specification().parameters[k].has_intercept;
  return is_constant ? result : std::nullopt;
}

}  // namespace

double PeriodicCoefficient::frequency(double value) const {
  return std::abs(is_period ? 1.0 / value : value);
}

double PeriodicCoefficient::value(double number) const {
  const double frequency = step * number;
  return is_period ? 1.0 / frequency : frequency;
}

bool PeriodicCoefficient::contains(double value) const {
  return frequency(value) <= step * static_cast<double>(count);
}

bool PeriodicCoefficient::are_near(double a, double b) const {
  constexpr double kHalfPeak = 2.0;  // steps
  return std::abs(frequency(a) - frequency(b)) < kHalfPeak * step;
}

std::vector<PeriodicCoefficient> periodic_coefficients(const NonlinearModel& model) {
  constexpr std::size_t kMost = 4000;
  constexpr double kStepsOfPeak = 4.0;
  std::vector<PeriodicCoefficient> result;
  const std::vector<data::Expression> arguments =
      model.specification().formula.right.periodic_arguments();
  if (arguments.empty()) return result;
  const RowValues rows(model);
  for (std::size_t k = 0; k < model.specification().parameters.size(); ++k) {
    const std::optional<Index> coefficient = only_coefficient(model, static_cast<Index>(k));
    if (!coefficient) continue;
    for (const data::Expression& argument : arguments) {
      const auto by = multiplier(argument, k, model, rows);
      if (!by) continue;
      std::vector<double> distinct(by->values.begin(), by->values.end());
      std::ranges::sort(distinct);
      // Not std::ranges::unique, whose result clang 14 cannot compile.
      distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
      // A phase has the same multiplier at all observations.
      if (distinct.size() < 3) continue;
      const double range = distinct.back() - distinct.front();
      const double step = 2.0 * std::numbers::pi / (kStepsOfPeak * range);
      const auto count =
          static_cast<std::size_t>(0.5 * kStepsOfPeak * static_cast<double>(distinct.size() - 1));
      result.push_back({.coefficient = *coefficient,
                        .is_period = by->is_divided,
                        .step = step,
                        .count = std::min(kMost, count)});
      break;
    }
  }
  return result;
}

std::vector<PhaseCoefficient> phase_coefficients(const NonlinearModel& model,
                                                 const VectorXd& coefficients) {
  constexpr double kRounding = 1e-12;
  std::vector<PhaseCoefficient> result;
  const std::vector<data::Expression> arguments =
      model.specification().formula.right.periodic_arguments();
  const auto& parameters = model.specification().parameters;
  if (arguments.empty() || static_cast<Index>(parameters.size()) != coefficients.size()) return {};
  const RowValues rows(model);
  const std::vector<double> values(coefficients.begin(), coefficients.end());
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    for (const data::Expression& argument : arguments) {
      const data::Expression by = argument.derivative(parameters[k].name);
      if (by.is_zero()) continue;
      const VectorXd slopes = rows.of(by, values);
      const VectorXd angles = rows.of(argument, values);
      const double slope = slopes[0];
      const double change = (slopes.array() - slope).abs().maxCoeff();
      if (!(change <= kRounding * std::abs(slope)) || slope == 0.0 || !angles.allFinite()) continue;
      const double a = -angles.maxCoeff() / slope;
      const double b = -angles.minCoeff() / slope;
      result.push_back({.coefficient = static_cast<Index>(k),
                        .period = 2.0 * std::numbers::pi / std::abs(slope),
                        .lowest_shift = std::min(a, b),
                        .highest_shift = std::max(a, b)});
      break;
    }
  }
  return result;
}

}  // namespace silvafit::fit
