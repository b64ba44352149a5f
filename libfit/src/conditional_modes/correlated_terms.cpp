// SPDX-License-Identifier: MIT
#include "conditional_modes/correlated_terms.hpp"

#include <algorithm>
#include <string>

namespace silvafit::fit {
namespace {

using data::Expression;

class CorrelatedAssembly {
 public:
  CorrelatedAssembly(const NonlinearModel& model,
                     const VarianceModel& variance,
                     Curvature curvature,
                     const std::vector<Index>& random)
      : model_(model), variance_(variance), curvature_(curvature), random_(random) {
    const Expression mean = model.specification().formula.right;
    const Expression& center = is_first_order() ? at_population(mean) : mean;
    scale_ = Expression::variable(term_names::log_sigma()) +
             variance.log_scale().substitute(VarianceModel::fitted_name(), center);
    raw_ = Expression::variable(model.specification().formula.left) - mean;
    residual_ = raw_ * exp(-scale_);
    density_ = scale_ + adjoint(0) * residual_;
  }

  CorrelatedTerms terms() {
    if (holds_weights()) return held_terms();
    result_.density = scale_;
    add_random();
    add_fixed();
    add_variance();
    return std::move(result_);
  }

 private:
  bool is_first_order() const { return curvature_ == Curvature::kFirstOrder; }
  bool is_full() const { return curvature_ == Curvature::kFull; }
  bool holds_weights() const { return curvature_ == Curvature::kHeldWeights; }

  Expression at_population(Expression mean) const {
    for (const ParameterModel& parameter : model_.specification().parameters) {
      mean = mean.substitute(parameter.name,
                             Expression::variable(term_names::population(parameter.name)));
    }
    return mean;
  }

  static Expression adjoint(std::size_t k) { return Expression::variable(term_names::adjoint(k)); }

  Expression multiplier(Index coefficient) const {
    if (model_.design().multiplier(coefficient) == nullptr) return Expression::constant(1.0);
    return Expression::variable(term_names::multiplier(coefficient));
  }

  const std::string& parameter(Index coefficient) const {
    const auto k = static_cast<std::size_t>(model_.design().parameter_of(coefficient));
    return model_.specification().parameters[k].name;
  }

  /// The derivative by the random effect of a coefficient.
  Expression by_effect(const Expression& of, Index coefficient) const {
    return multiplier(coefficient) * of.derivative(parameter(coefficient));
  }

  /// The derivative by a coefficient, which moves the population's mean, too.
  Expression by_coefficient(const Expression& of, Index coefficient) const {
    Expression slope = of.derivative(parameter(coefficient));
    if (is_first_order()) {
      slope = slope + of.derivative(term_names::population(parameter(coefficient)));
    }
    return multiplier(coefficient) * slope;
  }

  /// The derivatives by the internal parameters of the scale and by log sigma.
  std::vector<Expression> by_scale(const Expression& of) const {
    std::vector<Expression> result;
    for (std::size_t k = 0; k < variance_.quantities().size(); ++k) {
      const VarianceModel::Quantity& quantity = variance_.quantities()[k];
      const Expression slope = of.derivative(quantity.name);
      if (quantity.strata < 0) {
        result.push_back(slope);
        continue;
      }
      for (Index s = 0; s < quantity.count; ++s) {
        result.push_back(Expression::variable(term_names::indicator(k, s)) * slope);
      }
    }
    result.push_back(of.derivative(term_names::log_sigma()));
    return result;
  }

  /// tr(M d2 x / db db') of an expression.
  Expression traced(const Expression& of) const {
    Expression sum = Expression::constant(0.0);
    const auto r = std::ssize(random_);
    for (Index j = 0; j < r; ++j) {
      const Expression slope = by_effect(of, random_[static_cast<std::size_t>(j)]);
      for (Index i = j; i < r; ++i) {
        // The matrix is symmetric: each pair off the diagonal counts twice.
        const Expression weight = Expression::variable(term_names::weight(i, j));
        sum = sum + (i == j ? 1.0 : 2.0) *
                        (weight * by_effect(slope, random_[static_cast<std::size_t>(i)]));
      }
    }
    return sum;
  }

  void add_random() {
    result_.states = {residual_};
    for (const Index b : random_) result_.states.push_back(by_effect(residual_, b));
    for (const Index b : random_) {
      result_.by_random.push_back(by_effect(density_, b));
      for (auto a = std::ranges::find(random_, b); a != random_.end(); ++a) {
        result_.curvature.push_back(by_effect(result_.by_random.back(), *a));
      }
    }
    const std::size_t r = random_.size();
    if (is_full()) {
      penalty_ = 0.5 * (traced(density_) + adjoint(1) * residual_);
      for (std::size_t c = 0; c < r; ++c) {
        penalty_ = penalty_ + adjoint(2 + c) * by_effect(residual_, random_[c]);
      }
      return;
    }
    result_.approximation.assign(result_.curvature.size(), Expression::constant(0.0));
    std::vector<Expression> slopes;
    for (std::size_t c = 0; c < r; ++c) {
      slopes.push_back(by_effect(scale_, random_[c]));
      // F from E = -F - e S.
      const Expression mean = -(by_effect(residual_, random_[c]) + residual_ * slopes.back());
      result_.states.push_back(mean);
      penalty_ = penalty_ + adjoint(2 + c) * mean + adjoint(2 + r + c) * slopes.back();
    }
    result_.states.insert(result_.states.end(), slopes.begin(), slopes.end());
  }

  void add_fixed() {
    const Expression total = density_ + penalty_;
    for (const Index b : random_) result_.penalty_by_random.push_back(by_effect(penalty_, b));
    for (Index j = 0; j < model_.column_count(); ++j) {
      const Expression slope = by_coefficient(density_, j);
      result_.density_by_fixed.push_back(slope);
      if (!is_first_order() && std::ranges::find(random_, j) != random_.end()) continue;
      result_.others.push_back(j);
      result_.by_other.push_back(by_coefficient(total, j));
      result_.wide_states.push_back(by_coefficient(residual_, j));
      for (const Index c : random_) result_.other_random.push_back(by_effect(slope, c));
    }
  }

  void add_variance() {
    result_.density_by_variance = by_scale(density_);
    result_.by_variance = by_scale(density_ + penalty_);
    for (const Expression& slope : result_.density_by_variance) {
      for (const Index c : random_) result_.variance_random.push_back(by_effect(slope, c));
    }
    for (const Expression& slope : by_scale(residual_)) result_.wide_states.push_back(slope);
    if (is_full()) result_.wide_states.push_back(traced(residual_));
  }

  CorrelatedTerms held_terms() {
    const Expression precision = exp(-scale_);
    const auto slope = [&](Index coefficient) { return by_effect(raw_, coefficient) * precision; };
    result_.states = {residual_};
    for (const Index b : random_) result_.states.push_back(slope(b));
    for (const Index b : random_) result_.by_random.push_back(adjoint(0) * slope(b));
    result_.curvature.assign(random_.size() * (random_.size() + 1) / 2, Expression::constant(0.0));
    const Expression held = Expression::variable(term_names::held_weight());
    result_.held = {raw_ * exp(0.5 * log(held))};
    result_.own_weight = {Expression::constant(0.0), precision * precision};
    for (Index j = 0; j < model_.column_count(); ++j) {
      if (std::ranges::find(random_, j) != random_.end()) continue;
      result_.others.push_back(j);
      result_.wide_states.push_back(slope(j));
      result_.other_random.insert(
          result_.other_random.end(), random_.size(), Expression::constant(0.0));
    }
    return std::move(result_);
  }

  const NonlinearModel& model_;
  const VarianceModel& variance_;
  Curvature curvature_;
  const std::vector<Index>& random_;
  Expression scale_ = Expression::constant(0.0);     ///< l
  Expression raw_ = Expression::constant(0.0);       ///< y - f
  Expression residual_ = Expression::constant(0.0);  ///< e
  Expression density_ = Expression::constant(0.0);   ///< l + a e
  Expression penalty_ = Expression::constant(0.0);   ///< whose derivatives are those of c
  CorrelatedTerms result_;
};

}  // namespace

CorrelatedTerms correlated_terms(const NonlinearModel& model,
                                 const VarianceModel& variance,
                                 Curvature curvature,
                                 const std::vector<Index>& random) {
  return CorrelatedAssembly(model, variance, curvature, random).terms();
}

}  // namespace silvafit::fit
