// SPDX-License-Identifier: MIT

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "segments/branch_plan.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

const Preset& chinese_fir() { return test::shipped_presets().named("cunninghamia-lanceolata"); }

std::vector<Whorl> whorls_of(const Morphology& morphology, std::uint64_t seed = 1) {
  const TreeShape shape = complete(morphology, 0.35, "");
  Random random(seed);
  std::vector<Note> notes;
  return plan_whorls(shape, chinese_fir(), 4, random, notes);
}

Morphology fir_of_age(double age_years, double h_m, double hcb_m) {
  return {.plot = "1",
          .tree = "1",
          .dbh_cm = 15.0,
          .h_m = h_m,
          .hcb_m = hcb_m,
          .cw_m = 3.5,
          .age_years = age_years};
}

int total(const std::vector<Whorl>& whorls) {
  int sum = 0;
  for (const Whorl& whorl : whorls) sum += whorl.branches;
  return sum;
}

}  // namespace

// y1 - y2 = -2.1153 x^2 + 36.8339 x - 73.342: 58.0 at 5, 83.5 at 10, 67.7 at 12 years, by hand.
// Four of them are the branches at the measured radii.
TEST_CASE("a tree of known age has the published number of living branches") {
  CHECK(total(whorls_of(fir_of_age(5, 5.0, 0.5))) == 58 - 4);
  CHECK(total(whorls_of(fir_of_age(10, 10.0, 2.0))) == 83 - 4);
  CHECK(total(whorls_of(fir_of_age(12, 12.0, 4.0))) == 64 - 4);
}

TEST_CASE("each year's shoot bears 3 to 5 whorls, spread along it from its base up") {
  // Ten years of 1 m each; the crown begins at the base of the third year's shoot.
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::vector<Whorl> whorls = whorls_of(fir_of_age(10, 10.0, 2.0), seed);
    std::map<int, std::vector<double>> by_year;
    for (const Whorl& whorl : whorls) {
      by_year[static_cast<int>(whorl.base_m + 1e-9)].push_back(whorl.base_m);
      CHECK(whorl.branches >= 1);
      CHECK(whorl.branches <= 5);
    }
    CHECK(by_year.size() == 8);
    for (const auto& [year, heights] : by_year) {
      CHECK(heights.size() >= 3);
      CHECK(heights.size() <= 5);
      for (std::size_t i = 0; i < heights.size(); ++i) {
        const double share = static_cast<double>(i) / static_cast<double>(heights.size());
        CHECK(heights[i] == Approx(year + share).margin(1e-9));
      }
    }
  }
}

TEST_CASE("shoots too short for their whorls have them closer, and all stay in the crown") {
  const std::vector<Whorl> whorls = whorls_of(fir_of_age(15, 1.5, 0.3));
  CHECK(whorls.front().base_m == 0.3);
  for (std::size_t i = 1; i < whorls.size(); ++i) {
    CHECK(whorls[i].base_m > whorls[i - 1].base_m);
    CHECK(whorls[i].base_m < 1.5);
  }
}

TEST_CASE("the lowest whorl is at the crown base for any age") {
  for (const double hcb : {0.0, 3.3, 7.77, 9.99}) {
    CHECK(whorls_of(fir_of_age(9, 10.0, hcb)).front().base_m == hcb);
  }
  Morphology unknown = fir_of_age(1, 10.0, 3.3);
  unknown.age_years.reset();
  CHECK(whorls_of(unknown).front().base_m == 3.3);
}

TEST_CASE("a note states the age used for a tree younger or older than the equations") {
  for (const double age : {0.4, 1.0, 40.0, 3000.0}) {
    const TreeShape shape = complete(fir_of_age(age, 10.0, 2.0), 0.35, "");
    Random random(1);
    std::vector<Note> notes;
    const std::vector<Whorl> whorls = plan_whorls(shape, chinese_fir(), 4, random, notes);
    CHECK(total(whorls) >= chinese_fir().branching.least - 4);
    REQUIRE(!notes.empty());
    CHECK(notes.front().about == "branch_count");
  }
}

// A normal cut off at two standard deviations keeps the share erf(2 / sqrt 2) = 0.9545 of its
// probability and has 0.7737 of its variance (Johnson, Kotz and Balakrishnan 1994, 13.10.1:
// 1 - 2 z phi(z) / (2 Phi(z) - 1) at z = 2).
TEST_CASE("angles follow a normal distribution that is cut off at the interval's ends") {
  Random random(5);
  constexpr int kDraws = 200000;
  double sum = 0.0;
  double squares = 0.0;
  int inner = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double degrees = drawn_angle(random, 70.0, 90.0) * 180.0 / M_PI;
    REQUIRE(degrees >= 70.0 - 1e-9);
    REQUIRE(degrees <= 90.0 + 1e-9);
    sum += degrees;
    squares += (degrees - 80.0) * (degrees - 80.0);
    inner += std::abs(degrees - 80.0) < 5.0 ? 1 : 0;
  }
  // Four standard errors: 4.4 / sqrt(200000) of the mean, and so on.
  CHECK(sum / kDraws == Approx(80.0).margin(0.04));
  CHECK(squares / kDraws == Approx(0.7737 * 25.0).margin(0.25));
  CHECK(inner / static_cast<double>(kDraws) == Approx(0.6827 / 0.9545).margin(0.0041));
}
