// SPDX-License-Identifier: MIT
// Confidence intervals of parameters in a fit.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/enum_words.hpp"

namespace silvafit::fit {

enum class IntervalMethod {
  kWald,     ///< estimate and standard error, on a scale where the likelihood is nearly parabolic
  kProfile,  ///< from the likelihood maximized over all other parameters
};
constexpr std::array<std::string_view, 2> words_of(IntervalMethod /*method*/) {
  return {"wald", "profile"};
}

/// The kind of a parameter.
enum class ParameterKind {
  kFixed,
  kDeviation,
  kCorrelation,  ///< of random effects
  kVariance,
  kSigma,
  kResidualCorrelation,
  kDerived,
};
constexpr std::array<std::string_view, 7> words_of(ParameterKind /*kind*/) {
  return {"fixed",
          "standard deviation",
          "correlation",
          "variance function",
          "sigma",
          "residual correlation",
          "derived"};
}

/// The interval of one parameter. An unknown limit is NaN, one that does not exist is infinite; the
/// note has the reason.
struct ParameterInterval {
  ParameterKind kind = ParameterKind::kFixed;
  std::string name{};  ///< "a", "b:C", "sd(a)", "cor(a, b)", "sd(a | stand)", "delta", "sigma"
  double estimate = 0.0;
  double lower = 0.0;
  double upper = 0.0;
  std::string note{};  ///< empty, or a note on the limits
};

struct Intervals {
  IntervalMethod method = IntervalMethod::kWald;
  double level = 0.95;
  std::string likelihood{};  ///< name of the likelihood
  std::vector<ParameterInterval> parameters{};
};

}  // namespace silvafit::fit
