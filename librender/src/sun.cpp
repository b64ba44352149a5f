// SPDX-License-Identifier: MIT
#include "silvafit/render/sun.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::render {
namespace {

/// The angle in [0, 360).
double turned(double degrees) {
  const double rest = std::fmod(degrees, 360.0);
  return rest < 0.0 ? rest + 360.0 : rest;
}

/// Days since noon of 1 January 2000.
double days_since_2000(const Moment& moment) {
  using namespace std::chrono;
  const sys_days date{year(moment.year) / month(static_cast<unsigned>(moment.month)) /
                      day(static_cast<unsigned>(moment.day))};
  const sys_days epoch{year(2000) / January / 1};
  constexpr double kHoursPerDay = 24.0;
  return static_cast<double>((date - epoch).count()) - 0.5 + moment.hours / kHoursPerDay;
}

[[noreturn]] void refuse(std::string_view text) {
  throw UsageError("'" + std::string(text) +
                   "' is not a date; write it as 2023-06-21 or 2023-06-21T15:00+08:00");
}

/// Reads `15:00` at a position of the text; false if there is no such time.
bool read_time(const std::string& text, std::size_t begin, double& hours) {
  int hour = 0;
  int minute = 0;
  if (std::sscanf(text.c_str() + begin, "%2d:%2d", &hour, &minute) != 2) return false;
  if (hour < 0 || hour > 24 || minute < 0 || minute > 59) return false;
  hours = hour + minute / 60.0;
  return true;
}

}  // namespace

Moment parse_moment(std::string_view source) {
  const std::string text(source);
  Moment moment;
  int length = 0;
  if (std::sscanf(
          text.c_str(), "%4d-%2d-%2d%n", &moment.year, &moment.month, &moment.day, &length) != 3) {
    refuse(source);
  }
  const std::chrono::year_month_day date{std::chrono::year(moment.year),
                                         std::chrono::month(static_cast<unsigned>(moment.month)),
                                         std::chrono::day(static_cast<unsigned>(moment.day))};
  if (!date.ok()) refuse(source);
  auto place = static_cast<std::size_t>(length);
  constexpr std::size_t kTimeLength = 5;  // 15:00
  if (place < text.size()) {
    if (text[place] != 'T' || !read_time(text, place + 1, moment.hours)) refuse(source);
    place += 1 + kTimeLength;
  }
  if (place < text.size() && text[place] == 'Z') ++place;
  if (place < text.size() && (text[place] == '+' || text[place] == '-')) {
    double zone = 0.0;
    if (!read_time(text, place + 1, zone)) refuse(source);
    moment.hours += text[place] == '+' ? -zone : zone;
    place += 1 + kTimeLength;
  }
  if (place != text.size()) refuse(source);
  return moment;
}

SunPosition sun_over(double latitude_deg, double longitude_deg, const Moment& moment) {
  if (!(std::abs(latitude_deg) <= 90.0) || !(std::abs(longitude_deg) <= 180.0)) {
    throw UsageError(
        "the latitude must be between -90 and 90 degrees and the longitude between -180 and 180");
  }
  const double days = days_since_2000(moment);
  const double mean_longitude = turned(280.460 + 0.9856474 * days);
  const double anomaly = kRadian * turned(357.528 + 0.9856003 * days);
  const double longitude =
      kRadian * (mean_longitude + 1.915 * std::sin(anomaly) + 0.020 * std::sin(2.0 * anomaly));
  const double obliquity = kRadian * (23.439 - 4.0e-7 * days);
  const double ascension =
      std::atan2(std::cos(obliquity) * std::sin(longitude), std::cos(longitude));
  const double declination = std::asin(std::sin(obliquity) * std::sin(longitude));

  const double sidereal_deg = turned(280.46061837 + 360.98564736629 * days);
  const double hour_angle = kRadian * (sidereal_deg + longitude_deg) - ascension;
  const double latitude = kRadian * latitude_deg;
  const double up = std::sin(latitude) * std::sin(declination) +
                    std::cos(latitude) * std::cos(declination) * std::cos(hour_angle);
  const double east = -std::cos(declination) * std::sin(hour_angle);
  const double north = std::cos(latitude) * std::sin(declination) -
                       std::sin(latitude) * std::cos(declination) * std::cos(hour_angle);
  return {.azimuth_deg = turned(std::atan2(east, north) / kRadian),
          .elevation_deg = std::asin(std::min(1.0, std::max(-1.0, up))) / kRadian};
}

}  // namespace silvafit::render
