// SPDX-License-Identifier: MIT
// constant + |v|^delta. The internal g of one number is sin^2 phi + cos^2 phi |v|^delta / P(delta)
// with P = exp(TypicalValue::log_power), which holds a constant variance, a pure power and a step
// at the largest or smallest values as ordinary points; with strata, or if a parameter is held, it
// is kappa^2 + |v|^delta.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "silvafit/base/constants.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;

/// Whether the internal constant is an angle, not a root.
bool is_angle(const VarianceFactor& factor) { return factor.stratum.empty() && !factor.delta; }

/// If the power is below this share at all observations, constant-plus-power is not
/// distinguishable from a constant variance.
constexpr double kNoPower = 1e-10;

class ConstantPlusPowerVariance : public VarianceKind {
 public:
  std::string_view name() const override { return "constant-plus-power"; }
  bool has_constant() const override { return true; }
  std::optional<VarianceFactor::Kind> without_constant() const override {
    return VarianceFactor::Kind::kPower;
  }
  bool reads_logarithm() const override { return true; }
  bool allows_zero(const VarianceFactor& factor) const override {
    const double delta = factor.delta.value_or(1.0);
    return delta == 0.0 || (delta > 0.0 && factor.constant != 0.0);
  }

  double value(const VarianceFactorEstimate& estimate, Index stratum, double v) const override {
    if (std::isinf(estimate.constant[stratum])) return std::isnan(v) ? kNaN : 1.0;
    return estimate.constant[stratum] + std::pow(std::abs(v), estimate.delta[stratum]);
  }

  Expression log_scale(LogScaleTerms& terms) const override {
    const VarianceFactor& factor = terms.factor();
    const Expression l = terms.logarithm();
    const Expression d = terms.delta();
    if (factor.constant) {
      const Expression c = Expression::constant(*factor.constant);
      return filled("log(c + exp(d*l))", {{"c", c}, {"d", d}, {"l", l}});
    }
    if (!is_angle(factor)) {
      const double exponent = factor.delta.value_or(kStartExponent);
      const double start = std::pow(terms.typical().middle, 0.5 * exponent);
      const Expression k = terms.estimated(VarianceQuantity::kConstant, start, 1.0);
      return filled("log(k*k + exp(d*l))", {{"k", k}, {"d", d}, {"l", l}});
    }
    const Expression k = terms.estimated(
        VarianceQuantity::kConstant, std::numbers::pi / 4.0, std::numbers::pi / 2.0);
    const TypicalValue& typical = terms.typical();
    const auto relative = [&](double of) {
      return Expression::constant(std::log(of / typical.middle));
    };
    const Expression steepest = Expression::constant(typical.steepest());
    return filled("log(sin(k)^2 + cos(k)^2*exp(d*l - log(0.5*exp(d*a) + 0.5*exp(d*b))))",
                  {{"k", k},
                   {"d", filled("max(-s, min(s, d))", {{"d", d}, {"s", steepest}})},
                   {"l", l},
                   {"a", relative(typical.low)},
                   {"b", relative(typical.high)}});
  }

  void estimate(const InternalFactor& internal, VarianceFactorEstimate& result) const override {
    const Index strata = std::ssize(result.strata);
    result.delta = internal_or_held_delta(internal, strata);
    const double steepest = internal.typical.steepest();
    if (is_angle(internal.factor))
      result.delta = result.delta.cwiseMin(steepest).cwiseMax(-steepest);
    if (!internal.constant) {
      result.constant = VectorXd::Constant(strata, *internal.factor.constant);
    } else if (!is_angle(internal.factor)) {
      result.constant = internal.constant->array().square();
    } else if (const double phi = (*internal.constant)[0]; std::pow(std::cos(phi), 2) < kNoPower) {
      result.constant.setConstant(1, kInfinity);
    } else {
      // An infinite constant would be a constant variance.
      const double constant =
          std::pow(std::tan(phi), 2) * std::exp(internal.typical.log_power(result.delta[0]));
      result.constant.setConstant(1, std::min(constant, std::numeric_limits<double>::max()));
    }
  }

  VectorXd internal(VarianceQuantity kind,
                    const VarianceFactorEstimate& estimate,
                    const TypicalValue& typical) const override {
    if (kind == VarianceQuantity::kDelta) return estimate.delta;
    if (!is_angle(estimate.factor)) return estimate.constant.cwiseSqrt();
    const double log_odds = std::log(estimate.constant[0]) - typical.log_power(estimate.delta[0]);
    return VectorXd::Constant(1, std::atan(std::exp(0.5 * log_odds)));
  }

  double log_offset(const VarianceFactorEstimate& estimate,
                    const TypicalValue& typical) const override {
    // An infinite constant represents the factor 1.
    if (std::isinf(estimate.constant[0])) return 0.0;
    // With tan^2 phi = c / P, c + |v|^delta is (c + P) times the internal function.
    return std::log(estimate.constant[0] + std::exp(typical.log_power(estimate.delta[0])));
  }
};

}  // namespace

const VarianceKind& constant_plus_power_variance() {
  static const ConstantPlusPowerVariance kind;
  return kind;
}

}  // namespace silvafit::fit
