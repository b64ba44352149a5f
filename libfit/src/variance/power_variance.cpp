// SPDX-License-Identifier: MIT
// |v|^delta. Without strata the internal g is |v/v0|^delta.
#include <cmath>

#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;

class PowerVariance : public VarianceKind {
 public:
  std::string_view name() const override { return "power"; }
  bool reads_logarithm() const override { return true; }
  bool allows_zero(const VarianceFactor& factor) const override { return factor.delta == 0.0; }

  double value(const VarianceFactorEstimate& estimate, Index stratum, double v) const override {
    return std::pow(std::abs(v), estimate.delta[stratum]);
  }

  Expression log_scale(LogScaleTerms& terms) const override {
    const Expression logarithm = terms.logarithm();
    return filled("d*l", {{"d", terms.delta()}, {"l", logarithm}});
  }

  void estimate(const InternalFactor& internal, VarianceFactorEstimate& result) const override {
    result.delta = internal_or_held_delta(internal, std::ssize(result.strata));
  }

  VectorXd internal(VarianceQuantity /*kind*/,
                    const VarianceFactorEstimate& estimate,
                    const TypicalValue& /*typical*/) const override {
    return estimate.delta;
  }

  double log_offset(const VarianceFactorEstimate& estimate,
                    const TypicalValue& typical) const override {
    return estimate.delta[0] * std::log(typical.middle);
  }
};

}  // namespace

const VarianceKind& power_variance() {
  static const PowerVariance kind;
  return kind;
}

}  // namespace silvafit::fit
