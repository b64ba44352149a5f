// SPDX-License-Identifier: MIT
#include "gdal/conversion.hpp"

#include <cpl_conv.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "silvafit/base/error.hpp"

namespace silvafit::source {
namespace {

// Structural indices compare distances; 1 % is less than the error of measured positions.
constexpr double kLargestDistortion = 0.01;

std::string name_of(const OGRSpatialReference& system) {
  const char* const authority = system.GetAuthorityName(nullptr);
  const char* const code = system.GetAuthorityCode(nullptr);
  if (authority != nullptr && code != nullptr) return fmt::format("{}:{}", authority, code);
  const char* const name = system.GetName();
  return name == nullptr ? "an unnamed coordinate reference system" : name;
}

std::string wkt_of(const OGRSpatialReference& system) {
  char* text = nullptr;
  system.exportToWkt(&text);
  std::string wkt = text == nullptr ? "" : text;
  CPLFree(text);
  return wkt;
}

/// GeoPackages use systems of these names if the system is unknown.
bool is_known(const OGRSpatialReference& system) {
  const char* const name = system.GetName();
  return system.IsEmpty() == 0 && name != nullptr &&
         !std::string_view(name).starts_with("Undefined ");
}

/// x before y, east before north, whatever the order that the system's authority defines.
OGRSpatialReference with_x_first(OGRSpatialReference system) {
  system.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return system;
}

std::unique_ptr<OGRCoordinateTransformation> transformation(const OGRSpatialReference& from,
                                                            const OGRSpatialReference& to) {
  return std::unique_ptr<OGRCoordinateTransformation>(
      OGRCreateCoordinateTransformation(&from, &to));
}

/// The UTM zone, or the polar system, that contains a place.
int utm_code(double longitude, double latitude) {
  if (latitude > 84.0) return 32661;
  if (latitude < -80.0) return 32761;
  const int zone = std::clamp(static_cast<int>(std::floor((longitude + 180.0) / 6.0)) + 1, 1, 60);
  return (latitude < 0.0 ? 32700 : 32600) + zone;
}

}  // namespace

Conversion::Conversion(const OGRSpatialReference* source,
                       const Extent& extent,
                       const std::optional<CoordinateSystem>& target,
                       const std::string& file,
                       bool may_be_assumed)
    : file_(file), extent_(extent) {
  if (source != nullptr && is_known(*source)) source_ = with_x_first(*source);
  const bool exceeds_degrees = std::abs(extent.low_x) > 360.0 || std::abs(extent.high_x) > 360.0 ||
                               std::abs(extent.low_y) > 90.0 || std::abs(extent.high_y) > 90.0;
  if (source_ && source_->IsGeographic() && exceeds_degrees) {
    if (!may_be_assumed) {
      throw InputError(fmt::format("the coordinates {}, {} are not degrees, but the layer's "
                                   "coordinate reference system is {}; correct the system",
                                   extent.high_x,
                                   extent.high_y,
                                   name_of(*source_)),
                       {.file = file_});
    }
    source_.reset();
  }
  if (!source_) {
    notes_.emplace_back(
        target
            ? "the layer has no coordinate reference system; that of the trees is assumed"
            : "the layer has no coordinate reference system; its coordinates are used as meters");
    result_ = target;
    if (target) meters_per_unit_ = target->meters_per_unit;
    return;
  }
  target ? convert_to(*target) : choose_system();
}

void Conversion::convert_to(const CoordinateSystem& target) {
  OGRSpatialReference system;
  system.SetFromUserInput(target.wkt.c_str());
  system = with_x_first(system);
  meters_per_unit_ = target.meters_per_unit;
  result_ = target;
  if (source_->IsSame(&system) != 0) return;
  transformation_ = transformation(*source_, system);
  if (!transformation_) {
    throw InputError(
        fmt::format("coordinates in {} cannot be converted to {}", name_of(*source_), target.name),
        {.file = file_});
  }
  notes_.push_back(
      fmt::format("coordinates are converted from {} to {}", name_of(*source_), target.name));
}

void Conversion::choose_system() {
  if (source_->IsGeographic()) return project_to_utm("longitude and latitude");
  if (!source_->IsProjected() && !source_->IsLocal()) {
    throw InputError(fmt::format("the coordinate reference system {} has no plane coordinates; "
                                 "export the layer in a projected system, such as a UTM zone",
                                 name_of(*source_)),
                     {.file = file_});
  }
  if (source_->IsProjected()) {
    const double distortion = length_distortion();
    if (distortion > kLargestDistortion) {
      return project_to_utm(fmt::format(
          "{}, which changes lengths by {:.0f} % there,", name_of(*source_), 100.0 * distortion));
    }
  }
  keep_system();
}

void Conversion::keep_system() {
  const char* unit = nullptr;
  meters_per_unit_ = source_->GetLinearUnits(&unit);
  result_ = {
      .wkt = wkt_of(*source_), .name = name_of(*source_), .meters_per_unit = meters_per_unit_};
  if (std::abs(meters_per_unit_ - 1.0) < 1e-12) return;
  notes_.push_back(
      fmt::format("coordinates are converted to m from the unit of {}: {}", result_->name, unit));
}

/// Relative difference of a length of 1 km at the center from that on the ellipsoid.
double Conversion::length_distortion() const {
  OGRSpatialReference geographic;
  geographic.CopyGeogCSFrom(&*source_);
  geographic = with_x_first(geographic);
  const auto to_degrees = transformation(*source_, geographic);
  if (!to_degrees) return 0.0;
  const double unit = source_->GetLinearUnits();
  const double step = 1000.0 / unit;
  const double center_x = 0.5 * (extent_.low_x + extent_.high_x);
  const double center_y = 0.5 * (extent_.low_y + extent_.high_y);
  std::array<double, 3> x{center_x, center_x + step, center_x};
  std::array<double, 3> y{center_y, center_y, center_y + step};
  if (to_degrees->Transform(3, x.data(), y.data()) == FALSE) return 0.0;
  constexpr double kRadians = std::numbers::pi / 180.0;
  const double sine = std::sin(y[0] * kRadians);
  const double flattening = source_->GetInvFlattening();
  const double f = flattening == 0.0 ? 0.0 : 1.0 / flattening;
  const double e2 = f * (2.0 - f);
  const double n = source_->GetSemiMajor() / std::sqrt(1.0 - e2 * sine * sine);
  const double m = n * (1.0 - e2) / (1.0 - e2 * sine * sine);
  double largest = 0.0;
  for (std::size_t i = 1; i < 3; ++i) {
    const double east = n * std::cos(y[0] * kRadians) * (x[i] - x[0]) * kRadians;
    const double north = m * (y[i] - y[0]) * kRadians;
    largest = std::max(largest, std::abs(1000.0 / std::hypot(east, north) - 1.0));
  }
  return largest;
}

void Conversion::project_to_utm(const std::string& reason) {
  OGRSpatialReference geographic;
  geographic.SetWellKnownGeogCS("WGS84");
  geographic = with_x_first(geographic);
  double longitude = 0.5 * (extent_.low_x + extent_.high_x);
  double latitude = 0.5 * (extent_.low_y + extent_.high_y);
  const auto to_degrees = transformation(*source_, geographic);
  OGRSpatialReference utm;
  const bool is_placed =
      to_degrees && to_degrees->Transform(1, &longitude, &latitude) != FALSE &&
      utm.importFromEPSG(utm_code(std::remainder(longitude, 360.0), latitude)) == OGRERR_NONE;
  utm = with_x_first(utm);
  if (is_placed) transformation_ = transformation(*source_, utm);
  if (!transformation_) {
    throw InputError(
        fmt::format("coordinates in {} cannot be projected; export the layer in a projected "
                    "system in meters, such as a UTM zone",
                    name_of(*source_)),
        {.file = file_});
  }
  result_ = {.wkt = wkt_of(utm), .name = name_of(utm), .meters_per_unit = 1.0};
  notes_.push_back(fmt::format(
      "coordinates in {} are projected to {} ({})", reason, result_->name, utm.GetName()));
}

void Conversion::transform(std::span<double> x, std::span<double> y) const {
  std::vector<std::size_t> known;
  std::vector<double> known_x;
  std::vector<double> known_y;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (std::isnan(x[i]) || std::isnan(y[i])) continue;
    known.push_back(i);
    known_x.push_back(x[i]);
    known_y.push_back(y[i]);
  }
  std::vector<int> succeeded(known.size(), TRUE);
  transformation_->Transform(
      static_cast<int>(known.size()), known_x.data(), known_y.data(), nullptr, succeeded.data());
  for (std::size_t k = 0; k < known.size(); ++k) {
    if (succeeded[k] == FALSE || !std::isfinite(known_x[k]) || !std::isfinite(known_y[k])) {
      throw InputError(fmt::format("the position {}, {} cannot be converted from {} to {}; check "
                                   "it, and the coordinate reference system of the layer",
                                   x[known[k]],
                                   y[known[k]],
                                   name_of(*source_),
                                   result_->name),
                       {.file = file_, .line = known[k] + 1});
    }
    x[known[k]] = known_x[k];
    y[known[k]] = known_y[k];
  }
}

void Conversion::apply(std::span<double> x, std::span<double> y) const {
  if (transformation_) transform(x, y);
  if (meters_per_unit_ == 1.0) return;
  for (double& value : x) value *= meters_per_unit_;
  for (double& value : y) value *= meters_per_unit_;
}

}  // namespace silvafit::source
