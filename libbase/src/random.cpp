// SPDX-License-Identifier: MIT
#include "silvafit/base/random.hpp"

#include <bit>
#include <cmath>

#include "silvafit/base/error.hpp"

namespace silvafit {
namespace {

std::uint64_t splitmix64(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15U);
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31U);
}

/// d (1 - (1 + t)^3 + 3 log(1 + t)) for a small t, by its Taylor series, which has no terms in t
/// and t^3.
double log_density(double d, double t) {
  const double squared = t * t;
  return -d * squared * (4.5 + squared * (0.75 - 0.6 * t));
}

}  // namespace

Random::Random(std::uint64_t seed, std::uint64_t stream) {
  std::uint64_t stream_state = stream;
  std::uint64_t state = seed ^ splitmix64(stream_state);
  for (std::uint64_t& word : state_) word = splitmix64(state);
}

std::uint64_t Random::bits() {
  const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t shifted = state_[1] << 17U;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= shifted;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double Random::uniform() { return static_cast<double>(bits() >> 11U) * 0x1.0p-53; }

double Random::uniform(double low, double high) { return low + (high - low) * uniform(); }

std::uint64_t Random::below(std::uint64_t count) {
  // Values above the largest multiple of count would make small results more probable.
  const std::uint64_t threshold = (0 - count) % count;
  for (;;) {
    const std::uint64_t value = bits();
    if (value >= threshold) return value % count;
  }
}

double Random::normal() {
  for (;;) {
    const double u = uniform(-1.0, 1.0);
    const double v = uniform(-1.0, 1.0);
    const double s = u * u + v * v;
    if (s > 0.0 && s < 1.0) return u * std::sqrt(-2.0 * std::log(s) / s);
  }
}

double Random::normal(double mean, double standard_deviation) {
  return mean + standard_deviation * normal();
}

double Random::truncated_normal(double mean, double standard_deviation, double low, double high) {
  constexpr int kAttempts = 100000;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const double value = normal(mean, standard_deviation);
    if (value >= low && value <= high) return value;
  }
  throw UsageError("the interval of a truncated normal distribution has a probability of almost 0");
}

double Random::gamma(double shape, double scale) {
  if (shape < 1.0) {
    const double power = std::pow(1.0 - uniform(), 1.0 / shape);
    return gamma(shape + 1.0, scale) * power;
  }
  // For larger shapes, d and d v agree in so many digits that their difference is lost.
  constexpr double kLargeShape = 1e8;
  const double d = shape - 1.0 / 3.0;
  const double c = 1.0 / std::sqrt(9.0 * d);
  for (;;) {
    const double x = normal();
    const double base = 1.0 + c * x;
    if (base <= 0.0) continue;
    const double v = base * base * base;
    const double density = d < kLargeShape ? d - d * v + d * std::log(v) : log_density(d, c * x);
    if (std::log(1.0 - uniform()) < 0.5 * x * x + density) return d * v * scale;
  }
}

}  // namespace silvafit
