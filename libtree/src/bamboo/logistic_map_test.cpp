// SPDX-License-Identifier: MIT
#include "bamboo/logistic_map.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "silvafit/base/error.hpp"

using namespace silvafit;
using namespace silvafit::tree;

TEST_CASE("the map follows its recurrence") {
  // By hand: 3.7 * 0.2 * 0.8 = 0.592; 3.7 * 0.592 * 0.408 = 0.8936832; 3.7 * 0.8936832 * 0.1063168
  // = 0.351550...
  LogisticMap map(3.7, 0.2);
  CHECK(map.next() == Approx(0.592).epsilon(1e-14));
  CHECK(map.next() == Approx(0.8936832).epsilon(1e-14));
  CHECK(map.next() == Approx(3.7 * 0.8936832 * 0.1063168).epsilon(1e-13));
  // At mu = 4 there is a closed form, X_n = sin^2(2^n asin(sqrt(X_0))).
  LogisticMap four(4.0, 0.3);
  for (int n = 1; n <= 20; ++n) {
    const double exact = std::pow(std::sin(std::pow(2.0, n) * std::asin(std::sqrt(0.3))), 2);
    // Errors double with each step: 2^20 rounding errors.
    CHECK(four.next() == Approx(exact).margin(1e-9));
  }
}

TEST_CASE("the same start gives the same values, another start different ones") {
  LogisticMap one(4.0, 0.1234);
  LogisticMap same(4.0, 0.1234);
  LogisticMap near(4.0, 0.1234 + 1e-10);
  double apart = 0.0;
  for (int i = 0; i < 200; ++i) {
    const double x = one.next();
    CHECK(same.next() == x);
    apart = std::max(apart, std::abs(near.next() - x));
  }
  CHECK(apart > 0.5);
}

TEST_CASE("parameters outside the map's range are refused") {
  for (const double mu : {3.5699, 4.0000001, 0.0, -1.0, std::nan("")}) {
    CHECK_THROWS_AS(LogisticMap(mu, 0.3), UsageError);
  }
  for (const double x0 : {0.0, 1.0, -0.1, 1.1, std::nan("")}) {
    CHECK_THROWS_AS(LogisticMap(4.0, x0), UsageError);
  }
  CHECK_NOTHROW(LogisticMap(3.56994, 0.3));
  CHECK_NOTHROW(LogisticMap(4.0, 0.3));
}

TEST_CASE("starts that end in a fixed point or a short cycle are refused") {
  // 0.5 -> 1 -> 0; 0.25 -> 0.75 and 0.75 stay at 0.75; sin^2(pi/5), a cycle of two.
  const double of_two = std::pow(std::sin(std::numbers::pi / 5.0), 2);
  for (const double x0 : {0.5, 0.75, 0.25, of_two}) {
    CHECK_FALSE(LogisticMap::is_chaotic(4.0, x0));
    CHECK_THROWS_AS(LogisticMap(4.0, x0), UsageError);
  }
  // The fixed point 1 - 1 / mu of another mu, and the window of period three around 3.83.
  CHECK_FALSE(LogisticMap::is_chaotic(3.7, 1.0 - 1.0 / 3.7));
  CHECK_FALSE(LogisticMap::is_chaotic(3.83, 0.3));
}

TEST_CASE("values stay inside (0, 1) and never become constant") {
  for (const double mu : {3.56994, 3.7, 3.99, 4.0}) {
    LogisticMap map(mu, 0.3);
    double before = 0.3;
    bool goes_on = true;
    for (int i = 0; i < 2'000'000; ++i) {
      const double x = map.next();
      goes_on = goes_on && x > 0.0 && x < 1.0 && x != before;
      before = x;
    }
    CHECK(goes_on);
  }
}

TEST_CASE("at mu = 4 the values have the arcsine distribution") {
  // Every 20th value: the map doubles angles, so that values 20 steps apart are nearly independent.
  constexpr int kValues = 20'000;
  constexpr int kThinning = 20;
  for (const double x0 : {0.1, 0.3, 0.871}) {
    LogisticMap map(4.0, x0);
    std::vector<double> values(kValues);
    for (double& value : values) {
      for (int skipped = 1; skipped < kThinning; ++skipped) map.next();
      value = map.next();
    }
    std::sort(values.begin(), values.end());
    double farthest = 0.0;
    for (int i = 0; i < kValues; ++i) {
      const double exact = 2.0 / std::numbers::pi * std::asin(std::sqrt(values[i]));
      farthest = std::max({farthest,
                           std::abs(exact - static_cast<double>(i) / kValues),
                           std::abs(exact - static_cast<double>(i + 1) / kValues)});
    }
    // Kolmogorov-Smirnov at the level 0.001: 1.9495 / sqrt(n).
    INFO("x0 " << x0 << ", sqrt(n) D = " << farthest * std::sqrt(kValues));
    CHECK(farthest < 1.9495 / std::sqrt(kValues));
  }
}
