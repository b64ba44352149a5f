// SPDX-License-Identifier: MIT
#include "inference/natural_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "silvafit/base/constants.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Form = NaturalParameter::Form;

/// Two rows of a triangular factor at a given correlation.
///
/// The second row is n (r e + t u), with n the length of a free vector w, e the direction of the
/// first row, u that of the part of w at a right angle to it, and t = sqrt(1 - r^2). There are no
/// other conditions on the rows, and the factor stays triangular.
struct FactorRows {
  VectorXd first;      ///< (l) the first row
  VectorXd along;      ///< e
  VectorXd across;     ///< u
  VectorXd free;       ///< w
  VectorXd direction;  ///< r e + t u
  double first_length = 0.0;
  double across_length = 0.0;  ///< of the part of w at a right angle to e
  double r = 0.0;
  double t = 0.0;

  FactorRows(const MatrixXd& factor, Index row, Index other, double correlation)
      : first(factor.row(row).head(other + 1)),
        free(factor.row(other).head(other + 1)),
        r(correlation),
        t(std::sqrt(std::max(0.0, 1.0 - correlation * correlation))) {
    first_length = first.norm();
    along = first_length > 0.0 ? VectorXd(first / first_length) : VectorXd::Unit(other + 1, row);
    VectorXd rest = free - free.dot(along) * along;
    across_length = rest.norm();
    constexpr double kParallel = 1e-8;
    if (across_length <= kParallel * free.norm()) {
      // Any direction at a right angle is valid; the row's diagonal keeps the factor triangular.
      rest = VectorXd::Unit(other + 1, other);
      rest -= rest.dot(along) * along;
      across_length = free.norm();
      rest *= across_length / rest.norm();
    }
    across = rest.normalized();
    direction = r * along + t * across;
  }

  VectorXd second() const { return free.norm() * direction; }

  /// Gradients by both rows become those by the first row and w.
  void pull_back(VectorXd& by_first, VectorXd& by_second) const {
    const double n = free.norm();
    if (n == 0.0 || first_length == 0.0) {
      by_second.setZero();
      return;
    }
    const VectorXd turn =
        n * t / across_length * (by_second - by_second.dot(across) * across).eval();
    const VectorXd by_along = n * r * by_second - turn.dot(along) * free - free.dot(along) * turn;
    by_first += (by_along - by_along.dot(along) * along) / first_length;
    by_second = (by_second.dot(direction) / n * free + turn - turn.dot(along) * along).eval();
  }
};

/// The common deviation s of effects with compound symmetry from the roots of the eigenvalues, a
/// and b, and the correlation.
struct CommonScale {
  Eigen::Vector2d roots;  ///< a, b
  double count = 2.0;     ///< q

  CommonScale(const VectorXd& x, Index coordinate, Index effects)
      : roots(x.segment<2>(coordinate)), count(static_cast<double>(effects)) {}

  double deviation() const {
    return std::sqrt(((count - 1.0) * roots[0] * roots[0] + roots[1] * roots[1]) / count);
  }
  /// Of the deviation by the roots.
  Eigen::Vector2d slopes() const {
    const Eigen::Vector2d weighted((count - 1.0) * roots[0], roots[1]);
    return weighted / (count * deviation());
  }
  double correlation() const {
    const double s = deviation();
    return (roots[1] - roots[0]) * (roots[1] + roots[0]) / (count * s * s);
  }
  /// The roots for a deviation of one.
  Eigen::Vector2d at(double correlation) const {
    return {std::sqrt(std::max(0.0, 1.0 - correlation)),
            std::sqrt(std::max(0.0, 1.0 + (count - 1.0) * correlation))};
  }
};

/// Replaces the part of a gradient by x that belongs to a factor.
void set_factor_gradient(const SurfaceLayout& layout,
                         const VectorXd& x,
                         std::size_t term,
                         const MatrixXd& by_own,
                         VectorXd& gradient) {
  const VectorXd slopes = layout.factor_gradient(x, term, by_own);
  gradient.segment(layout.factor_at(term), slopes.size()) = slopes;
}

/// log of the factor from the internal sigma to the reported one.
double log_sigma_factor(const SurfaceLayout& layout,
                        const VarianceModel& variance,
                        const VectorXd& x) {
  return std::log(variance.sigma_factor(layout.variance_part(x)));
}

/// Its slopes: it is linear in all parameters but the angle of constant-plus-power, so that central
/// differences are exact or nearly so, except for rounding.
VectorXd log_sigma_slopes(const SurfaceLayout& layout,
                          const VarianceModel& variance,
                          const VectorXd& x) {
  VectorXd result(layout.variance_count());
  constexpr double kStep = 1e-5;
  for (Index k = 0; k < result.size(); ++k) {
    VectorXd above = x;
    VectorXd below = x;
    above[layout.variance_at() + k] += kStep;
    below[layout.variance_at() + k] -= kStep;
    result[k] =
        (log_sigma_factor(layout, variance, above) - log_sigma_factor(layout, variance, below)) /
        (2.0 * kStep);
  }
  return result;
}

/// The angle of constant-plus-power at which it has a constant.
double angle_of(double constant, const TypicalValue& typical, double delta) {
  return std::atan(std::exp(0.5 * (std::log(constant) - typical.log_power(delta))));
}

std::string effect_name(const std::string& names, const std::string& group) {
  return group.empty() ? names : names + " | " + group;
}

void add_random(const SurfaceSetting& setting,
                const SurfaceLayout& layout,
                std::size_t term,
                std::vector<NaturalParameter>& result) {
  const ModelSpecification& specification = setting.model.specification();
  const RandomEffects& random = specification.random[term];
  const std::string group = specification.random.size() > 1 ? random.group_name() : "";
  const std::vector<std::string>& names = random.coefficients;
  // The joint effect of one unit of each coordinate of the factor.
  const VectorXd unit = layout.frame().effects[term].rowwise().norm();
  const RelativeFactor& factor = layout.factor(term);
  const bool has_common = factor.has_common_correlation();
  const bool is_identity = random.has_equal_variances() && !has_common;
  // Of compound symmetry, too, roots of one make deviations of one.
  const MatrixXd one = random.has_equal_variances()
                           ? factor.factor(VectorXd::Ones(factor.parameter_count()))
                           : MatrixXd();
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto row = static_cast<Index>(k);
    result.push_back({.kind = ParameterKind::kDeviation,
                      .name = fmt::format("sd({})", effect_name(names[k], group)),
                      .form = has_common    ? Form::kCommonDeviation
                              : is_identity ? Form::kIdentity
                                            : Form::kDeviation,
                      .term = term,
                      .row = row,
                      .coordinate = layout.factor_at(term),
                      .scale = unit[row] * (one.size() > 0 ? one(row, row) : 1.0)});
  }
  if (has_common) {
    result.push_back({.kind = ParameterKind::kCorrelation,
                      .name = fmt::format(
                          "cor({})", effect_name(fmt::format("{}", fmt::join(names, ", ")), group)),
                      .form = Form::kCommonCorrelation,
                      .term = term,
                      .coordinate = layout.factor_at(term),
                      .low = -1.0 / static_cast<double>(names.size() - 1)});
    return;
  }
  Index begin = 0;
  for (const int size : random.block_sizes()) {
    for (Index i = begin; i < begin + size; ++i) {
      for (Index j = i + 1; j < begin + size && !is_identity; ++j) {
        const std::string pair =
            names[static_cast<std::size_t>(i)] + ", " + names[static_cast<std::size_t>(j)];
        result.push_back({.kind = ParameterKind::kCorrelation,
                          .name = fmt::format("cor({})", effect_name(pair, group)),
                          .form = Form::kCorrelation,
                          .term = term,
                          .row = i,
                          .other_row = j});
      }
    }
    begin += size;
  }
}

/// The coordinate of the exponent of a factor.
Index delta_of(const VarianceModel& variance, const SurfaceLayout& layout, std::size_t factor) {
  for (const VarianceModel::Quantity& quantity : variance.quantities()) {
    const bool is_delta = quantity.factor == factor && quantity.kind == VarianceQuantity::kDelta;
    if (is_delta) return layout.variance_at() + quantity.first;
  }
  return layout.variance_at();
}

void add_variance(const SurfaceSetting& setting,
                  const SurfaceLayout& layout,
                  std::vector<NaturalParameter>& result) {
  const VarianceFunction& function = setting.model.specification().variance;
  const bool is_product = function.factors.size() > 1;
  for (const VarianceModel::Quantity& quantity : setting.variance.quantities()) {
    const VarianceFactor& factor = function.factors[quantity.factor];
    const VarianceFactorEstimate& estimate = setting.fit.variance.factors[quantity.factor];
    for (Index s = 0; s < quantity.count; ++s) {
      NaturalParameter parameter{.kind = ParameterKind::kVariance,
                                 .coordinate = layout.variance_at() + quantity.first + s};
      if (quantity.kind == VarianceQuantity::kDelta) {
        parameter.name = "delta";
        parameter.scale =
            kind_of(factor).delta_scale(setting.variance.typical_value(quantity.factor));
      } else if (quantity.kind == VarianceQuantity::kLogRatio) {
        parameter.name = "ratio";
        parameter.form = Form::kExponential;
      } else {
        parameter.name = "constant";
        const bool is_square = quantity.strata >= 0 || factor.delta;
        parameter.form = is_square ? Form::kSquare : Form::kOdds;
        parameter.typical = setting.variance.typical_value(quantity.factor);
        if (!is_square) parameter.delta = delta_of(setting.variance, layout, quantity.factor);
      }
      if (is_product) parameter.name += " of " + factor.text();
      const Index stratum = s + (quantity.has_reference ? 1 : 0);
      if (quantity.strata >= 0) {
        parameter.name += fmt::format(" ({})", estimate.strata[static_cast<std::size_t>(stratum)]);
      }
      result.push_back(std::move(parameter));
    }
  }
}

/// A function of the coefficients that are estimated; the others are numbers in it.
NaturalParameter derived_parameter(const SurfaceSetting& setting,
                                   const SurfaceLayout& layout,
                                   const DerivedQuantity& quantity) {
  NaturalParameter result{.kind = ParameterKind::kDerived,
                          .name = quantity.name,
                          .form = Form::kDerived,
                          .derived = quantity,
                          .coefficients = setting.model.coefficient_names()};
  const std::vector<std::string>& all = setting.fit.coefficient_names;
  for (std::size_t j = 0; j < all.size(); ++j) {
    if (std::ranges::find(result.coefficients, all[j]) != result.coefficients.end()) continue;
    const double value = setting.fit.estimate[static_cast<Index>(j)];
    result.derived->value =
        result.derived->value.substitute(all[j], data::Expression::constant(value));
  }
  const VectorXd gradient = result.derived->gradient(result.coefficients, setting.estimate);
  result.weights = layout.frame().beta.transpose() * gradient;
  result.weights.cwiseAbs().maxCoeff(&result.coordinate);
  return result;
}

VectorXd residual_correlation(const SurfaceLayout& layout,
                              const VarianceModel& variance,
                              const VectorXd& x) {
  return variance.correlated()->structure().natural(
      variance.correlation_part(layout.variance_part(x)));
}

void add_correlation(const VarianceModel& variance,
                     const SurfaceLayout& layout,
                     std::vector<NaturalParameter>& result) {
  const CorrelationStructure& structure = variance.correlated()->structure();
  const Index first = variance.parameter_count() - variance.correlation_count();
  for (Index k = 0; k < structure.parameter_count(); ++k) {
    const auto [low, high] = structure.limits(k);
    result.push_back({.kind = ParameterKind::kResidualCorrelation,
                      .name = structure.names()[static_cast<std::size_t>(k)],
                      .form = Form::kResidual,
                      .row = k,
                      .coordinate = layout.variance_at() + first + k,
                      .low = low,
                      .high = high});
  }
}

}  // namespace

bool NaturalParameter::can_be_held(const VarianceModel& variance) const {
  return form != Form::kResidual || variance.correlated()->structure().is_separable();
}

double NaturalParameter::value(const SurfaceLayout& layout,
                               const VarianceModel& variance,
                               const VectorXd& x) const {
  switch (form) {
    case Form::kCoefficient:
      return weights.dot(x.head(weights.size()));
    case Form::kDerived:
      return derived->at(coefficients, layout.beta(x));
    case Form::kCoordinate:
      return scale * x[coordinate];
    case Form::kIdentity:
      return std::abs(scale * x[coordinate]);
    case Form::kExponential:
      return std::exp(x[coordinate]);
    case Form::kSquare:
      return x[coordinate] * x[coordinate];
    case Form::kOdds:
      return std::pow(std::tan(x[coordinate]), 2) * std::exp(typical.log_power(x[delta]));
    case Form::kResidual:
      return residual_correlation(layout, variance, x)[row];
    case Form::kDeviation:
      return layout.own_factor(x, term).row(row).norm();
    case Form::kCorrelation: {
      const MatrixXd factor = layout.own_factor(x, term);
      return factor.row(row).dot(factor.row(other_row)) /
             (factor.row(row).norm() * factor.row(other_row).norm());
    }
    case Form::kCommonDeviation:
      return scale * CommonScale(x, coordinate, layout.factor(term).size()).deviation();
    case Form::kCommonCorrelation:
      return CommonScale(x, coordinate, layout.factor(term).size()).correlation();
    case Form::kSigma:
      break;
  }
  return std::exp(x[layout.sigma_at()] + log_sigma_factor(layout, variance, x));
}

VectorXd NaturalParameter::hold(const SurfaceLayout& layout,
                                const VarianceModel& variance,
                                const VectorXd& free,
                                double value) const {
  VectorXd x = free;
  switch (form) {
    case Form::kCoefficient:
      x[coordinate] += (value - weights.dot(x.head(weights.size()))) / weights[coordinate];
      break;
    case Form::kDerived:
      hold_derived(layout, value, x);
      break;
    case Form::kCoordinate:
    case Form::kIdentity:
      x[coordinate] = value / scale;
      break;
    case Form::kExponential:
      x[coordinate] = std::log(value);
      break;
    case Form::kSquare:
      x[coordinate] = std::sqrt(value);
      break;
    case Form::kOdds:
      x[coordinate] = angle_of(value, typical, x[delta]);
      break;
    case Form::kResidual: {
      VectorXd natural = residual_correlation(layout, variance, x);
      natural[row] = value;
      x[coordinate] = variance.correlated()->structure().unconstrained(natural)[row];
      break;
    }
    case Form::kDeviation: {
      MatrixXd factor = layout.own_factor(x, term);
      const double length = factor.row(row).norm();
      if (length > 0.0) {
        factor.row(row) *= value / length;
      } else {
        factor(row, row) = value;
      }
      layout.set_own_factor(term, factor, x);
      break;
    }
    case Form::kCommonDeviation:
    case Form::kCommonCorrelation: {
      const CommonScale of(x, coordinate, layout.factor(term).size());
      const double deviation = of.deviation();
      x.segment<2>(coordinate) = form == Form::kCommonCorrelation
                                     ? Eigen::Vector2d(deviation * of.at(value))
                                     : Eigen::Vector2d(value / (scale * deviation) * of.roots);
      break;
    }
    case Form::kCorrelation: {
      MatrixXd factor = layout.own_factor(x, term);
      const FactorRows rows(factor, row, other_row, value);
      factor.row(other_row).head(other_row + 1) = rows.second();
      layout.set_own_factor(term, factor, x);
      break;
    }
    case Form::kSigma:
      x[layout.sigma_at()] = std::log(value) - log_sigma_factor(layout, variance, x);
      break;
  }
  return x;
}

VectorXd NaturalParameter::derived_slopes(const SurfaceLayout& layout, const VectorXd& x) const {
  return layout.beta_gradient(derived->gradient(coefficients, layout.beta(x)));
}

void NaturalParameter::hold_near(const SurfaceLayout& layout, double value, VectorXd& free) {
  if (form != Form::kDerived) return;
  VectorXd x = free;
  // Newton's method along the slopes; hold() finds the last digits.
  constexpr int kSteps = 20;
  for (int step = 0; step < kSteps; ++step) {
    const double excess = derived->at(coefficients, layout.beta(x)) - value;
    const VectorXd slopes = derived_slopes(layout, x);
    const VectorXd change = excess / slopes.squaredNorm() * slopes;
    if (!change.allFinite()) return;
    x.head(change.size()) -= change;
  }
  const VectorXd slopes = derived_slopes(layout, x);
  if (!slopes.allFinite()) return;
  slopes.cwiseAbs().maxCoeff(&coordinate);
  free = x;
}

void NaturalParameter::hold_derived(const SurfaceLayout& layout, double value, VectorXd& x) const {
  // Newton's method, from near; coordinates are of the size of the residuals' deviation.
  constexpr int kMostSteps = 50;
  constexpr double kRounding = 1e-13;
  for (int step = 0; step < kMostSteps; ++step) {
    const double excess = derived->at(coefficients, layout.beta(x)) - value;
    const double change = excess / derived_slopes(layout, x)[coordinate];
    x[coordinate] -= change;
    if (!(std::abs(change) > kRounding * std::max(1.0, std::abs(x[coordinate])))) return;
  }
  x[coordinate] = kNaN;
}

VectorXd NaturalParameter::pull_back(const SurfaceLayout& layout,
                                     const VarianceModel& variance,
                                     const VectorXd& free,
                                     double value,
                                     const VectorXd& gradient) const {
  VectorXd result = gradient;
  switch (form) {
    case Form::kCoefficient:
      result.head(weights.size()) -= gradient[coordinate] / weights[coordinate] * weights;
      result[coordinate] = 0.0;
      break;
    case Form::kDerived: {
      const VectorXd slopes = derived_slopes(layout, hold(layout, variance, free, value));
      result.head(slopes.size()) -= gradient[coordinate] / slopes[coordinate] * slopes;
      result[coordinate] = 0.0;
      break;
    }
    case Form::kCoordinate:
    case Form::kIdentity:
    case Form::kExponential:
    case Form::kSquare:
    case Form::kResidual:
      result[coordinate] = 0.0;
      break;
    case Form::kOdds: {
      // angle = atan sqrt(value / P(delta))
      const double angle = angle_of(value, typical, free[delta]);
      const double slope = typical.log_power_slope(free[delta]);
      result[delta] -= 0.25 * std::sin(2.0 * angle) * slope * gradient[coordinate];
      result[coordinate] = 0.0;
      break;
    }
    case Form::kDeviation: {
      const MatrixXd factor = layout.own_factor(free, term);
      MatrixXd by_factor = layout.own_factor_gradient(term, gradient);
      const double length = factor.row(row).norm();
      if (length > 0.0) {
        const VectorXd along = factor.row(row) / length;
        const VectorXd by_row = by_factor.row(row);
        by_factor.row(row) = value / length * (by_row - by_row.dot(along) * along);
      } else {
        by_factor.row(row).setZero();
      }
      set_factor_gradient(layout, free, term, by_factor, result);
      break;
    }
    case Form::kCommonDeviation: {
      const CommonScale of(free, coordinate, layout.factor(term).size());
      auto by_roots = result.segment<2>(coordinate);
      const double share = value / (scale * of.deviation());
      const double along = by_roots.dot(of.roots) / of.deviation();
      by_roots = (share * (by_roots - along * of.slopes())).eval();
      break;
    }
    case Form::kCommonCorrelation: {
      const CommonScale of(free, coordinate, layout.factor(term).size());
      auto by_roots = result.segment<2>(coordinate);
      by_roots = (by_roots.dot(of.at(value)) * of.slopes()).eval();
      break;
    }
    case Form::kCorrelation: {
      const FactorRows rows(layout.own_factor(free, term), row, other_row, value);
      MatrixXd by_factor = layout.own_factor_gradient(term, gradient);
      VectorXd by_first = by_factor.row(row).head(other_row + 1);
      VectorXd by_second = by_factor.row(other_row).head(other_row + 1);
      rows.pull_back(by_first, by_second);
      by_factor.row(row).head(other_row + 1) = by_first;
      by_factor.row(other_row).head(other_row + 1) = by_second;
      set_factor_gradient(layout, free, term, by_factor, result);
      break;
    }
    case Form::kSigma:
      result.segment(layout.variance_at(), layout.variance_count()) -=
          gradient[layout.sigma_at()] * log_sigma_slopes(layout, variance, free);
      result[layout.sigma_at()] = 0.0;
      break;
  }
  return result;
}

std::vector<NaturalParameter> natural_parameters(const SurfaceSetting& setting,
                                                 const SurfaceLayout& layout) {
  std::vector<NaturalParameter> result;
  for (Index j = 0; j < layout.beta_count(); ++j) {
    NaturalParameter coefficient{
        .kind = ParameterKind::kFixed,
        .name = setting.model.coefficient_names()[static_cast<std::size_t>(j)],
        .form = Form::kCoefficient,
        .weights = layout.frame().beta.row(j)};
    coefficient.weights.cwiseAbs().maxCoeff(&coefficient.coordinate);
    result.push_back(std::move(coefficient));
  }
  for (std::size_t term = 0; term < layout.terms(); ++term) {
    add_random(setting, layout, term, result);
  }
  add_variance(setting, layout, result);
  if (setting.variance.correlated() != nullptr) {
    add_correlation(setting.variance, layout, result);
  }
  result.push_back({.kind = ParameterKind::kSigma, .name = "sigma", .form = Form::kSigma});
  return result;
}

std::vector<NaturalParameter> derived_parameters(const SurfaceSetting& setting,
                                                 const SurfaceLayout& layout) {
  std::vector<NaturalParameter> result;
  for (const DerivedQuantity& quantity : setting.fit.specification.derived) {
    result.push_back(derived_parameter(setting, layout, quantity));
  }
  return result;
}

double to_symmetric(const NaturalParameter& parameter, double value) {
  switch (parameter.form) {
    case Form::kCoefficient:
    case Form::kDerived:
    case Form::kCoordinate:
      return value;
    case Form::kCorrelation:
      return std::log((1.0 + value) / (1.0 - value));
    case Form::kResidual:
    case Form::kCommonCorrelation:
      return std::log(
          std::isinf(parameter.high) ? value : (value - parameter.low) / (parameter.high - value));
    default:
      return std::log(value);
  }
}

double from_symmetric(const NaturalParameter& parameter, double value) {
  switch (parameter.form) {
    case Form::kCoefficient:
    case Form::kDerived:
    case Form::kCoordinate:
      return value;
    case Form::kCorrelation:
      return std::tanh(0.5 * value);
    case Form::kResidual:
    case Form::kCommonCorrelation:
      return std::isinf(parameter.high)
                 ? std::exp(value)
                 : parameter.low + (parameter.high - parameter.low) / (1.0 + std::exp(-value));
    default:
      return std::exp(value);
  }
}

}  // namespace silvafit::fit
