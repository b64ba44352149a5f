// SPDX-License-Identifier: MIT
// Confidence intervals of parameters, as a fit keeps them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace silvafit::fit {

enum class IntervalMethod {
  kWald,     ///< estimate and standard error, on a scale where the likelihood is nearly parabolic
  kProfile,  ///< where the likelihood, maximized over all else, falls by what chance allows
};
/// \throws UsageError if there is no such method
IntervalMethod parse_interval_method(std::string_view text);
std::string interval_method_text(IntervalMethod method);

/// What a parameter is.
enum class ParameterKind { kFixed, kDeviation, kCorrelation, kVariance, kSigma };

/// The interval of one parameter. A limit that is not known is NaN, one that does not exist
/// infinite; the note says why.
struct ParameterInterval {
  ParameterKind kind = ParameterKind::kFixed;
  std::string name{};  ///< "a", "b:C", "sd(a)", "cor(a, b)", "sd(a | stand)", "delta", "sigma"
  double estimate = 0.0;
  double lower = 0.0;
  double upper = 0.0;
  std::string note{};  ///< empty, or what there is to say of the limits
};

struct Intervals {
  IntervalMethod method = IntervalMethod::kWald;
  double level = 0.95;
  std::string likelihood{};  ///< which one it is, in words
  std::vector<ParameterInterval> parameters{};
};

}  // namespace silvafit::fit
