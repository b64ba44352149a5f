// SPDX-License-Identifier: MIT
// The interface of a kind of variance function: each has its own file, and variance_kind.cpp lists
// them.
#pragma once

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/data/expression.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/variance_function.hpp"

namespace silvafit::fit {

/// The kinds of numbers in log g that are estimated.
enum class VarianceQuantity { kDelta, kConstant, kLogRatio };

/// |v| below this share of its typical value would let one observation decide the power.
inline constexpr double kSmallestShare = 1e-4;

/// Magnitudes |v| of the observations, the units of internal numbers.
struct TypicalValue {
  double middle = 1.0;  ///< v0
  double low = 1.0;     ///< the smallest, above kSmallestShare of v0
  double high = 1.0;    ///< the largest
  /// The logarithm of the mean of the powers of the smallest and largest, and its slope. It is near
  /// the powers of the observations for any delta; that of v0 is far below those of the few
  /// observations that matter for a steep power.
  double log_power(double delta) const;
  double log_power_slope(double delta) const;
  /// The steepest power, at which those of the smallest and largest differ by e^600: others are
  /// steps at one value, too, and not in the range of numbers.
  double steepest() const;
};

/// The parts of the expression of log g of a factor.
class LogScaleTerms {
 public:
  LogScaleTerms(const VarianceFactor& factor, const TypicalValue& typical)
      : factor_(factor), typical_(typical) {}
  virtual ~LogScaleTerms() = default;
  LogScaleTerms(const LogScaleTerms&) = delete;
  LogScaleTerms& operator=(const LogScaleTerms&) = delete;

  const VarianceFactor& factor() const { return factor_; }
  const TypicalValue& typical() const { return typical_; }
  /// Whether sigma must not depend on the parameters of the factor: then v is used unscaled, else
  /// relative to its typical value.
  bool is_plain() const;

  /// The variable of the factor, v.
  virtual data::Expression value() const = 0;
  /// log |v|, or log |v/v0| unless is_plain().
  virtual data::Expression logarithm() = 0;
  /// A variable for an estimated number.
  /// \param at_constant  its value for a constant variance
  virtual data::Expression estimated(VarianceQuantity kind, double start, double at_constant) = 0;
  /// delta, or its held value in units of `scale`.
  data::Expression delta(double scale = 1.0);

 private:
  const VarianceFactor& factor_;
  const TypicalValue& typical_;
};

/// Estimated numbers of a factor as in VarianceModel, one per stratum, and the data for their
/// units.
struct InternalFactor {
  const VarianceFactor& factor;
  const TypicalValue& typical;
  std::optional<VectorXd> delta{};
  std::optional<VectorXd> constant{};
  std::optional<VectorXd> log_ratio{};
};

class VarianceKind {
 public:
  virtual ~VarianceKind() = default;

  /// Its name in texts.
  virtual std::string_view name() const = 0;
  /// Whether g is a function of the fitted value or a column.
  virtual bool reads_value() const { return true; }
  virtual bool has_delta() const { return true; }
  virtual bool has_constant() const { return false; }
  /// The kind that this one is with the constant 0, if any.
  virtual std::optional<VarianceFactor::Kind> without_constant() const { return std::nullopt; }
  /// Whether log g reads log |v|, so that v near 0 is floored.
  virtual bool reads_logarithm() const { return false; }

  /// g of one stratum.
  virtual double value(const VarianceFactorEstimate& estimate, Index stratum, double v) const = 0;
  /// The typical |v| of the observations, v0.
  virtual double middle(const VectorXd& values) const;
  TypicalValue typical(const VectorXd& values) const;
  /// log g as an expression.
  virtual data::Expression log_scale(LogScaleTerms& terms) const = 0;
  /// Sets the parameters of an estimate whose strata are known.
  virtual void estimate(const InternalFactor& internal, VarianceFactorEstimate& result) const = 0;
  /// The internal numbers of an estimate, one per stratum.
  virtual VectorXd internal(VarianceQuantity kind,
                            const VarianceFactorEstimate& estimate,
                            const TypicalValue& typical) const = 0;
  /// The logarithm of g over the internal g, which is about 1 at v0; 0 where is_plain().
  virtual double log_offset(const VarianceFactorEstimate& estimate,
                            const TypicalValue& typical) const = 0;
  /// delta over the internal delta.
  virtual double delta_scale(const TypicalValue& /*typical*/) const { return 1.0; }
  /// Whether g is positive and finite where the column of a factor is 0.
  virtual bool allows_zero(const VarianceFactor& /*factor*/) const { return true; }

 protected:
  VarianceKind() = default;
  VarianceKind(const VarianceKind&) = default;
  VarianceKind& operator=(const VarianceKind&) = default;
};

/// All kinds, in the order of the enumeration.
const std::vector<const VarianceKind*>& variance_kinds();
const VarianceKind& kind_of(VarianceFactor::Kind kind);
inline const VarianceKind& kind_of(const VarianceFactor& factor) { return kind_of(factor.kind); }

/// Whether a factor can be the same for all observations.
inline bool contains_constant(const VarianceFactor& factor) {
  const bool has_exponent = kind_of(factor).has_delta() && factor.delta && *factor.delta != 0.0;
  // The power vanishes beside a large constant.
  return !has_exponent || (kind_of(factor).has_constant() && !factor.constant);
}

/// Whether a constant variance is a special case of this function.
inline bool contains_constant(const VarianceFunction& function) {
  return std::ranges::all_of(
      function.factors, [](const VarianceFactor& factor) { return contains_constant(factor); });
}

/// Between a constant variance and one that grows in proportion.
inline constexpr double kStartExponent = 0.5;

/// The internal deltas of a factor or the held value of delta, one per stratum.
VectorXd internal_or_held_delta(const InternalFactor& internal, Index strata);

/// A text with its variables substituted. A substituted column may have the name of a variable of
/// the text. Therefore these first get names in parentheses, which no column of a formula has.
data::Expression filled(std::string_view text,
                        const std::vector<std::pair<std::string_view, data::Expression>>& parts);

const VarianceKind& exponential_variance();
const VarianceKind& power_variance();
const VarianceKind& constant_plus_power_variance();
const VarianceKind& stratum_variance();

}  // namespace silvafit::fit
