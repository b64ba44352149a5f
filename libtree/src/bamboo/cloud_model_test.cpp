// SPDX-License-Identifier: MIT
#include "bamboo/cloud_model.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "silvafit/base/error.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

/// Mean and central moments of many values.
struct Moments {
  double mean = 0.0;
  double second = 0.0;
  double fourth = 0.0;
};

Moments moments_of(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  Moments moments{.mean = std::accumulate(values.begin(), values.end(), 0.0) / n};
  for (const double value : values) {
    const double square = (value - moments.mean) * (value - moments.mean);
    moments.second += square / n;
    moments.fourth += square * square / n;
  }
  return moments;
}

std::vector<double> drawn(const NormalCloud& cloud, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> values(count);
  for (double& value : values) value = draw(cloud, random).value;
  return values;
}

}  // namespace

TEST_CASE("the cloud has the mean, variance and fourth moment of theory") {
  constexpr std::size_t kDrops = 1'000'000;
  struct Case {
    double en;
    double he;
  };
  for (const auto& [en, he] : {Case{2, 1}, Case{2, 0}, Case{0, 1}, Case{3, 0.5}, Case{1, 2}}) {
    INFO("En " << en << " He " << he);
    // The limits 0 and 100 have no effect: they are 13 standard deviations away or more.
    const NormalCloud cloud{
        .expectation = 50, .entropy = en, .hyper_entropy = he, .low = 0, .high = 100};
    const Moments found = moments_of(drawn(cloud, kDrops, 3));
    // E s^2 .. E s^8 of s ~ N(En, He); x - Ex = s z, so its moments are those of s times those of
    // z.
    const double e2 = en * en;
    const double h2 = he * he;
    const double s2 = e2 + h2;
    const double s4 = e2 * e2 + 6 * e2 * h2 + 3 * h2 * h2;
    const double s8 = std::pow(e2, 4) + 28 * std::pow(e2, 3) * h2 + 210 * e2 * e2 * h2 * h2 +
                      420 * e2 * std::pow(h2, 3) + 105 * std::pow(h2, 4);
    const double fourth = 3 * s4;
    const double eighth = 105 * s8;
    // Five Monte Carlo standard errors; one in two million runs fails by chance.
    const double root = std::sqrt(static_cast<double>(kDrops));
    CHECK(found.mean == Approx(50.0).margin(5 * std::sqrt(s2) / root));
    CHECK(found.second == Approx(s2).margin(5 * std::sqrt(fourth - s2 * s2) / root));
    CHECK(found.fourth == Approx(fourth).margin(5 * std::sqrt(eighth - fourth * fourth) / root));
  }
}

TEST_CASE("values outside the limits are drawn anew") {
  // Limits one standard deviation from the mean of a normal (He = 0): the variance of a normal cut
  // off at -1 and 1 is 1 - 2 phi(1) / (2 Phi(1) - 1) = 0.2911 (Johnson, Kotz, Balakrishnan 1994).
  const NormalCloud cloud{.expectation = 5, .entropy = 2, .hyper_entropy = 0, .low = 3, .high = 7};
  const std::vector<double> values = drawn(cloud, 400'000, 4);
  CHECK(*std::min_element(values.begin(), values.end()) >= 3.0);
  CHECK(*std::max_element(values.begin(), values.end()) <= 7.0);
  const double phi = std::exp(-0.5) / std::sqrt(2.0 * std::acos(-1.0));
  const double variance = 4.0 * (1.0 - 2.0 * phi / std::erf(1.0 / std::sqrt(2.0)));
  const Moments found = moments_of(values);
  // Five standard errors: variance 1.16, fourth moment at most 2^4.
  CHECK(found.mean == Approx(5.0).margin(5 * std::sqrt(variance / 400'000)));
  CHECK(found.second == Approx(variance).margin(5 * 4.0 / std::sqrt(400'000.0)));
}

TEST_CASE("membership falls from 1 at the expectation, on the average to 1 / sqrt(2)") {
  // For any En', E exp(-z^2 / 2) over z ~ N(0, 1) is 1 / sqrt(2), E of its square 1 / sqrt(3).
  constexpr int kDrops = 200'000;
  Random random(5);
  double sum = 0.0;
  bool in_range = true;
  for (int i = 0; i < kDrops; ++i) {
    const CloudDrop drop = draw({}, random);
    in_range = in_range && drop.membership > 0.0 && drop.membership <= 1.0;
    sum += drop.membership;
  }
  CHECK(in_range);
  const double sd = std::sqrt(1.0 / std::sqrt(3.0) - 0.5);
  CHECK(sum / kDrops == Approx(1.0 / std::sqrt(2.0)).margin(5 * sd / std::sqrt(kDrops)));
  const CloudDrop still = draw({.expectation = 40, .entropy = 0, .hyper_entropy = 0}, random);
  CHECK(still.value == 40.0);
  CHECK(still.membership == 1.0);
}

TEST_CASE("weights give the number of occurrences of each value") {
  using Times = std::vector<std::size_t>;
  // 14 L / sum L by hand: 14 * 3 / 28 = 1.5, 14 * 1 / 28 = 0.5, the rest 1.
  std::vector<double> weights(14, 2.0);
  weights[0] = 3.0;
  weights[1] = 1.0;
  Times expected(14, 1);
  expected[1] = 0;
  CHECK(appearances(weights) == expected);
  // One value has the whole weight.
  CHECK(appearances(std::vector<double>{0, 5, 0}) == Times{0, 3, 0});
  // Equal weights whose quotients are slightly below 1 by rounding.
  for (const double each : {0.1, 1.0 / 3.0, 7e-300, 1e300}) {
    CHECK(appearances(std::vector<double>(14, each)) == Times(14, 1));
  }
  CHECK(appearances(std::vector<double>(14, 0.0)) == Times(14, 1));
  CHECK_THROWS_AS(appearances(std::vector<double>{}), UsageError);
  CHECK_THROWS_AS(appearances(std::vector<double>{1, -1}), UsageError);
  CHECK_THROWS_AS(appearances(std::vector<double>{1, std::nan("")}), UsageError);
  Random random(6);
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<double> any(14);
    for (double& weight : any) weight = random.below(3) == 0 ? 0.0 : random.uniform();
    const Times times = appearances(any);
    const std::size_t sum = std::accumulate(times.begin(), times.end(), std::size_t{0});
    CHECK(sum >= 1);
    CHECK(sum <= 14);
  }
}

TEST_CASE("branches draw their angles from the values of the cloud") {
  Random random(7);
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<double> angles = cloud_angles({}, 14, random);
    REQUIRE(!angles.empty());
    REQUIRE(angles.size() <= 14);
    for (const double angle : angles) REQUIRE((angle >= 0.0 && angle <= 70.0));
  }
  CHECK_THROWS_AS(cloud_angles({}, 0, random), UsageError);
  CHECK_THROWS_AS(cloud_angles({.expectation = 80}, 14, random), UsageError);
  CHECK_THROWS_AS(cloud_angles({.entropy = -1}, 14, random), UsageError);
  CHECK_THROWS_AS(cloud_angles({.hyper_entropy = 71}, 14, random), UsageError);
}
