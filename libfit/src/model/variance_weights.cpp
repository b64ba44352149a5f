// SPDX-License-Identifier: MIT
#include "model/variance_weights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace silvafit::fit {
namespace {

using data::Expression;
using Eigen::ArrayXd;

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

VarianceData VarianceData::of(const NonlinearModel& model, const CorrelationEstimate* known) {
  VarianceData data;
  data.correlated = CorrelatedRows::of(model, known);
  for (const VarianceFactor& factor : model.specification().variance.factors) {
    if (factor.column.empty()) {
      data.response = model.response();
    } else {
      data.columns[factor.column] = model.column(factor.column);
    }
    const auto is_its_own = [&](const auto& one) { return one.column == factor.stratum; };
    if (!factor.stratum.empty() && std::ranges::none_of(data.strata, is_its_own)) {
      data.strata.push_back(model.strata(factor.stratum));
    }
  }
  return data;
}

/// The variables in the log scale of one factor: those of the model's quantities.
class VarianceModel::FactorTerms : public LogScaleTerms {
 public:
  FactorTerms(VarianceModel& model, std::size_t index)
      : LogScaleTerms(model.function_.factors[index], model.typical_[index]),
        model_(model),
        index_(index) {}

  Expression value() const override {
    return Expression::variable(factor().column.empty() ? fitted_name() : factor().column);
  }

  Expression logarithm() override {
    const Expression smallest = Expression::constant(kSmallestShare * typical().middle);
    const Expression result = filled("log(max(abs(v), f))", {{"f", smallest}, {"v", value()}});
    return result - Expression::constant(is_plain() ? 0.0 : std::log(typical().middle));
  }

  Expression estimated(VarianceQuantity kind, double start, double at_constant) override {
    return model_.quantity(index_, kind, start, at_constant);
  }

 private:
  VarianceModel& model_;
  std::size_t index_;
};

VarianceModel::VarianceModel(const VarianceFunction& function, VarianceData data)
    : function_(function), data_(std::move(data)), log_scale_(Expression::constant(0.0)) {
  for (std::size_t k = 0; k < function_.factors.size(); ++k) {
    const VarianceFactor& of = function_.factors[k];
    typical_.push_back(data_.typical.empty() ? kind_of(of).typical(values_of(of))
                                             : data_.typical[k]);
    FactorTerms terms(*this, k);
    const Expression factor = kind_of(of).log_scale(terms);
    log_scale_ = filled("a + b", {{"a", log_scale_}, {"b", factor}});
  }
  std::vector<data::Program::Input> inputs{{.name = fitted_name()}};
  for (const std::string& column : columns_of(function_)) inputs.push_back({.name = column});
  std::vector<Expression> outputs{log_scale_, exp(-2.0 * log_scale_)};
  for (const Quantity& quantity : quantities_) {
    inputs.push_back({.name = quantity.name, .is_scalar = quantity.strata < 0});
  }
  value_program_ = data::Program(outputs, inputs);
  for (const Quantity& quantity : quantities_) {
    outputs.push_back(log_scale_.derivative(quantity.name));
  }
  derivative_program_ = data::Program(outputs, inputs);
}

const std::string& VarianceModel::fitted_name() {
  // No column can have this name in a formula, because it has a blank.
  static const std::string name = "fitted value";
  return name;
}

const VectorXd& VarianceModel::values_of(const VarianceFactor& factor) const {
  return factor.column.empty() ? data_.response : data_.columns.find(factor.column)->second;
}

int VarianceModel::strata_index(const VarianceFactor& factor) const {
  if (factor.stratum.empty()) return -1;
  const auto found =
      std::ranges::find(data_.strata, factor.stratum, &NonlinearModel::Strata::column);
  return static_cast<int>(found - data_.strata.begin());
}

Expression VarianceModel::quantity(std::size_t factor,
                                   VarianceQuantity kind,
                                   double start,
                                   double at_constant) {
  const VarianceFactor& of = function_.factors[factor];
  Quantity added{.kind = kind,
                 .name = fmt::format("quantity {}", quantities_.size()),
                 .factor = factor,
                 .strata = strata_index(of),
                 .first = scale_parameter_count_,
                 .has_reference = kind == VarianceQuantity::kLogRatio,
                 .start = start,
                 .at_constant = at_constant};
  if (added.strata >= 0) {
    const auto& labels = data_.strata[static_cast<std::size_t>(added.strata)].labels;
    added.count = static_cast<Index>(labels.size()) - (added.has_reference ? 1 : 0);
  }
  scale_parameter_count_ += added.count;
  quantities_.push_back(added);
  return Expression::variable(added.name);
}

void VarianceModel::set_correlation(const CorrelationEstimate* estimate,
                                    VectorXd& parameters) const {
  if (correlated() == nullptr) return;
  const CorrelationStructure& structure = correlated()->structure();
  const bool is_known = estimate != nullptr &&
                        estimate->correlation.kind == structure.correlation().kind &&
                        estimate->values.size() == correlation_count();
  parameters.tail(correlation_count()) =
      is_known ? structure.unconstrained(estimate->values) : structure.starts().front();
}

VectorXd VarianceModel::start() const {
  VectorXd parameters(parameter_count());
  set_correlation(nullptr, parameters);
  for (const Quantity& quantity : quantities_) {
    parameters.segment(quantity.first, quantity.count).setConstant(quantity.start);
  }
  return parameters;
}

std::vector<VectorXd> VarianceModel::starts() const {
  // The powers of the largest and smallest value differ by these factors.
  constexpr std::array kLogRatios{-512.0, -128.0, -32.0, -8.0, -2.0, 8.0, 32.0, 128.0, 512.0};
  std::vector<VectorXd> result{start()};
  for (const Quantity& constant : quantities_) {
    const VarianceFactor& factor = function_.factors[constant.factor];
    const bool has_power = constant.kind == VarianceQuantity::kConstant && !factor.delta;
    const TypicalValue& typical = typical_[constant.factor];
    if (!has_power || constant.strata >= 0 || typical.high == typical.low) continue;
    const auto delta = std::ranges::find_if(quantities_, [&](const Quantity& other) {
      return other.factor == constant.factor && other.kind == VarianceQuantity::kDelta;
    });
    for (const double log_ratio : kLogRatios) {
      result.push_back(result.front());
      result.back()[delta->first] = log_ratio / std::log(typical.high / typical.low);
    }
  }
  return result;
}

VectorXd VarianceModel::constant() const {
  VectorXd parameters(parameter_count());
  set_correlation(nullptr, parameters);
  for (const Quantity& quantity : quantities_) {
    parameters.segment(quantity.first, quantity.count).setConstant(quantity.at_constant);
  }
  return parameters;
}

bool VarianceModel::uses_fitted() const {
  return std::ranges::any_of(function_.factors, [](const VarianceFactor& factor) {
    return factor.column.empty() && kind_of(factor).reads_value();
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
    if (!kind_of(factor).reads_logarithm()) continue;
    const VectorXd& v = factor.column.empty() ? fitted : data_.columns.find(factor.column)->second;
    count += (v.array().abs() < kSmallestShare * typical_[k].middle).count();
  }
  return count;
}

VarianceFactorEstimate VarianceModel::factor_estimate(std::size_t index,
                                                      const VectorXd& parameters) const {
  const VarianceFactor& factor = function_.factors[index];
  const int strata = strata_index(factor);
  VarianceFactorEstimate result{.factor = factor, .strata = {""}};
  if (strata >= 0) result.strata = data_.strata[static_cast<std::size_t>(strata)].labels;
  InternalFactor internal{.factor = factor, .typical = typical_[index]};
  for (std::size_t k = 0; k < quantities_.size(); ++k) {
    if (quantities_[k].factor != index) continue;
    const VectorXd values = this->values(static_cast<int>(k), parameters);
    switch (quantities_[k].kind) {
      case VarianceQuantity::kDelta:
        internal.delta = values;
        break;
      case VarianceQuantity::kConstant:
        internal.constant = values;
        break;
      case VarianceQuantity::kLogRatio:
        internal.log_ratio = values;
        break;
    }
  }
  kind_of(factor).estimate(internal, result);
  return result;
}

VarianceEstimate VarianceModel::estimate(const VectorXd& parameters) const {
  VarianceEstimate result;
  for (std::size_t k = 0; k < function_.factors.size(); ++k) {
    result.factors.push_back(factor_estimate(k, parameters));
  }
  if (correlated() != nullptr) {
    result.correlation = correlated()->structure().estimate(correlation_part(parameters));
  }
  return result;
}

VectorXd VarianceModel::parameters(const VarianceEstimate& estimate) const {
  VectorXd result(parameter_count());
  for (const Quantity& quantity : quantities_) {
    const VarianceFactorEstimate& of = estimate.factors[quantity.factor];
    result.segment(quantity.first, quantity.count) =
        kind_of(of.factor)
            .internal(quantity.kind, of, typical_[quantity.factor])
            .tail(quantity.count);
  }
  set_correlation(estimate.correlation ? &*estimate.correlation : nullptr, result);
  return result;
}

VectorXd VarianceModel::inside_range(const VarianceEstimate& estimate) const {
  constexpr double kShare = 0.1;
  VectorXd parameters = this->parameters(estimate);
  for (const Quantity& quantity : quantities_) {
    if (quantity.kind != VarianceQuantity::kConstant) continue;
    const double least = kShare * quantity.start;
    // For a single number it is an angle up to pi/2; for strata, a root without an upper bound.
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

double VarianceModel::log_offset(const VarianceEstimate& estimate) const {
  double result = 0.0;
  for (std::size_t k = 0; k < function_.factors.size(); ++k) {
    const VarianceFactor& factor = function_.factors[k];
    // These are used as they are defined.
    if (!factor.stratum.empty() || factor.delta || factor.constant) continue;
    result += kind_of(factor).log_offset(estimate.factors[k], typical_[k]);
  }
  return result;
}

double VarianceModel::log_scale_of(const VarianceEstimate& estimate, double sigma) const {
  return std::log(sigma) + log_offset(estimate);
}

double VarianceModel::sigma_factor(const VectorXd& parameters) const {
  return std::exp(-log_offset(estimate(parameters)));
}

}  // namespace silvafit::fit
