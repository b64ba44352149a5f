// SPDX-License-Identifier: MIT
// Where the sun stands.
#pragma once

#include <string_view>

namespace silvafit::render {

/// A direction in the sky.
struct SunPosition {
  double azimuth_deg = 135.0;   ///< clockwise from north
  double elevation_deg = 45.0;  ///< above the horizon
};

/// A moment in universal time.
struct Moment {
  int year = 2000;
  int month = 1;  ///< 1 to 12
  int day = 1;
  double hours = 12.0;  ///< since midnight, UTC; may leave [0, 24)
};

/// Reads `2023-06-21T15:00+08:00`; without a time it is noon, without a zone UTC.
/// \throws UsageError if the text is no such moment
Moment parse_moment(std::string_view text);

/// The sun over a place, to about 0.02 degrees between 1950 and 2050, without refraction.
/// \param latitude_deg   north, in [-90, 90]
/// \param longitude_deg  east, in [-180, 180]
/// \throws UsageError if the place is not on earth
/// Source: Astronomical Almanac's low-precision formulas (Michalsky 1988, Solar Energy 40,
/// 227-235).
SunPosition sun_over(double latitude_deg, double longitude_deg, const Moment& moment);

}  // namespace silvafit::render
