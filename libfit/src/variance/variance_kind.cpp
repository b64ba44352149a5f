// SPDX-License-Identifier: MIT
#include "variance/variance_kind.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace silvafit::fit {

using data::Expression;

const std::vector<const VarianceKind*>& variance_kinds() {
  static const std::vector<const VarianceKind*> kinds{&exponential_variance(),
                                                      &power_variance(),
                                                      &constant_plus_power_variance(),
                                                      &stratum_variance()};
  return kinds;
}

const VarianceKind& kind_of(VarianceFactor::Kind kind) {
  return *variance_kinds()[static_cast<std::size_t>(kind)];
}

bool LogScaleTerms::is_plain() const {
  return !factor_.stratum.empty() || factor_.delta || factor_.constant;
}

Expression LogScaleTerms::delta(double scale) {
  if (factor_.delta) return Expression::constant(*factor_.delta * scale);
  return estimated(VarianceQuantity::kDelta, kStartExponent, 0.0);
}

double TypicalValue::log_power(double delta) const {
  const double of_low = delta * std::log(low);
  const double of_high = delta * std::log(high);
  const double larger = std::max(of_low, of_high);
  return larger + std::log(0.5 * (1.0 + std::exp(-std::abs(of_high - of_low))));
}

double TypicalValue::steepest() const {
  return high > low ? 600.0 / std::log(high / low) : std::numeric_limits<double>::max();
}

double TypicalValue::log_power_slope(double delta) const {
  const double share_of_high = 1.0 / (1.0 + std::exp(delta * std::log(low / high)));
  return std::log(low) + share_of_high * std::log(high / low);
}

TypicalValue VarianceKind::typical(const VectorXd& values) const {
  if (values.size() == 0) return {};
  TypicalValue result{.middle = middle(values)};
  const double least = kSmallestShare * result.middle;
  result.low = std::max(least, values.cwiseAbs().minCoeff());
  result.high = std::max(result.low, values.cwiseAbs().maxCoeff());
  return result;
}

double VarianceKind::middle(const VectorXd& values) const {
  double sum = 0.0;
  Index count = 0;
  for (const double value : values) {
    if (value == 0.0) continue;
    sum += std::log(std::abs(value));
    ++count;
  }
  return count == 0 ? 1.0 : std::exp(sum / static_cast<double>(count));
}

VectorXd internal_or_held_delta(const InternalFactor& internal, Index strata) {
  return internal.delta ? *internal.delta : VectorXd::Constant(strata, *internal.factor.delta);
}

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

}  // namespace silvafit::fit
