// SPDX-License-Identifier: MIT
#include "study/final_residuals.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

using namespace silvafit::study;
using Catch::Matchers::WithinRel;
using Eigen::Index;

namespace {

/// Two plots of 12 x 12 trees, 2 m apart, whose residuals vary smoothly.
PlacedResiduals smooth_residuals() {
  constexpr Index kSide = 12;
  PlacedResiduals placed;
  placed.residuals.resize(2 * kSide * kSide);
  placed.positions_m.resize(placed.residuals.size(), 2);
  for (Index i = 0; i < placed.residuals.size(); ++i) {
    const Index plot = i / (kSide * kSide);
    const double number = static_cast<double>(plot) + 1.0;
    const double x = 2.0 * static_cast<double>(i % kSide) + 0.3 * number;
    const double y = 2.0 * static_cast<double>(i / kSide % kSide);
    placed.positions_m.row(i) << x, y;
    placed.residuals[i] = std::sin(x / 3.0 + number) + 0.4 * std::cos(y);
    if (i % (kSide * kSide) == 0) placed.plots.emplace_back();
    placed.plots.back().push_back(i);
  }
  return placed;
}

}  // namespace

// R 4.2.2, nlme 3.1-162: d <- expand.grid(i = 0:11, j = 0:11, plot = 1:2); x = 2*i + 0.3*plot;
// y = 2*j; r = sin(x/3 + plot) + 0.4*cos(y); Variogram(r, dist(cbind(x, y))) of each plot, the
// pairs of both averaged in classes of sqrt(2)*22/20 m. The first class has no pair.
TEST_CASE("the variogram of residuals is nlme's in classes of distance") {
  const std::vector<VariogramClass> expected{{2.39620427705253, 0.161169762994923, 1012},
                                             {4.30549973558796, 0.332664343484969, 1360},
                                             {5.83502608148672, 0.438097869703363, 832},
                                             {6.74672066823734, 0.540267999755453, 1512},
                                             {8.45560326926044, 0.677639993054061, 2052},
                                             {10.2650271191269, 0.780818281647778, 2088},
                                             {11.8358541356212, 0.738403871928948, 1576},
                                             {13.1029128887141, 0.781866070738818, 1600},
                                             {14.5168368334, 0.696088322991935, 1780}};
  const std::vector<VariogramClass> found = residual_variogram(smooth_residuals());
  REQUIRE(found.size() == expected.size());
  constexpr double kRounding = 1e-12;  // 15 digits of R, sums of up to 2,088 pairs
  for (std::size_t k = 0; k < found.size(); ++k) {
    CAPTURE(k);
    CHECK_THAT(found[k].distance_m, WithinRel(expected[k].distance_m, kRounding));
    CHECK_THAT(found[k].semivariance, WithinRel(expected[k].semivariance, kRounding));
    CHECK(found[k].pairs == expected[k].pairs);
  }
}

TEST_CASE("classes of fewer than 30 pairs are left out of a variogram") {
  PlacedResiduals placed = smooth_residuals();
  placed.plots = {{0, 1, 2, 12, 13, 14}};  // 15 pairs
  CHECK(residual_variogram(placed).empty());
  placed.plots.clear();
  CHECK(residual_variogram(placed).empty());
}
