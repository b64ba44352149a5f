// SPDX-License-Identifier: MIT
#include "inference/profile_scale.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using Form = NaturalParameter::Form;

/// Of the range of a common correlation.
double middle(const NaturalParameter& parameter) { return 0.5 * (parameter.high + parameter.low); }
double half_width(const NaturalParameter& parameter) {
  return 0.5 * (parameter.high - parameter.low);
}

}  // namespace

ProfileScale::ProfileScale(const NaturalParameter& of, double estimate) : parameter(of) {
  switch (of.form) {
    case Form::kDeviation:
    case Form::kIdentity:
    case Form::kCommonDeviation:
      low = 0.0;
      break;
    case Form::kCorrelation:
    case Form::kCommonCorrelation:
      low = -0.5 * std::numbers::pi;
      high = 0.5 * std::numbers::pi;
      break;
    case Form::kSquare:
    case Form::kOdds: {
      low = 0.0;
      high = 0.5 * std::numbers::pi;
      constexpr double kNoConstant = 1e-8;
      if (std::isfinite(estimate) && estimate > kNoConstant) reference = estimate;
      break;
    }
    default:
      break;
  }
}

double ProfileScale::to(double value) const {
  switch (parameter.form) {
    case Form::kCorrelation:
      return std::asin(std::clamp(value, -1.0, 1.0));
    case Form::kCommonCorrelation:
      return std::asin(std::clamp((value - middle(parameter)) / half_width(parameter), -1.0, 1.0));
    case Form::kSquare:
    case Form::kOdds:
      return std::isinf(value) ? high : std::atan(std::sqrt(value / reference));
    case Form::kDeviation:
    case Form::kIdentity:
    case Form::kCommonDeviation:
      return value;
    default:
      return to_symmetric(parameter, value);
  }
}

double ProfileScale::from(double t) const {
  switch (parameter.form) {
    case Form::kCorrelation:
      return t <= low ? -1.0 : (t >= high ? 1.0 : std::sin(t));
    case Form::kCommonCorrelation:
      if (t <= low) return parameter.low;
      return t >= high ? 1.0 : middle(parameter) + half_width(parameter) * std::sin(t);
    case Form::kSquare:
    case Form::kOdds:
      return t >= high ? kInfinity : reference * std::pow(std::tan(t), 2);
    case Form::kDeviation:
    case Form::kIdentity:
    case Form::kCommonDeviation:
      return t;
    default:
      return from_symmetric(parameter, t);
  }
}

}  // namespace silvafit::fit
