// SPDX-License-Identifier: MIT
// The position of the sun.
#pragma once

#include <string_view>

namespace silvafit::render {

/// A direction in the sky.
struct SunPosition {
  double azimuth_deg = 135.0;   ///< clockwise from north
  double elevation_deg = 45.0;  ///< above the horizon
};

/// A time in UTC.
struct Moment {
  int year = 2000;
  int month = 1;  ///< 1 to 12
  int day = 1;
  double hours = 12.0;  ///< since midnight, UTC; may leave [0, 24)
};

/// Reads `2023-06-21T15:00+08:00`; without a time it is noon, without an offset UTC.
/// \throws UsageError if the text is not a valid time
Moment parse_moment(std::string_view text);

/// The position of the sun, to about 0.02 degrees between 1950 and 2050, without refraction.
/// \param latitude_deg   north, in [-90, 90]
/// \param longitude_deg  east, in [-180, 180]
/// \throws UsageError if latitude or longitude is out of range
/// Source: Astronomical Almanac's low-precision formulas (Michalsky 1988, Solar Energy 40,
/// 227-235).
SunPosition sun_over(double latitude_deg, double longitude_deg, const Moment& moment);

}  // namespace silvafit::render
