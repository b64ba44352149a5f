// SPDX-License-Identifier: MIT
#include "model/variance_weights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace silvafit::fit {
namespace {

using data::Expression;
using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;
using Kind = VarianceFactor::Kind;

// |v| below this share of its typical value would let one observation decide the power.
constexpr double kSmallestShare = 1e-4;
// Between a constant variance and one that grows in proportion.
constexpr double kStartExponent = 0.5;
// Below this share of the power at any observation, a constant variance cannot be told from
// constant-plus-power.
constexpr double kNoPower = 1e-10;
// Names of log|v| and 1/v of the fitted value v; no column can have them, since they have blanks.
constexpr const char* kLogarithm = "log of the fitted value";
constexpr const char* kInverse = "inverse of the fitted value";

double geometric_mean(const VectorXd& values) {
  double sum = 0.0;
  Index count = 0;
  for (const double value : values) {
    if (value == 0.0) continue;
    sum += std::log(std::abs(value));
    ++count;
  }
  return count == 0 ? 1.0 : std::exp(sum / static_cast<double>(count));
}

/// A text with v, d, k and numbers substituted. A substituted column may have the name of a
/// variable of the text, so these first get names in parentheses, which no column of a formula has.
Expression filled(std::string_view text,
                  const std::vector<std::pair<std::string_view, Expression>>& parts) {
  Expression result = Expression::parse(text);
  const auto distinct = [](std::string_view name) { return fmt::format("({})", name); };
  for (const auto& [name, value] : parts) {
    result = result.substitute(name, Expression::variable(distinct(name)));
  }
  for (const auto& [name, value] : parts) result = result.substitute(distinct(name), value);
  return result;
}

std::vector<std::string> columns_of(const VarianceFunction& function) {
  std::vector<std::string> columns;
  for (const VarianceFactor& factor : function.factors) {
    if (!factor.column.empty() && std::ranges::find(columns, factor.column) == columns.end()) {
      columns.push_back(factor.column);
    }
  }
  return columns;
}

}  // namespace

VarianceData VarianceData::of(const NonlinearModel& model) {
  VarianceData data;
  for (const VarianceFactor& factor : model.specification().variance.factors) {
    if (factor.column.empty()) {
      data.response = model.response();
    } else {
      data.columns[factor.column] = model.column(factor.column);
    }
    const auto is_its_own = [&](const auto& known) { return known.column == factor.stratum; };
    if (!factor.stratum.empty() && std::ranges::none_of(data.strata, is_its_own)) {
      data.strata.push_back(model.strata(factor.stratum));
    }
  }
  return data;
}

VarianceModel::VarianceModel(const VarianceFunction& function, VarianceData data)
    : function_(function),
      data_(std::move(data)),
      log_scale_(Expression::constant(0.0)),
      resolved_log_scale_(log_scale_) {
  for (std::size_t k = 0; k < function_.factors.size(); ++k) {
    typical_.push_back(typical(function_.factors[k]));
    const Expression factor = factor_expression(function_.factors[k], k);
    log_scale_ = filled("a + b", {{"a", log_scale_}, {"b", factor}});
  }
  resolved_log_scale_ = differentiated(log_scale_, 0);
  std::vector<data::Program::Input> inputs{{.name = fitted_name()}};
  for (const std::string& column : columns_of(function_)) inputs.push_back({.name = column});
  const Expression& logarithm = resolved_log_scale_;
  std::vector<Expression> outputs{logarithm, exp(-2.0 * logarithm)};
  for (const Quantity& quantity : quantities_) {
    inputs.push_back({.name = quantity.name, .is_scalar = quantity.strata < 0});
  }
  value_program_ = data::Program(outputs, inputs);
  for (const Quantity& quantity : quantities_) {
    outputs.push_back(logarithm.derivative(quantity.name));
  }
  derivative_program_ = data::Program(outputs, inputs);
}

const std::string& VarianceModel::fitted_name() {
  // No column can have this name in a formula, since it has a blank.
  static const std::string name = "fitted value";
  return name;
}

Expression VarianceModel::by_fitted(int order) const { return differentiated(log_scale_, order); }

Expression VarianceModel::by_fitted(int order, const std::string& quantity) const {
  return differentiated(log_scale_.derivative(quantity), order);
}

Expression VarianceModel::differentiated(Expression expression, int order) const {
  // With l = log|v| and i = 1/v, dl/dv = i and di/dv = -i^2; where |v| is floored, both are 0.
  const Expression inverse = Expression::variable(kInverse);
  for (int k = 0; k < order; ++k) {
    expression = expression.derivative(fitted_name()) +
                 expression.derivative(kLogarithm) * inverse -
                 expression.derivative(kInverse) * (inverse * inverse);
  }
  const Expression v = Expression::variable(fitted_name());
  const Expression floor = Expression::constant(smallest_);
  expression =
      expression.substitute(kLogarithm, filled("log(max(abs(v), f))", {{"f", floor}, {"v", v}}));
  return expression.substitute(kInverse,
                               filled("ifelse(abs(v) > f, 1/v, 0)", {{"f", floor}, {"v", v}}));
}

const VectorXd& VarianceModel::values_of(const VarianceFactor& factor) const {
  return factor.column.empty() ? data_.response : data_.columns.find(factor.column)->second;
}

double VarianceModel::typical(const VarianceFactor& factor) const {
  const VectorXd& values = values_of(factor);
  if (factor.kind != Kind::kExponential) return geometric_mean(values);
  const double mean = values.cwiseAbs().mean();
  return mean > 0.0 ? mean : 1.0;
}

int VarianceModel::strata_index(const VarianceFactor& factor) const {
  if (factor.stratum.empty()) return -1;
  const auto found =
      std::ranges::find(data_.strata, factor.stratum, &NonlinearModel::Strata::column);
  return static_cast<int>(found - data_.strata.begin());
}

Expression VarianceModel::quantity(std::size_t factor,
                                   Quantity::Kind kind,
                                   double start,
                                   double at_constant) {
  const VarianceFactor& of = function_.factors[factor];
  Quantity added{.kind = kind,
                 .name = fmt::format("quantity {}", quantities_.size()),
                 .factor = factor,
                 .strata = strata_index(of),
                 .first = parameter_count_,
                 .has_reference = of.kind == Kind::kStratum,
                 .start = start,
                 .at_constant = at_constant};
  if (added.strata >= 0) {
    const auto& labels = data_.strata[static_cast<std::size_t>(added.strata)].labels;
    added.count = static_cast<Index>(labels.size()) - (added.has_reference ? 1 : 0);
  }
  parameter_count_ += added.count;
  quantities_.push_back(added);
  return Expression::variable(added.name);
}

Expression VarianceModel::factor_expression(const VarianceFactor& factor, std::size_t index) {
  if (factor.kind == Kind::kStratum) return quantity(index, Quantity::Kind::kLogRatio, 0.0, 0.0);
  const bool has_strata = !factor.stratum.empty();
  const double typical = typical_[index];
  const Expression v = Expression::variable(factor.column.empty() ? fitted_name() : factor.column);
  if (factor.kind == Kind::kExponential) {
    const Expression d = factor.delta
                             ? Expression::constant(*factor.delta * typical)
                             : quantity(index, Quantity::Kind::kDelta, kStartExponent, 0.0);
    return filled("d*(v/t - o)",
                  {{"v", v},
                   {"t", Expression::constant(typical)},
                   {"o", Expression::constant(has_strata || factor.delta ? 0.0 : 1.0)},
                   {"d", d}});
  }
  // Where sigma may not depend on the function's own parameters, |v| itself is the base.
  const bool is_plain = has_strata || factor.delta || factor.constant;
  const double base = is_plain ? 1.0 : typical;
  const Expression smallest = Expression::constant(kSmallestShare * typical);
  Expression logarithm = Expression::variable(kLogarithm);
  if (factor.column.empty()) {
    smallest_ = kSmallestShare * typical;
  } else {
    logarithm = filled("log(max(abs(v), f))", {{"f", smallest}, {"v", v}});
  }
  logarithm = logarithm - Expression::constant(std::log(base));
  const Expression d = factor.delta ? Expression::constant(*factor.delta)
                                    : quantity(index, Quantity::Kind::kDelta, kStartExponent, 0.0);
  if (factor.kind == Kind::kPower) return filled("d*l", {{"d", d}, {"l", logarithm}});
  if (factor.constant) {
    const Expression constant = Expression::constant(*factor.constant);
    return filled("log(c + exp(d*l))", {{"c", constant}, {"d", d}, {"l", logarithm}});
  }
  if (is_plain) {
    const double start = std::pow(typical, 0.5 * factor.delta.value_or(kStartExponent));
    const Expression k = quantity(index, Quantity::Kind::kConstant, start, 1.0);
    return filled("log(k*k + exp(d*l))", {{"k", k}, {"d", d}, {"l", logarithm}});
  }
  constexpr double kPi = std::numbers::pi;
  const Expression k = quantity(index, Quantity::Kind::kConstant, kPi / 4.0, kPi / 2.0);
  return filled("log(sin(k)^2 + cos(k)^2*exp(d*l))", {{"k", k}, {"d", d}, {"l", logarithm}});
}

VectorXd VarianceModel::start() const {
  VectorXd parameters(parameter_count());
  for (const Quantity& quantity : quantities_) {
    parameters.segment(quantity.first, quantity.count).setConstant(quantity.start);
  }
  return parameters;
}

VectorXd VarianceModel::constant() const {
  VectorXd parameters(parameter_count());
  for (const Quantity& quantity : quantities_) {
    parameters.segment(quantity.first, quantity.count).setConstant(quantity.at_constant);
  }
  return parameters;
}

bool VarianceModel::uses_fitted() const {
  return std::ranges::any_of(function_.factors, [](const VarianceFactor& factor) {
    return factor.column.empty() && factor.kind != Kind::kStratum;
  });
}

VectorXd VarianceModel::values(int quantity, const VectorXd& parameters) const {
  const Quantity& of = quantities_[static_cast<std::size_t>(quantity)];
  VectorXd result = VectorXd::Zero(of.count + (of.has_reference ? 1 : 0));
  result.tail(of.count) = parameters.segment(of.first, of.count);
  return result;
}

ResidualScale VarianceModel::scale(const VectorXd& fitted,
                                   const VectorXd& parameters,
                                   bool with_derivatives) const {
  const Index n = fitted.size();
  ResidualScale result;
  if (with_derivatives) result.log_derivative.setZero(n, parameter_count());
  if (function_.is_constant()) {
    result.weight.setOnes(n);
    return result;
  }
  std::vector<const double*> inputs{fitted.data()};
  for (const std::string& column : columns_of(function_)) {
    inputs.push_back(data_.columns.find(column)->second.data());
  }
  std::vector<VectorXd> by_row(quantities_.size());
  for (std::size_t k = 0; k < quantities_.size(); ++k) {
    by_row[k] = values(static_cast<int>(k), parameters);
    if (quantities_[k].strata >= 0) {
      const auto& strata = data_.strata[static_cast<std::size_t>(quantities_[k].strata)].of_rows;
      by_row[k] = by_row[k](strata).eval();
    }
    inputs.push_back(by_row[k].data());
  }
  ArrayXd logarithm(n);
  result.weight.resize(n);
  std::vector<double*> outputs{logarithm.data(), result.weight.data()};
  Eigen::ArrayXXd by_quantity;
  if (with_derivatives) by_quantity.resize(n, static_cast<Index>(quantities_.size()));
  for (Index k = 0; k < by_quantity.cols(); ++k) outputs.push_back(by_quantity.col(k).data());
  data::Program::Workspace workspace;
  const data::Program& program = with_derivatives ? derivative_program_ : value_program_;
  program.evaluate(inputs, static_cast<std::size_t>(n), outputs, workspace);
  result.sum_log = logarithm.sum();
  for (Index k = 0; k < by_quantity.cols(); ++k) {
    const Quantity& quantity = quantities_[static_cast<std::size_t>(k)];
    if (quantity.strata < 0) {
      result.log_derivative.col(quantity.first) = by_quantity.col(k);
      continue;
    }
    const auto& strata = data_.strata[static_cast<std::size_t>(quantity.strata)].of_rows;
    const Index skipped = quantity.has_reference ? 1 : 0;
    for (Index i = 0; i < n; ++i) {
      const Index stratum = strata[static_cast<std::size_t>(i)] - skipped;
      if (stratum >= 0) result.log_derivative(i, quantity.first + stratum) = by_quantity(i, k);
    }
  }
  return result;
}

Index VarianceModel::floored(const VectorXd& fitted) const {
  Index count = 0;
  for (std::size_t k = 0; k < function_.factors.size(); ++k) {
    const VarianceFactor& factor = function_.factors[k];
    if (factor.kind != Kind::kPower && factor.kind != Kind::kConstantPlusPower) continue;
    const VectorXd& v = factor.column.empty() ? fitted : data_.columns.find(factor.column)->second;
    count += (v.array().abs() < kSmallestShare * typical_[k]).count();
  }
  return count;
}

int VarianceModel::find(std::size_t factor, Quantity::Kind kind) const {
  const auto found = std::ranges::find_if(quantities_, [&](const Quantity& quantity) {
    return quantity.factor == factor && quantity.kind == kind;
  });
  return found == quantities_.end() ? -1 : static_cast<int>(found - quantities_.begin());
}

bool VarianceModel::is_without_power(std::size_t index, const VectorXd& parameters) const {
  const double angle = values(find(index, Quantity::Kind::kConstant), parameters)[0];
  const double delta = values(find(index, Quantity::Kind::kDelta), parameters)[0];
  const ArrayXd shares =
      (values_of(function_.factors[index]).array().abs() / typical_[index]).max(kSmallestShare);
  const double growth =
      std::max(std::pow(shares.maxCoeff(), delta), std::pow(shares.minCoeff(), delta));
  return std::pow(std::cos(angle), 2) * growth < kNoPower;
}

VarianceFactorEstimate VarianceModel::factor_estimate(std::size_t index,
                                                      const VectorXd& parameters) const {
  const VarianceFactor& factor = function_.factors[index];
  const int strata = strata_index(factor);
  VarianceFactorEstimate result{.factor = factor, .strata = {""}};
  if (strata >= 0) result.strata = data_.strata[static_cast<std::size_t>(strata)].labels;
  const auto count = static_cast<Index>(result.strata.size());
  if (factor.kind == Kind::kStratum) {
    result.ratio = values(find(index, Quantity::Kind::kLogRatio), parameters).array().exp();
    return result;
  }
  const int delta = find(index, Quantity::Kind::kDelta);
  result.delta = delta < 0 ? VectorXd::Constant(count, *factor.delta) : values(delta, parameters);
  if (delta >= 0 && factor.kind == Kind::kExponential) result.delta /= typical_[index];
  if (factor.kind != Kind::kConstantPlusPower) return result;
  const int constant = find(index, Quantity::Kind::kConstant);
  if (constant < 0) {
    result.constant = VectorXd::Constant(count, *factor.constant);
  } else if (strata >= 0 || factor.delta) {
    result.constant = values(constant, parameters).array().square();
  } else if (is_without_power(index, parameters)) {
    result.constant.setConstant(1, std::numeric_limits<double>::infinity());
  } else {
    const double odds = std::pow(std::tan(values(constant, parameters)[0]), 2);
    result.constant.setConstant(1, odds * std::pow(typical_[index], result.delta[0]));
  }
  return result;
}

VarianceEstimate VarianceModel::estimate(const VectorXd& parameters) const {
  VarianceEstimate result;
  for (std::size_t k = 0; k < function_.factors.size(); ++k) {
    result.factors.push_back(factor_estimate(k, parameters));
  }
  return result;
}

VectorXd VarianceModel::parameters(const VarianceEstimate& estimate) const {
  VectorXd result(parameter_count());
  for (const Quantity& quantity : quantities_) {
    const VarianceFactorEstimate& of = estimate.factors[quantity.factor];
    auto target = result.segment(quantity.first, quantity.count);
    if (of.factor.kind == Kind::kStratum) {
      target = of.ratio.tail(quantity.count).array().log();
    } else if (quantity.kind == Quantity::Kind::kDelta) {
      const bool is_rate = of.factor.kind == Kind::kExponential;
      target = of.delta * (is_rate ? typical_[quantity.factor] : 1.0);
    } else if (quantity.strata >= 0 || of.factor.delta) {
      target = of.constant.cwiseSqrt();
    } else {
      const double odds = of.constant[0] / std::pow(typical_[quantity.factor], of.delta[0]);
      target[0] = std::atan(std::sqrt(odds));
    }
  }
  return result;
}

VectorXd VarianceModel::inside_range(const VarianceEstimate& estimate) const {
  constexpr double kShare = 0.1;
  VectorXd parameters = this->parameters(estimate);
  for (const Quantity& quantity : quantities_) {
    if (quantity.kind != Quantity::Kind::kConstant) continue;
    const double least = kShare * quantity.start;
    // Of one number it is an angle up to a right one; of strata, a root without an upper end.
    const bool is_angle =
        quantity.strata < 0 && !estimate.factors[quantity.factor].factor.delta.has_value();
    for (Index k = quantity.first; k < quantity.first + quantity.count; ++k) {
      double& value = parameters[k];
      value = std::max(value, least);
      if (is_angle) value = std::min(value, std::numbers::pi / 2.0 - least);
    }
  }
  return parameters;
}

double VarianceModel::log_scale_of(const VarianceEstimate& estimate, double sigma) const {
  double result = std::log(sigma);
  for (std::size_t k = 0; k < function_.factors.size(); ++k) {
    const VarianceFactor& factor = function_.factors[k];
    // These are used as they are defined.
    if (!factor.stratum.empty() || factor.delta || factor.constant) continue;
    const VarianceFactorEstimate& of = estimate.factors[k];
    if (factor.kind == Kind::kExponential) {
      result += of.delta[0] * typical_[k];
    } else if (factor.kind == Kind::kPower) {
      result += of.delta[0] * std::log(typical_[k]);
    } else if (!std::isinf(of.constant[0])) {
      // With tan^2 phi = c / v0^delta, c + |v|^delta is (c + v0^delta) times the internal function.
      result += std::log(of.constant[0] + std::pow(typical_[k], of.delta[0]));
    }
  }
  return result;
}

double VarianceModel::sigma_factor(const VectorXd& parameters) const {
  double result = 1.0;
  for (std::size_t k = 0; k < function_.factors.size(); ++k) {
    const VarianceFactor& factor = function_.factors[k];
    // These are used as they are defined.
    if (!factor.stratum.empty() || factor.delta || factor.constant) continue;
    const double delta = values(find(k, Quantity::Kind::kDelta), parameters)[0];
    if (factor.kind == Kind::kExponential) {
      result *= std::exp(-delta);
      continue;
    }
    result *= std::pow(typical_[k], -delta);
    if (factor.kind == Kind::kConstantPlusPower) {
      // An infinite constant stands for the factor 1, so that sigma is the residual scale itself.
      const double share =
          std::pow(std::cos(values(find(k, Quantity::Kind::kConstant), parameters)[0]), 2);
      result *= is_without_power(k, parameters) ? std::pow(typical_[k], delta) : share;
    }
  }
  return result;
}

}  // namespace silvafit::fit
