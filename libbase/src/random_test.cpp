// SPDX-License-Identifier: MIT
#include "silvafit/base/random.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

using silvafit::Random;

namespace {

struct Moments {
  double mean = 0.0;
  double variance = 0.0;
};

template <typename Draw>
Moments moments_of(int count, Draw draw) {
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < count; ++i) {
    const double x = draw();
    sum += x;
    squares += x * x;
  }
  const double mean = sum / count;
  return {mean, squares / count - mean * mean};
}

}  // namespace

TEST_CASE("the same seed and stream repeat, others differ") {
  Random a(7, 3);
  Random b(7, 3);
  Random c(7, 4);
  Random d(8, 3);
  const auto first = a.bits();
  CHECK(first == b.bits());
  CHECK(first != c.bits());
  CHECK(first != d.bits());
}

// Tolerances are five standard errors of the moment over 200,000 draws.
TEST_CASE("variates have the moments of their distributions") {
  constexpr int kCount = 200000;
  Random random(20260101);
  const double n = kCount;

  const Moments uniform = moments_of(kCount, [&] { return random.uniform(); });
  CHECK(uniform.mean == Approx(0.5).margin(5 * std::sqrt(1.0 / 12 / n)));
  CHECK(uniform.variance == Approx(1.0 / 12).margin(5 * std::sqrt(1.0 / 180 / n)));

  const Moments normal = moments_of(kCount, [&] { return random.normal(2.0, 3.0); });
  CHECK(normal.mean == Approx(2.0).margin(5 * 3.0 / std::sqrt(n)));
  CHECK(normal.variance == Approx(9.0).margin(5 * 9.0 * std::sqrt(2.0 / n)));

  for (const double shape : {0.4, 3.5}) {
    const Moments gamma = moments_of(kCount, [&] { return random.gamma(shape, 2.0); });
    const double variance = shape * 4.0;
    CHECK(gamma.mean == Approx(shape * 2.0).margin(5 * std::sqrt(variance / n)));
    CHECK(gamma.variance == Approx(variance).margin(5 * variance * std::sqrt((2 + 6 / shape) / n)));
  }
}

// The tolerances are five standard errors, of the standardized moments.
TEST_CASE("gamma variates end for any shape, and are normal for large ones") {
  constexpr int kCount = 20000;
  Random random(7);
  const double n = kCount;
  for (const double shape : {0.9e8, 1.1e8, 1e16, 1e20, 1e30}) {
    const double scale = 1.0 / std::sqrt(shape);
    const Moments gamma =
        moments_of(kCount, [&] { return random.gamma(shape, scale) / std::sqrt(shape) - 1.0; });
    // Of a ratio to the mean: numbers about 1 have 16 digits.
    const double sd = std::max(1.0 / std::sqrt(shape), 1e-16);
    CHECK(std::abs(gamma.mean) < 5.0 * sd / std::sqrt(n) + 1e-16);
    if (shape < 1e20) CHECK(gamma.variance * shape == Approx(1.0).margin(5.0 * std::sqrt(2.0 / n)));
  }
}

TEST_CASE("a truncated normal stays in its interval") {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const double x = random.truncated_normal(0.0, 1.0, 1.0, 2.0);
    REQUIRE(x >= 1.0);
    REQUIRE(x <= 2.0);
  }
}

TEST_CASE("whole numbers below a bound are even") {
  Random random(5);
  std::vector<int> counts(7, 0);
  for (int i = 0; i < 70000; ++i) ++counts[random.below(7)];
  for (const int count : counts) CHECK(count == Approx(10000).margin(5 * std::sqrt(10000.0)));
}
