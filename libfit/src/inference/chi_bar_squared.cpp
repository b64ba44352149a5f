// SPDX-License-Identifier: MIT
#include "silvafit/fit/chi_bar_squared.hpp"

#include <fmt/format.h>

#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

namespace silvafit::fit {
namespace {

/// Weights that are simple fractions, as fractions.
std::string weight_text(double weight) {
  for (const int denominator : {1, 2, 4, 8, 16}) {
    const double numerator = weight * denominator;
    if (std::abs(numerator - std::round(numerator)) > 1e-9) continue;
    return denominator == 1 ? "" : fmt::format("{:.0f}/{} ", numerator, denominator);
  }
  return fmt::format("{:.3f} ", weight);
}

}  // namespace

double ChiBarSquared::upper_tail(double x) const {
  if (!(x > 0.0)) return std::isnan(x) ? x : 1.0;
  if (std::isinf(x)) return 0.0;
  double result = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const int freedom = base + static_cast<int>(i);
    if (freedom == 0 || weights[i] == 0.0) continue;
    result += weights[i] *
              boost::math::cdf(boost::math::complement(boost::math::chi_squared(freedom), x));
  }
  return result;
}

std::string ChiBarSquared::text() const {
  if (weights.size() == 1) {
    return fmt::format("chi-squared with {} degree{} of freedom", base, base == 1 ? "" : "s");
  }
  std::string result;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] == 0.0) continue;
    if (!result.empty()) result += " + ";
    result += fmt::format("{}chi-squared({})", weight_text(weights[i]), base + static_cast<int>(i));
  }
  return result;
}

ChiBarSquared independent_variances(int k) {
  ChiBarSquared result{.weights = {std::pow(0.5, k)}};
  for (int i = 1; i <= k; ++i) {
    result.weights.push_back(result.weights.back() * (k - i + 1) / i);
  }
  return result;
}

}  // namespace silvafit::fit
