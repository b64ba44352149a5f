// SPDX-License-Identifier: MIT
// Random numbers that are the same on every machine for the same seed.
#pragma once

#include <array>
#include <cstdint>

namespace silvafit {

/// A stream of random numbers (xoshiro256++ seeded by splitmix64).
///
/// The distributions are implemented here because those of the standard library differ between
/// implementations. Different `stream` numbers give independent sequences for one seed, one for
/// each task, so that results do not depend on the number of threads. Source: Blackman and Vigna
/// 2021, ACM Transactions on Mathematical Software 47(4); Steele et al. 2014.
class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0);

  /// 64 random bits.
  std::uint64_t bits();
  /// Uniform in [0, 1).
  double uniform();
  /// Uniform in [low, high).
  double uniform(double low, double high);
  /// Uniform among 0 .. count - 1; count > 0.
  std::uint64_t below(std::uint64_t count);
  /// Standard normal (Marsaglia's polar method).
  double normal();
  double normal(double mean, double standard_deviation);
  /// Normal truncated to [low, high], by rejection. low < high; the probability of the interval
  /// must not be tiny.
  double truncated_normal(double mean, double standard_deviation, double low, double high);
  /// Gamma with the given shape and scale, both > 0 (Marsaglia and Tsang 2000).
  double gamma(double shape, double scale);

 private:
  std::array<std::uint64_t, 4> state_{};
};

}  // namespace silvafit
