// SPDX-License-Identifier: MIT
#include "bamboo/logistic_map.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

double step(double mu, double x) { return mu * x * (1.0 - x); }

/// Whether a value returns within a few steps so close to itself that it would repeat for more
/// steps than a culm has branches.
bool repeats_soon(double mu, double x0) {
  constexpr int kLookedAt = 256;
  constexpr std::size_t kLongestPeriod = 8;
  constexpr double kSame = 1e-9;
  std::array<double, kLongestPeriod> last{};
  last.fill(-1.0);
  double x = x0;
  for (int i = 0; i < kLookedAt; ++i) {
    for (const double before : last) {
      if (std::abs(x - before) < kSame) return true;
    }
    last.at(static_cast<std::size_t>(i) % kLongestPeriod) = x;
    x = step(mu, x);
  }
  return false;
}

}  // namespace

bool LogisticMap::is_chaotic(double mu, double x0) {
  return mu >= kLeastMu && mu <= kMostMu && x0 > 0.0 && x0 < 1.0 && !repeats_soon(mu, x0);
}

LogisticMap::LogisticMap(double mu, double x0) : mu_(mu), x0_(x0), x_(x0) {
  if (is_chaotic(mu, x0)) return;
  throw UsageError(fmt::format(
      "the logistic map needs mu in [{}, {}], a start value between 0 and 1, and values "
      "that do not soon repeat; mu {} and start value {} do not give them",
      kLeastMu,
      kMostMu,
      mu,
      x0));
}

double LogisticMap::next() {
  const double before = x_;
  x_ = step(mu_, x_);
  while (!(x_ > 0.0 && x_ < 1.0 && x_ != before)) {
    constexpr double kGolden = 0.6180339887498949;
    double ignored = 0.0;
    x_ = step(mu_, std::modf(x0_ + kGolden * ++restarts_, &ignored));
  }
  return x_;
}

}  // namespace silvafit::tree
