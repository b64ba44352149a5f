// SPDX-License-Identifier: MIT
// exp(delta v). The internal rate is delta v0; without strata g is 1 at v0.
#include <cmath>

#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;

class ExponentialVariance : public VarianceKind {
 public:
  std::string_view name() const override { return "exponential"; }

  double value(const VarianceFactorEstimate& estimate, Index stratum, double v) const override {
    return std::exp(estimate.delta[stratum] * v);
  }

  double middle(const VectorXd& values) const override {
    const double mean = values.cwiseAbs().mean();
    return mean > 0.0 ? mean : 1.0;
  }

  Expression log_scale(LogScaleTerms& terms) const override {
    return filled("d*(v/t - o)",
                  {{"v", terms.value()},
                   {"t", Expression::constant(terms.typical().middle)},
                   {"o", Expression::constant(terms.is_plain() ? 0.0 : 1.0)},
                   {"d", terms.delta(terms.typical().middle)}});
  }

  void estimate(const InternalFactor& internal, VarianceFactorEstimate& result) const override {
    result.delta = internal_or_held_delta(internal, std::ssize(result.strata));
    if (internal.delta) result.delta *= delta_scale(internal.typical);
  }

  VectorXd internal(VarianceQuantity /*kind*/,
                    const VarianceFactorEstimate& estimate,
                    const TypicalValue& typical) const override {
    return estimate.delta * typical.middle;
  }

  double log_offset(const VarianceFactorEstimate& estimate,
                    const TypicalValue& typical) const override {
    return estimate.delta[0] * typical.middle;
  }

  double delta_scale(const TypicalValue& typical) const override { return 1.0 / typical.middle; }
};

}  // namespace

const VarianceKind& exponential_variance() {
  static const ExponentialVariance kind;
  return kind;
}

}  // namespace silvafit::fit
