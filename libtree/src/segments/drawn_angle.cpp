// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <numbers>

#include "segments/branch_plan.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

constexpr int kSteps = 1024;
using Quantiles = std::array<double, kSteps + 1>;

// Of a standard normal below -2, and between -2 and 2. Constants, because compilers may round the
// last digit differently than the library at run time.
constexpr double kBelow = 0.022750131948179207;
constexpr double kInside = 0.95449973610364159;

double normal_probability(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

/// Quantiles of the standard normal truncated at -2 and 2, relative to that interval.
Quantiles truncated_quantiles() {
  Quantiles quantiles{};
  double x = -2.0;
  for (int i = 0; i <= kSteps; ++i) {
    const double wanted = kBelow + kInside * i / kSteps;
    // Newton's steps from the previous quantile; the density is never below 0.05 here.
    for (int step = 0; step < 20; ++step) {
      const double density =
          std::exp(-0.5 * x * x) / (std::numbers::sqrt2 * std::sqrt(std::numbers::pi));
      x -= (normal_probability(x) - wanted) / density;
    }
    quantiles[static_cast<std::size_t>(i)] = (x + 2.0) / 4.0;
  }
  quantiles.front() = 0.0;
  quantiles.back() = 1.0;
  return quantiles;
}

}  // namespace

double drawn_angle(Random& random, double low_deg, double high_deg) {
  static const Quantiles quantiles = truncated_quantiles();
  const double at = random.uniform() * kSteps;
  const auto below = static_cast<std::size_t>(at);
  const double part = at - static_cast<double>(below);
  const double share = quantiles[below] + part * (quantiles[below + 1] - quantiles[below]);
  return kRadian * (low_deg + share * (high_deg - low_deg));
}

}  // namespace silvafit::tree
