// SPDX-License-Identifier: MIT
#include "conditional_modes/observation_terms.hpp"

#include <fmt/format.h>

#include <algorithm>
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

/// Differentiates the terms symbolically; programs compute what they share once.
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
        is_correlated_(variance.correlated() != nullptr),
        mean_(model.specification().formula.right),
        population_(at_population(mean_)) {
    scale_ = Expression::variable(term_names::log_sigma()) +
             variance.log_scale().substitute(
                 VarianceModel::fitted_name(),
                 Expression::variable(is_first_order() ? kPopulationMean : kMean));
    raw_ = Expression::variable(model.specification().formula.left) - Expression::variable(kMean);
    weight_ = exp(-2.0 * scale_);
    residual_ = raw_ * exp(-scale_);
    scaled_ = is_correlated_ ? adjoint(0) * exp(-scale_) : raw_ * weight_;
    squared_ = raw_ * scaled_;
    free_ = Expression::constant(1.0) - squared_;
    density_ = scale_ + (is_correlated_ ? squared_ : 0.5 * squared_);
    slope_ = scale_.derivative(kMean) * free_ - scaled_;
  }

  ObservationTerms mode_terms() {
    if (curvature_ == Curvature::kHeldWeights) {
      is_correlated_ ? hold_correlated() : hold_independent();
    } else {
      add_modes();
    }
    return with_means();
  }

  ObservationTerms terms() {
    add_modes();
    add_penalty();
    add_slopes();
    add_variance();
    return with_means();
  }

 private:
  bool is_first_order() const { return curvature_ == Curvature::kFirstOrder; }
  bool is_full() const { return curvature_ == Curvature::kFull; }
  bool is_random(Index coefficient) const {
    return std::ranges::find(random_, coefficient) != random_.end();
  }

  Expression at_population(Expression mean) const {
    for (const ParameterModel& parameter : model_.specification().parameters) {
      mean = mean.substitute(parameter.name,
                             Expression::variable(term_names::population(parameter.name)));
    }
    return mean;
  }

  static Expression adjoint(std::size_t k) { return Expression::variable(term_names::adjoint(k)); }
  static Expression zero() { return Expression::constant(0.0); }

  Expression multiplier(Index coefficient) const {
    if (model_.design().multiplier(coefficient) == nullptr) return Expression::constant(1.0);
    return Expression::variable(term_names::multiplier(coefficient));
  }

  const std::string& parameter(Index coefficient) const {
    const auto k = static_cast<std::size_t>(model_.design().parameter_of(coefficient));
    return model_.specification().parameters[k].name;
  }

  /// The derivative along a parameter, of which the mean is a function.
  Expression along(const Expression& of, const std::string& name) const {
    return of.derivative(name) + of.derivative(kMean) * mean_.derivative(name);
  }
  /// The derivative by the random effect of a coefficient.
  Expression by_effect(const Expression& of, Index coefficient) const {
    return multiplier(coefficient) * along(of, parameter(coefficient));
  }

  /// The derivative by a coefficient, which moves the population's mean, too.
  Expression by_coefficient(const Expression& of, Index coefficient) const {
    Expression slope = along(of, parameter(coefficient));
    if (is_first_order()) {
      const std::string name = term_names::population(parameter(coefficient));
      slope = slope + of.derivative(kPopulationMean) * population_.derivative(name);
    }
    return multiplier(coefficient) * slope;
  }

  /// The same of the density; its first derivatives are written down, which keeps those of higher
  /// order short.
  Expression density_by_effect(Index coefficient) const {
    return multiplier(coefficient) * (slope_ * mean_.derivative(parameter(coefficient)));
  }
  Expression density_by_coefficient(Index coefficient) const {
    Expression slope = slope_ * mean_.derivative(parameter(coefficient));
    if (is_first_order()) {
      const std::string name = term_names::population(parameter(coefficient));
      slope = slope + scale_.derivative(kPopulationMean) * free_ * population_.derivative(name);
    }
    return multiplier(coefficient) * slope;
  }
  std::vector<Expression> density_by_scale() const {
    std::vector<Expression> result = by_scale(scale_);
    for (Expression& slope : result) slope = slope * free_;
    return result;
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

  /// The sum of a matrix times M, by its lower triangle by columns.
  static Expression weighted(const std::vector<Expression>& triangle, std::size_t size) {
    Expression sum = zero();
    auto element = triangle.begin();
    for (std::size_t j = 0; j < size; ++j) {
      for (std::size_t i = j; i < size; ++i, ++element) {
        // The matrix is symmetric: each pair off the diagonal counts twice.
        const Expression weight =
            Expression::variable(term_names::weight(static_cast<Index>(i), static_cast<Index>(j)));
        sum = sum + (i == j ? 1.0 : 2.0) * (weight * *element);
      }
    }
    return sum;
  }

  /// The lower triangle by columns of the elements of pairs of random coefficients.
  template <typename Of>
  std::vector<Expression> triangle(const Of& of) const {
    std::vector<Expression> result;
    for (std::size_t j = 0; j < random_.size(); ++j) {
      for (std::size_t i = j; i < random_.size(); ++i) result.push_back(of(i, j));
    }
    return result;
  }

  /// The lower triangle of the derivatives of slopes by the effects.
  std::vector<Expression> by_effects(const std::vector<Expression>& slopes) const {
    return triangle([&](std::size_t i, std::size_t j) { return by_effect(slopes[j], random_[i]); });
  }

  void add_modes() {
    result_.density = is_correlated_ ? scale_ : density_;
    add_random();
    add_others();
  }

  void add_random() {
    for (const Index b : random_) result_.by_random.push_back(density_by_effect(b));
    result_.curvature = by_effects(result_.by_random);
    std::vector<Expression> means;
    std::vector<Expression> scales;
    for (const Index b : random_) {
      means.push_back(-(by_effect(raw_, b) * exp(-scale_)));
      scales.push_back(by_effect(scale_, b));
    }
    if (!is_full()) {
      result_.approximation = triangle([&](std::size_t i, std::size_t j) {
        if (is_correlated_) return zero();
        return weight_ * (by_effect(raw_, random_[i]) * by_effect(raw_, random_[j])) +
               2.0 * (scales[i] * scales[j]);
      });
    }
    if (!is_correlated_) return;
    result_.states = effects_of_residual();
    result_.states.insert(result_.states.begin(), residual_);
    if (is_full()) return;
    result_.states.insert(result_.states.end(), means.begin(), means.end());
    result_.states.insert(result_.states.end(), scales.begin(), scales.end());
  }

  std::vector<Expression> effects_of_residual() const {
    std::vector<Expression> result;
    for (const Index b : random_) result.push_back(by_effect(residual_, b));
    return result;
  }

  /// The derivatives by random effects and by coefficients that these do not have.
  void add_others() {
    for (Index j = 0; j < model_.column_count(); ++j) {
      if (!is_first_order() && is_random(j)) continue;
      result_.others.push_back(j);
      const Expression slope = density_by_coefficient(j);
      for (const Index c : random_) result_.other_random.push_back(by_effect(slope, c));
      if (is_correlated_) result_.wide_states.push_back(by_coefficient(residual_, j));
    }
  }

  /// What has the derivatives of c.
  void add_penalty() {
    const std::size_t r = random_.size();
    penalty_ = 0.5 * weighted(is_full() ? result_.curvature : result_.approximation, r);
    if (!is_correlated_) return;
    if (is_full()) penalty_ = penalty_ + 0.5 * (adjoint(1) * residual_);
    // E, or F and S.
    const std::size_t first = is_full() ? 1 : 1 + r;
    for (std::size_t k = first; k < result_.states.size(); ++k) {
      penalty_ = penalty_ + adjoint(2 + k - first) * result_.states[k];
    }
  }

  void add_slopes() {
    for (const Index b : random_) result_.penalty_by_random.push_back(by_effect(penalty_, b));
    for (Index j = 0; j < model_.column_count(); ++j) {
      result_.density_by_fixed.push_back(density_by_coefficient(j));
    }
    for (const Index j : result_.others) {
      const Expression slope = result_.density_by_fixed[static_cast<std::size_t>(j)];
      result_.by_other.push_back(slope + by_coefficient(penalty_, j));
    }
  }

  void add_variance() {
    result_.density_by_variance = density_by_scale();
    result_.by_variance = by_scale(penalty_);
    for (std::size_t e = 0; e < result_.by_variance.size(); ++e) {
      result_.by_variance[e] = result_.density_by_variance[e] + result_.by_variance[e];
    }
    for (const Expression& slope : result_.density_by_variance) {
      for (const Index c : random_) result_.variance_random.push_back(by_effect(slope, c));
    }
    if (!is_correlated_) return;
    for (const Expression& slope : by_scale(residual_)) result_.wide_states.push_back(slope);
    if (!is_full()) return;
    result_.wide_states.push_back(weighted(by_effects(effects_of_residual()), random_.size()));
  }

  void hold_independent() {
    const bool moves = variance_.uses_fitted();
    const Expression held = Expression::variable(term_names::held_weight());
    result_.density = 0.5 * (moves ? raw_ * raw_ * held : squared_);
    if (moves) result_.own_weight = {0.5 * squared_, weight_};
    for (const Index b : random_) {
      result_.by_random.push_back(by_effect(raw_, b) * scaled_);
    }
    result_.curvature = triangle(
        [&](std::size_t i, std::size_t j) { return by_effect(result_.by_random[j], random_[i]); });
    result_.approximation = triangle([&](std::size_t i, std::size_t j) {
      return weight_ * (by_effect(raw_, random_[i]) * by_effect(raw_, random_[j]));
    });
    for (Index j = 0; j < model_.column_count(); ++j) {
      if (is_random(j)) continue;
      result_.others.push_back(j);
      for (const Expression& slope : result_.by_random) {
        result_.other_random.push_back(by_coefficient(slope, j));
      }
    }
  }

  void hold_correlated() {
    const Expression precision = exp(-scale_);
    const auto slope = [&](Index coefficient) { return by_effect(raw_, coefficient) * precision; };
    result_.states = {residual_};
    for (const Index b : random_) {
      result_.states.push_back(slope(b));
      result_.by_random.push_back(adjoint(0) * slope(b));
    }
    result_.curvature = triangle([](std::size_t, std::size_t) { return zero(); });
    const Expression held = Expression::variable(term_names::held_weight());
    result_.held = {raw_ * exp(0.5 * log(held))};
    result_.own_weight = {zero(), weight_};
    for (Index j = 0; j < model_.column_count(); ++j) {
      if (is_random(j)) continue;
      result_.others.push_back(j);
      result_.wide_states.push_back(slope(j));
      result_.other_random.insert(result_.other_random.end(), random_.size(), zero());
    }
  }

  /// The terms with the means as functions of the parameters.
  ObservationTerms with_means() {
    const auto put = [this](Expression& of) {
      of = of.substitute(kMean, mean_);
      if (is_first_order()) of = of.substitute(kPopulationMean, population_);
    };
    put(result_.density);
    for (auto* const terms : {&result_.by_random,
                              &result_.curvature,
                              &result_.approximation,
                              &result_.other_random,
                              &result_.own_weight,
                              &result_.by_other,
                              &result_.density_by_fixed,
                              &result_.penalty_by_random,
                              &result_.by_variance,
                              &result_.density_by_variance,
                              &result_.variance_random,
                              &result_.states,
                              &result_.held,
                              &result_.wide_states}) {
      std::ranges::for_each(*terms, put);
    }
    return std::move(result_);
  }

  static constexpr const char* kMean = "the mean";
  static constexpr const char* kPopulationMean = "the population's mean";

  const NonlinearModel& model_;
  const VarianceModel& variance_;
  Curvature curvature_;
  const std::vector<Index>& random_;
  bool is_correlated_;
  Expression mean_;               ///< f
  Expression population_;         ///< f without random effects
  Expression scale_ = zero();     ///< l
  Expression raw_ = zero();       ///< y - f
  Expression weight_ = zero();    ///< 1 / (sigma g)^2
  Expression residual_ = zero();  ///< e
  Expression scaled_ = zero();    ///< r/s^2; of correlated rows a/s
  Expression squared_ = zero();   ///< e^2; of correlated rows a e
  Expression free_ = zero();      ///< 1 - squared
  Expression slope_ = zero();     ///< of the density by the mean
  Expression density_ = zero();   ///< rho; of correlated rows l + a e
  Expression penalty_ = zero();   ///< has the derivatives of c
  ObservationTerms result_;
};

}  // namespace

ObservationTerms mode_terms(const NonlinearModel& model,
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
