// SPDX-License-Identifier: MIT
#include "variance_weights.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace silvafit::fit {
namespace {

using Eigen::ArrayXd;
using Eigen::VectorXd;
using Kind = VarianceFunction::Kind;

// |v| below this share of its typical value would let one observation decide the power.
constexpr double kSmallestShare = 1e-4;

double geometric_mean(const VectorXd& values) {
  double sum = 0.0;
  Eigen::Index count = 0;
  for (const double value : values) {
    if (value == 0.0) continue;
    sum += std::log(std::abs(value));
    ++count;
  }
  return count == 0 ? 1.0 : std::exp(sum / static_cast<double>(count));
}

}  // namespace

VarianceModel::VarianceModel(const VarianceFunction& function, const VectorXd& typical_values)
    : function_(function) {
  if (function_.kind == Kind::kExponential) {
    const double mean = typical_values.cwiseAbs().mean();
    typical_ = mean > 0.0 ? mean : 1.0;
  } else {
    typical_ = geometric_mean(typical_values);
  }
}

VectorXd VarianceModel::start() const {
  // Between a constant variance and one that grows in proportion.
  VectorXd parameters = VectorXd::Constant(parameter_count(), 0.5);
  if (function_.kind == Kind::kConstantPlusPower) parameters[1] = std::numbers::pi / 4.0;
  return parameters;
}

VectorXd VarianceModel::constant() const {
  VectorXd parameters = VectorXd::Zero(parameter_count());
  if (function_.kind == Kind::kConstantPlusPower) parameters[1] = std::numbers::pi / 2.0;
  return parameters;
}

ArrayXd VarianceModel::log_relative(const VectorXd& v) const {
  return (v.array().abs() / typical_).max(kSmallestShare).log();
}

Eigen::Index VarianceModel::floored(const VectorXd& v) const {
  if (function_.kind != Kind::kPower && function_.kind != Kind::kConstantPlusPower) return 0;
  return (v.array().abs() < kSmallestShare * typical_).count();
}

ResidualScale VarianceModel::scale(const VectorXd& v,
                                   const VectorXd& parameters,
                                   bool with_derivatives) const {
  ResidualScale result;
  if (with_derivatives) result.log_derivative.resize(v.size(), parameter_count());
  if (function_.kind == Kind::kNone) {
    result.weight.setOnes(v.size());
    return result;
  }
  if (function_.kind == Kind::kConstantPlusPower) {
    const ArrayXd logarithm = log_relative(v);
    const ArrayXd power = (parameters[0] * logarithm).exp();
    const double share = std::pow(std::sin(parameters[1]), 2);
    const ArrayXd g = share + (1.0 - share) * power;
    result.weight = g.square().inverse();
    result.sum_log = g.log().sum();
    if (with_derivatives) {
      result.log_derivative.col(0) = (1.0 - share) * power * logarithm / g;
      result.log_derivative.col(1) = std::sin(2.0 * parameters[1]) * (1.0 - power) / g;
    }
    return result;
  }
  // Both others are exp(parameter * t) with t independent of the parameter.
  const ArrayXd t =
      function_.kind == Kind::kPower ? log_relative(v) : ArrayXd(v.array() / typical_ - 1.0);
  result.weight = (-2.0 * parameters[0] * t).exp();
  result.sum_log = parameters[0] * t.sum();
  if (with_derivatives) result.log_derivative.col(0) = t;
  return result;
}

VarianceEstimate VarianceModel::estimate(const VectorXd& parameters) const {
  VarianceEstimate result{.function = function_};
  switch (function_.kind) {
    case Kind::kNone:
      break;
    case Kind::kExponential:
      result.delta = parameters[0] / typical_;
      break;
    case Kind::kPower:
      result.delta = parameters[0];
      break;
    case Kind::kConstantPlusPower: {
      result.delta = parameters[0];
      const double odds = std::pow(std::tan(parameters[1]), 2);
      result.constant = odds * std::pow(typical_, parameters[0]);
      if (std::pow(std::cos(parameters[1]), 2) < 1e-12) {
        result.constant = std::numeric_limits<double>::infinity();
      }
      break;
    }
  }
  return result;
}

double VarianceModel::sigma_factor(const VectorXd& parameters) const {
  switch (function_.kind) {
    case Kind::kNone:
      return 1.0;
    case Kind::kExponential:
      return std::exp(-parameters[0]);
    case Kind::kPower:
      return std::pow(typical_, -parameters[0]);
    case Kind::kConstantPlusPower:
      return std::pow(std::cos(parameters[1]), 2) * std::pow(typical_, -parameters[0]);
  }
  return 1.0;
}

}  // namespace silvafit::fit
