// SPDX-License-Identifier: MIT
// A ratio for each stratum to the first one. The internal numbers are logarithms of ratios.
#include <cmath>

#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;

class StratumVariance : public VarianceKind {
 public:
  std::string_view name() const override { return "stratum"; }
  bool reads_value() const override { return false; }
  bool has_delta() const override { return false; }

  double value(const VarianceFactorEstimate& estimate, Index stratum, double /*v*/) const override {
    return estimate.ratio[stratum];
  }

  Expression log_scale(LogScaleTerms& terms) const override {
    return terms.estimated(VarianceQuantity::kLogRatio, 0.0, 0.0);
  }

  void estimate(const InternalFactor& internal, VarianceFactorEstimate& result) const override {
    result.ratio = internal.log_ratio->array().exp();
  }

  VectorXd internal(VarianceQuantity /*kind*/,
                    const VarianceFactorEstimate& estimate,
                    const TypicalValue& /*typical*/) const override {
    return estimate.ratio.array().log();
  }

  double log_offset(const VarianceFactorEstimate& /*estimate*/,
                    const TypicalValue& /*typical*/) const override {
    return 0.0;
  }
};

}  // namespace

const VarianceKind& stratum_variance() {
  static const StratumVariance kind;
  return kind;
}

}  // namespace silvafit::fit
