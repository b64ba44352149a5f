// SPDX-License-Identifier: MIT
#include "conditional_modes/observation_terms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace silvafit::fit {

namespace term_names {
std::string log_sigma() { return "log sigma"; }
std::string population(const std::string& parameter) { return "population " + parameter; }
std::string multiplier(Index coefficient) { return fmt::format("multiplier {}", coefficient); }
std::string indicator(std::size_t quantity, Index stratum) {
  return fmt::format("indicator {} {}", quantity, stratum);
}
std::string weight(Index i, Index j) { return fmt::format("weight {} {}", i, j); }
std::string held_weight() { return "held weight"; }
std::string adjoint(std::size_t k) { return fmt::format("adjoint {}", k); }
}  // namespace term_names

namespace {

using data::Expression;

/// The mean f and its derivatives by the model's parameters up to the third order.
class MeanDerivatives {
 public:
  MeanDerivatives(const NonlinearModel& model, bool at_population) {
    for (const ParameterModel& parameter : model.specification().parameters) {
      names_.push_back(parameter.name);
    }
    Expression mean = model.specification().formula.right;
    if (at_population) {
      for (std::string& name : names_) {
        const std::string other = term_names::population(name);
        mean = mean.substitute(name, Expression::variable(other));
        name = other;
      }
    }
    derivatives_.emplace(std::vector<Index>{}, mean);
  }

  const Expression& mean() { return derivative({}); }
  const Expression& by(Index k) { return derivative({k}); }
  const Expression& by(Index k, Index l) { return derivative({k, l}); }
  const Expression& by(Index k, Index l, Index m) { return derivative({k, l, m}); }

 private:
  const Expression& derivative(std::vector<Index> parameters) {
    std::ranges::sort(parameters);
    const auto known = derivatives_.find(parameters);
    if (known != derivatives_.end()) return known->second;
    const auto last = static_cast<std::size_t>(parameters.back());
    const std::vector<Index> before(parameters.begin(), parameters.end() - 1);
    const Expression next = derivative(before).derivative(names_[last]);
    return derivatives_.emplace(std::move(parameters), next).first->second;
  }

  std::vector<std::string> names_;
  std::map<std::vector<Index>, Expression> derivatives_;
};

/// log g and its derivatives by the fitted value and by the quantities of the variance function,
/// with the mean substituted for the fitted value.
class ScaleDerivatives {
 public:
  ScaleDerivatives(const VarianceModel& variance, const Expression& mean)
      : log_scale_(variance.log_scale()), mean_(mean) {
    for (const VarianceModel::Quantity& quantity : variance.quantities()) {
      names_.push_back(quantity.name);
    }
  }

  std::size_t quantity_count() const { return names_.size(); }
  Expression value() const { return at_mean(log_scale_); }
  /// The derivative of an order by the fitted value: kappa, kappa', kappa''.
  Expression by_fitted(int order) const { return at_mean(repeated(log_scale_, order)); }
  /// The same of the derivative by a quantity.
  Expression by_quantity(std::size_t quantity, int order) const {
    return at_mean(repeated(log_scale_.derivative(names_[quantity]), order));
  }

 private:
  static Expression repeated(Expression expression, int order) {
    for (int k = 0; k < order; ++k) {
      expression = expression.derivative(VarianceModel::fitted_name());
    }
    return expression;
  }
  Expression at_mean(const Expression& expression) const {
    return expression.substitute(VarianceModel::fitted_name(), mean_);
  }

  Expression log_scale_;
  Expression mean_;
  std::vector<std::string> names_;
};

/// Derivatives of rho by the mean and by a parameter of the variance, and the same of the factor
/// omega of f_b f_b' in K.
struct DensityDerivatives {
  Expression value = Expression::constant(0.0);
  Expression first = Expression::constant(0.0);   ///< rho' by the mean
  Expression second = Expression::constant(0.0);  ///< rho''
  Expression omega = Expression::constant(0.0);
  Expression omega_first = Expression::constant(0.0);  ///< omega' by the mean
};
struct VarianceDerivatives {
  Expression value = Expression::constant(0.0);   ///< by the parameter
  Expression first = Expression::constant(0.0);   ///< of rho'
  Expression second = Expression::constant(0.0);  ///< of rho''
  Expression omega = Expression::constant(0.0);
};

/// The parts that all derivatives of rho share.
struct Residual {
  Expression raw;      ///< r = y - f
  Expression scaled;   ///< r tau = (y - f) / (sigma g)^2
  Expression squared;  ///< r^2 tau
  Expression tau;      ///< 1 / (sigma g)^2
};

Residual residual_of(const NonlinearModel& model, const Expression& mean, const Expression& scale) {
  const Expression r = Expression::variable(model.specification().formula.left) - mean;
  const Expression tau = exp(-2.0 * (Expression::variable(term_names::log_sigma()) + scale));
  const Expression scaled = r * tau;
  return {.raw = r, .scaled = scaled, .squared = r * scaled, .tau = tau};
}

Expression density_of(const Residual& residual, const Expression& scale) {
  return Expression::variable(term_names::log_sigma()) + scale + 0.5 * residual.squared;
}

/// Everything about one observation, assembled by the chain rule.
class Assembly {
 public:
  Assembly(const NonlinearModel& model,
           const VarianceModel& variance,
           Curvature curvature,
           const std::vector<Index>& random)
      : model_(model),
        variance_(variance),
        curvature_(curvature),
        random_(random),
        mean_(model, false),
        population_(model, true),
        scale_(variance, is_first_order() ? population_.mean() : mean_.mean()),
        residual_(residual_of(model, mean_.mean(), scale_.value())) {}

  ModeTerms mode_terms() {
    differentiate_density();
    ModeTerms result{.density = density_.value};
    if (holds_weights()) {
      const Expression held = Expression::variable(term_names::held_weight());
      result.density = 0.5 * (residual_.raw * residual_.raw * held);
      result.own_weight = {density_.value, residual_.tau};
    }
    add_random_terms(result);
    add_mixed_terms(result);
    return result;
  }

  ObservationTerms terms() {
    ObservationTerms result{mode_terms()};
    collapse_weights();
    for (const Index b : random_) {
      result.penalty_by_random.push_back(multiplier(b) * penalty_slope(parameter(b)));
    }
    add_fixed_terms(result);
    add_variance_terms(result);
    return result;
  }

 private:
  bool is_first_order() const { return curvature_ == Curvature::kFirstOrder; }
  bool holds_weights() const {
    return curvature_ == Curvature::kHeldWeights && variance_.uses_fitted();
  }

  void differentiate_density() {
    const auto& [raw, scaled, squared, tau] = residual_;
    if (curvature_ == Curvature::kHeldWeights) {
      density_.value = 0.5 * squared;
      density_.first = -scaled;
      density_.second = tau + 2.0 * (scale_.by_fitted(1) * scaled);
      density_.omega = tau;
      return;
    }
    density_.value = density_of(residual_, scale_.value());
    if (is_first_order()) {
      density_.first = -scaled;
      density_.second = tau;
      density_.omega = tau;
      return;
    }
    const Expression kappa = scale_.by_fitted(1);
    const Expression kappa1 = scale_.by_fitted(2);
    const Expression kappa2 = scale_.by_fitted(3);
    const Expression free = Expression::constant(1.0) - squared;
    density_.first = kappa * free - scaled;
    density_.second =
        kappa1 * free + tau + 4.0 * (kappa * scaled) + 2.0 * (kappa * kappa * squared);
    if (curvature_ == Curvature::kFull) {
      density_.omega = density_.second;
      density_.omega_first = kappa2 * free - 6.0 * (kappa * tau) + 6.0 * (kappa1 * scaled) -
                             12.0 * (kappa * kappa * scaled) + 6.0 * (kappa * kappa1 * squared) -
                             4.0 * (kappa * kappa * kappa * squared);
    } else {
      density_.omega = tau + 2.0 * (kappa * kappa);
      density_.omega_first = -2.0 * (kappa * tau) + 4.0 * (kappa * kappa1);
    }
  }

  /// By a quantity of the variance function, or by log sigma (the number after the last quantity).
  VarianceDerivatives by_variance(std::size_t quantity) const {
    const auto& [raw, scaled, squared, tau] = residual_;
    const bool is_sigma = quantity == scale_.quantity_count();
    const Expression l = is_sigma ? Expression::constant(1.0) : scale_.by_quantity(quantity, 0);
    const Expression free = Expression::constant(1.0) - squared;
    VarianceDerivatives result{.value = l * free};
    if (is_first_order()) {
      result.first = 2.0 * (l * scaled);
      result.omega = -2.0 * (l * tau);
      return result;
    }
    const Expression kappa = scale_.by_fitted(1);
    const Expression kappa1 = scale_.by_fitted(2);
    const Expression kappa_q =
        is_sigma ? Expression::constant(0.0) : scale_.by_quantity(quantity, 1);
    const Expression kappa1_q =
        is_sigma ? Expression::constant(0.0) : scale_.by_quantity(quantity, 2);
    const Expression pull = scaled + kappa * squared;
    result.first = kappa_q * free + 2.0 * (l * pull);
    result.second =
        kappa1_q * free - 2.0 * (l * (density_.second - kappa1)) + 4.0 * (kappa_q * pull);
    result.omega =
        curvature_ == Curvature::kFull ? result.second : -2.0 * (l * tau) + 4.0 * (kappa * kappa_q);
    return result;
  }

  /// M in the space of the model's parameters: its elements are sums over the coefficients of each.
  void collapse_weights() {
    for (std::size_t i = 0; i < random_.size(); ++i) {
      for (std::size_t j = 0; j < random_.size(); ++j) {
        const auto row = static_cast<Index>(std::max(i, j));
        const auto column = static_cast<Index>(std::min(i, j));
        const Expression term = multiplier(random_[i]) * multiplier(random_[j]) *
                                Expression::variable(term_names::weight(row, column));
        const std::pair key{parameter(random_[i]), parameter(random_[j])};
        const auto known = weights_.find(key);
        weights_.insert_or_assign(key, known == weights_.end() ? term : known->second + term);
      }
    }
  }

  /// f_phi' M f_phi and the same of any derivative d2f or d3f by two parameters and others.
  template <typename Of>
  Expression weighted(Of of) const {
    Expression sum = Expression::constant(0.0);
    for (const auto& [pair, weight] : weights_) {
      // The matrix is symmetric: each pair off the diagonal counts twice.
      if (pair.first < pair.second) continue;
      const double times = pair.first == pair.second ? 1.0 : 2.0;
      sum = sum + times * (weight * of(pair.first, pair.second));
    }
    return sum;
  }

  /// dc / d phi_k at b.
  const Expression& penalty_slope(Index k) {
    const auto known = penalty_slopes_.find(k);
    if (known != penalty_slopes_.end()) return known->second;
    return penalty_slopes_.emplace(k, make_penalty_slope(k)).first->second;
  }

  Expression make_penalty_slope(Index k) {
    const Expression q = weighted([&](Index i, Index j) { return mean_.by(i) * mean_.by(j); });
    Expression cross = Expression::constant(0.0);
    for (const auto& [pair, weight] : weights_) {
      cross = cross + mean_.by(k, pair.first) * (weight * mean_.by(pair.second));
    }
    Expression sum = density_.omega_first * mean_.by(k) * q + 2.0 * (density_.omega * cross);
    if (curvature_ == Curvature::kFull) {
      const Expression bend = weighted([&](Index i, Index j) { return mean_.by(i, j); });
      const Expression third = weighted([&](Index i, Index j) { return mean_.by(i, j, k); });
      sum = sum + density_.second * mean_.by(k) * bend + density_.first * third;
    }
    return 0.5 * sum;
  }

  void add_random_terms(ModeTerms& result) {
    for (std::size_t j = 0; j < random_.size(); ++j) {
      const Index b = random_[j];
      result.by_random.push_back(multiplier(b) * (density_.first * mean_.by(parameter(b))));
      for (std::size_t i = j; i < random_.size(); ++i) {
        const Index a = random_[i];
        const Expression both = multiplier(a) * multiplier(b);
        const Expression slopes = mean_.by(parameter(a)) * mean_.by(parameter(b));
        const Expression bend = density_.first * mean_.by(parameter(a), parameter(b));
        result.curvature.push_back(both * (density_.second * slopes + bend));
        if (curvature_ != Curvature::kFull) {
          result.approximation.push_back(both * (density_.omega * slopes));
        }
      }
    }
  }

  /// The derivatives by random effects and by coefficients that these do not have.
  void add_mixed_terms(ModeTerms& result) {
    for (Index j = 0; j < model_.column_count(); ++j) {
      if (!is_first_order() && std::ranges::find(random_, j) != random_.end()) continue;
      result.others.push_back(j);
      const Index k = parameter(j);
      for (const Index c : random_) {
        const Index l = parameter(c);
        Expression cross =
            density_.second * (mean_.by(k) * mean_.by(l)) + density_.first * mean_.by(k, l);
        if (is_first_order()) {
          cross = cross + 2.0 * (scale_by_population() * population_.by(k) * residual_.scaled) *
                              mean_.by(l);
        }
        result.other_random.push_back(multiplier(j) * multiplier(c) * cross);
      }
    }
  }

  void add_fixed_terms(ObservationTerms& result) {
    const auto count = model_.column_count();
    for (Index j = 0; j < count; ++j) {
      const Index k = parameter(j);
      Expression slope = density_.first * mean_.by(k);
      Expression penalty = penalty_slope(k);
      if (is_first_order()) {
        // The residual variance depends on the mean of the population.
        const Expression turn = scale_by_population() * population_.by(k);
        slope = slope + turn * (Expression::constant(1.0) - residual_.squared);
        penalty = penalty - turn * residual_.tau * slopes_weighted();
      }
      result.density_by_fixed.push_back(multiplier(j) * slope);
      if (std::ranges::find(result.others, j) == result.others.end()) continue;
      result.by_other.push_back(multiplier(j) * (slope + penalty));
    }
  }

  Expression scale_by_population() const { return scale_.by_fitted(1); }
  Expression slopes_weighted() {
    return weighted([&](Index i, Index j) { return mean_.by(i) * mean_.by(j); });
  }

  void add_variance_terms(ObservationTerms& result) {
    const Expression q = slopes_weighted();
    const Expression bend = curvature_ == Curvature::kFull
                                ? weighted([&](Index i, Index j) { return mean_.by(i, j); })
                                : Expression::constant(0.0);
    for (std::size_t e = 0; e <= scale_.quantity_count(); ++e) {
      const VarianceDerivatives by = by_variance(e);
      const Expression total = by.value + 0.5 * (by.omega * q + by.first * bend);
      for (const Expression& share : shares(e)) {
        result.density_by_variance.push_back(share * by.value);
        result.by_variance.push_back(share * total);
        for (const Index c : random_) {
          result.variance_random.push_back(share * multiplier(c) * by.first *
                                           mean_.by(parameter(c)));
        }
      }
    }
  }

  /// What the internal parameters of a quantity are multiplied by: 1, or indicators of strata.
  std::vector<Expression> shares(std::size_t quantity) const {
    if (quantity == scale_.quantity_count()) return {Expression::constant(1.0)};
    const VarianceModel::Quantity& of = variance_.quantities()[quantity];
    if (of.strata < 0) return {Expression::constant(1.0)};
    std::vector<Expression> result;
    for (Index s = 0; s < of.count; ++s) {
      result.push_back(Expression::variable(term_names::indicator(quantity, s)));
    }
    return result;
  }

  Index parameter(Index coefficient) const { return model_.design().parameter_of(coefficient); }
  Expression multiplier(Index coefficient) const {
    if (model_.design().multiplier(coefficient) == nullptr) return Expression::constant(1.0);
    return Expression::variable(term_names::multiplier(coefficient));
  }

  const NonlinearModel& model_;
  const VarianceModel& variance_;
  Curvature curvature_;
  const std::vector<Index>& random_;
  MeanDerivatives mean_;
  MeanDerivatives population_;
  ScaleDerivatives scale_;
  Residual residual_;
  DensityDerivatives density_;
  std::map<std::pair<Index, Index>, Expression> weights_;
  std::map<Index, Expression> penalty_slopes_;
};

}  // namespace

ModeTerms mode_terms(const NonlinearModel& model,
                     const VarianceModel& variance,
                     Curvature curvature,
                     const std::vector<Index>& random) {
  return Assembly(model, variance, curvature, random).mode_terms();
}

ObservationTerms observation_terms(const NonlinearModel& model,
                                   const VarianceModel& variance,
                                   Curvature curvature,
                                   const std::vector<Index>& random) {
  return Assembly(model, variance, curvature, random).terms();
}

}  // namespace silvafit::fit
