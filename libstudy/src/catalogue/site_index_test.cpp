// SPDX-License-Identifier: MIT
#include "silvafit/study/site_index.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "reference.hpp"
#include "silvafit/base/error.hpp"

using namespace silvafit;
using Catch::Matchers::Contains;

TEST_CASE("site curves give the site indices of other programs") {
  // Heights by the R package forester (Elfving and Kiviste) and the R code of the Nuoro Forestry
  // School (Maetzke and Nocentini), printed with 10 to 12 digits.
  const auto curves = study::load_site_curves(test::source_file("models"));
  REQUIRE(curves.size() >= 2);
  for (const study::SiteCurve& curve : curves) {
    INFO(curve.id);
    REQUIRE_FALSE(curve.reference_points.empty());
    for (const auto& [h, age, expected] : curve.reference_points) {
      CHECK(curve.site_index(h, age) == Approx(expected).epsilon(1e-9));
    }
    // A curve passes through its height.
    CHECK(curve.height_at(40.0, 18.0, 40.0) == Approx(18.0).epsilon(1e-12));
    CHECK(std::isnan(curve.site_index(NAN, 40.0)));
  }
  CHECK_THROWS_WITH(study::site_curve(curves, "pine"),
                    Contains("elfving-kiviste-1997 (Scots pine"));
}
