// SPDX-License-Identifier: MIT
#include "silvafit/render/sun.hpp"

#include <catch2/catch.hpp>

#include "silvafit/base/error.hpp"

using namespace silvafit;
using namespace silvafit::render;

TEST_CASE("the position of the sun is that of the solar position algorithm") {
  // The example of Reda and Andreas 2004 (Solar Energy 76, 577-589), table A5.1: elevation without
  // refraction and azimuth. 0.02 degrees are what the low-precision formulas promise.
  const SunPosition sun =
      sun_over(39.742476,
               -105.1786,
               {.year = 2003, .month = 10, .day = 17, .hours = 12.5 + 30.0 / 3600 + 7});
  CHECK(sun.elevation_deg == Approx(39.872046).margin(0.02));
  CHECK(sun.azimuth_deg == Approx(194.340241).margin(0.02));
}

TEST_CASE("the elevation of the sun at solar noon follows the season") {
  // Culmination: 90 - latitude + declination; 23.44 degrees at the solstices (they fall within
  // hours of these dates, when the declination hardly changes).
  const auto highest = [](int month, int day, double latitude) {
    double best = -90.0;
    for (double hours = 10.0; hours < 14.0; hours += 0.01) {
      best = std::max(
          best,
          sun_over(latitude, 0.0, {.year = 2023, .month = month, .day = day, .hours = hours})
              .elevation_deg);
    }
    return best;
  };
  CHECK(highest(6, 21, 28.0) == Approx(90.0 - 28.0 + 23.44).margin(0.02));
  CHECK(highest(12, 22, 28.0) == Approx(90.0 - 28.0 - 23.44).margin(0.02));
  // South of the equator the sun culminates in the north.
  const SunPosition south =
      sun_over(-35.0, 0.0, {.year = 2023, .month = 6, .day = 21, .hours = 12.0});
  CHECK(std::abs(std::remainder(south.azimuth_deg, 360.0)) < 2.0);
}

TEST_CASE("a moment has a date, and may have a time and a zone") {
  const Moment full = parse_moment("2023-06-21T15:30+08:00");
  CHECK(full.year == 2023);
  CHECK(full.month == 6);
  CHECK(full.day == 21);
  CHECK(full.hours == 7.5);
  CHECK(parse_moment("2023-06-21").hours == 12.0);
  CHECK(parse_moment("2023-06-21T03:00Z").hours == 3.0);
  CHECK(parse_moment("2023-06-21T03:00-05:00").hours == 8.0);
  for (const char* bad : {"",
                          "2023",
                          "2023-13-01",
                          "2023-02-30",
                          "2023-06-21 15:00",
                          "2023-06-21T25:00",
                          "2023-06-21T15:00+",
                          "2023-06-21x"}) {
    INFO(bad);
    CHECK_THROWS_AS(parse_moment(bad), UsageError);
  }
  CHECK_THROWS_AS(sun_over(91.0, 0.0, {}), UsageError);
}
