// SPDX-License-Identifier: MIT
// constant + |v|^delta. The internal g of one number is sin^2 phi + cos^2 phi |v/v0|^delta, which
// holds both a constant variance and a pure power as ordinary points; with strata, or if a
// parameter is held, it is kappa^2 + |v|^delta.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "silvafit/base/constants.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;
using Eigen::ArrayXd;

/// Whether the internal constant is an angle, not a root.
bool is_angle(const VarianceFactor& factor) { return factor.stratum.empty() && !factor.delta; }

/// Whether the constant is dominant at all observations.
bool is_without_power(const InternalFactor& internal, double delta) {
  // If the power is below this share at all observations, constant-plus-power is not
  // distinguishable from a constant variance.
  constexpr double kNoPower = 1e-10;
  const ArrayXd shares = (internal.values.array().abs() / internal.typical).max(kSmallestShare);
  const double growth =
      std::max(std::pow(shares.maxCoeff(), delta), std::pow(shares.minCoeff(), delta));
  return std::pow(std::cos((*internal.constant)[0]), 2) * growth < kNoPower;
}

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
      const double start = std::pow(terms.typical(), 0.5 * exponent);
      const Expression k = terms.estimated(VarianceQuantity::kConstant, start, 1.0);
      return filled("log(k*k + exp(d*l))", {{"k", k}, {"d", d}, {"l", l}});
    }
    const Expression k = terms.estimated(
        VarianceQuantity::kConstant, std::numbers::pi / 4.0, std::numbers::pi / 2.0);
    return filled("log(sin(k)^2 + cos(k)^2*exp(d*l))", {{"k", k}, {"d", d}, {"l", l}});
  }

  void estimate(const InternalFactor& internal, VarianceFactorEstimate& result) const override {
    const Index strata = std::ssize(result.strata);
    result.delta = internal_or_held_delta(internal, strata);
    if (!internal.constant) {
      result.constant = VectorXd::Constant(strata, *internal.factor.constant);
    } else if (!is_angle(internal.factor)) {
      result.constant = internal.constant->array().square();
    } else if (is_without_power(internal, result.delta[0])) {
      result.constant.setConstant(1, kInfinity);
    } else {
      const double odds = std::pow(std::tan((*internal.constant)[0]), 2);
      result.constant.setConstant(1, odds * std::pow(internal.typical, result.delta[0]));
    }
  }

  VectorXd internal(VarianceQuantity kind,
                    const VarianceFactorEstimate& estimate,
                    double typical) const override {
    if (kind == VarianceQuantity::kDelta) return estimate.delta;
    if (!is_angle(estimate.factor)) return estimate.constant.cwiseSqrt();
    const double odds = estimate.constant[0] / std::pow(typical, estimate.delta[0]);
    return VectorXd::Constant(1, std::atan(std::sqrt(odds)));
  }

  double log_offset(const VarianceFactorEstimate& estimate, double typical) const override {
    // An infinite constant represents the factor 1.
    if (std::isinf(estimate.constant[0])) return 0.0;
    // With tan^2 phi = c / v0^delta, c + |v|^delta is (c + v0^delta) times the internal function.
    return std::log(estimate.constant[0] + std::pow(typical, estimate.delta[0]));
  }
};

}  // namespace

const VarianceKind& constant_plus_power_variance() {
  static const ConstantPlusPowerVariance kind;
  return kind;
}

}  // namespace silvafit::fit
