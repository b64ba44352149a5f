// SPDX-License-Identifier: MIT
#include "gdal/geometries.hpp"

#include <cpl_conv.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gdal/session.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::source {
namespace {

std::unique_ptr<OGRGeometry> geometry_of(std::span<const unsigned char> wkb) {
  const KeptMessages no_messages;
  OGRGeometry* made = nullptr;
  OGRGeometryFactory::createFromWkb(wkb.data(), nullptr, &made, wkb.size());
  return std::unique_ptr<OGRGeometry>(made);
}

std::string kind_name(const OGRGeometry& geometry) {
  switch (wkbFlatten(geometry.getGeometryType())) {
    case wkbLineString:
    case wkbMultiLineString:
      return "a line";
    case wkbPolygon:
    case wkbMultiPolygon:
    case wkbCurvePolygon:
    case wkbMultiSurface:
      return "a polygon";
    case wkbMultiPoint:
      return "several points";
    default:
      return "another geometry";
  }
}

void extend(Extent& extent, bool& is_first, double x, double y) {
  if (std::isnan(x) || std::isnan(y)) return;
  if (is_first) extent = {.low_x = x, .low_y = y, .high_x = x, .high_y = y};
  is_first = false;
  extent.low_x = std::min(extent.low_x, x);
  extent.low_y = std::min(extent.low_y, y);
  extent.high_x = std::max(extent.high_x, x);
  extent.high_y = std::max(extent.high_y, y);
}

template <typename Action>
void for_each_ring(OGRGeometry& geometry, const Action& action) {
  if (wkbFlatten(geometry.getGeometryType()) == wkbPolygon) {
    for (auto* const ring : *geometry.toPolygon()) action(*ring);
    return;
  }
  for (auto* const polygon : *geometry.toMultiPolygon()) {
    for (auto* const ring : *polygon) action(*ring);
  }
}

}  // namespace

void PointCollector::add(std::span<const unsigned char> wkb) {
  x.push_back(data::kMissing);
  y.push_back(data::kMissing);
  z.push_back(data::kMissing);
  if (wkb.empty()) return;
  std::unique_ptr<OGRGeometry> geometry = geometry_of(wkb);
  const OGRPoint* point = nullptr;
  if (geometry && wkbFlatten(geometry->getGeometryType()) == wkbPoint) {
    point = geometry->toPoint();
  } else if (geometry && wkbFlatten(geometry->getGeometryType()) == wkbMultiPoint) {
    const OGRMultiPoint& points = *geometry->toMultiPoint();
    if (points.getNumGeometries() == 1) point = points.getGeometryRef(0);
  }
  if (point == nullptr) {
    if (first_other_) return;
    first_other_ = x.size();
    other_kind_ = geometry ? kind_name(*geometry) : "damaged";
    return;
  }
  ++points_;
  if (point->IsEmpty() != FALSE) return;
  x.back() = point->getX();
  y.back() = point->getY();
  if (point->Is3D() == FALSE || std::isnan(point->getZ())) return;
  z.back() = point->getZ();
  // Programs write 0 if the elevation is unknown.
  has_elevations_ = has_elevations_ || z.back() != 0.0;
}

Extent PointCollector::extent() const {
  Extent extent;
  bool is_first = true;
  for (std::size_t i = 0; i < x.size(); ++i) extend(extent, is_first, x[i], y[i]);
  return extent;
}

void AreaCollector::add(std::span<const unsigned char> wkb, const std::string& file) {
  x.push_back(data::kMissing);
  y.push_back(data::kMissing);
  geometries_.emplace_back();
  if (wkb.empty()) return;
  std::unique_ptr<OGRGeometry> geometry = geometry_of(wkb);
  // Arcs become lines, each over an angle of 1 degree.
  if (geometry && geometry->hasCurveGeometry() != FALSE) {
    geometry.reset(geometry->getLinearGeometry(1.0));
  }
  const OGRwkbGeometryType type = geometry ? wkbFlatten(geometry->getGeometryType()) : wkbUnknown;
  if (geometry && geometry->IsEmpty() != FALSE) return;
  if (type == wkbPoint) {
    x.back() = geometry->toPoint()->getX();
    y.back() = geometry->toPoint()->getY();
    ++points_;
    return;
  }
  if (type != wkbPolygon && type != wkbMultiPolygon) {
    throw InputError("the geometry is not a polygon; keep only polygons in the layer of windows",
                     {.file = file, .line = geometries_.size()});
  }
  geometry->flattenTo2D();
  geometries_.back() = std::move(geometry);
  ++polygons_;
}

Extent AreaCollector::extent() const {
  Extent extent;
  bool is_first = true;
  for (std::size_t i = 0; i < geometries_.size(); ++i) {
    extend(extent, is_first, x[i], y[i]);
    if (!geometries_[i]) continue;
    OGREnvelope box;
    geometries_[i]->getEnvelope(&box);
    extend(extent, is_first, box.MinX, box.MinY);
    extend(extent, is_first, box.MaxX, box.MaxY);
  }
  return extent;
}

void AreaCollector::convert(const Conversion& conversion, const std::string& file) {
  conversion.apply(x, y);
  std::vector<double> ring_x;
  std::vector<double> ring_y;
  for (std::size_t row = 0; row < geometries_.size(); ++row) {
    if (!geometries_[row]) continue;
    for_each_ring(*geometries_[row], [&](OGRLinearRing& ring) {
      ring_x.clear();
      ring_y.clear();
      for (int i = 0; i < ring.getNumPoints(); ++i) {
        ring_x.push_back(ring.getX(i));
        ring_y.push_back(ring.getY(i));
      }
      try {
        conversion.apply(ring_x, ring_y);
      } catch (const InputError& error) {
        throw InputError(error.message(), {.file = file, .line = row + 1});
      }
      for (int i = 0; i < ring.getNumPoints(); ++i) {
        const auto k = static_cast<std::size_t>(i);
        ring.setPoint(i, ring_x[k], ring_y[k]);
      }
    });
  }
}

data::TextColumn AreaCollector::wkt() const {
  data::TextColumn texts;
  for (const auto& geometry : geometries_) {
    if (!geometry) {
      texts.append_missing();
      continue;
    }
    char* text = nullptr;
    geometry->exportToWkt(&text, wkbVariantIso);
    texts.append(text == nullptr ? "" : text);
    CPLFree(text);
  }
  return texts;
}

}  // namespace silvafit::source
