// SPDX-License-Identifier: MIT
// The geometries of a layer's rows, as its columns are read.
#pragma once

#include <ogr_geometry.h>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gdal/conversion.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::source {

/// Positions of points; other geometries are only counted.
class PointCollector {
 public:
  void add(std::span<const unsigned char> wkb);

  bool has_points() const { return points_ > 0; }
  bool has_elevations() const { return has_elevations_; }
  /// The first row whose geometry is not a point, from 1.
  std::optional<std::size_t> first_other() const { return first_other_; }
  /// The type of that geometry: polygon, line, ...
  const std::string& other_kind() const { return other_kind_; }
  Extent extent() const;

  std::vector<double> x{};
  std::vector<double> y{};
  std::vector<double> z{};

 private:
  std::size_t points_ = 0;
  bool has_elevations_ = false;
  std::optional<std::size_t> first_other_{};
  std::string other_kind_{};
};

/// Polygons and, for circles, points.
class AreaCollector {
 public:
  /// \throws InputError if the geometry is neither
  void add(std::span<const unsigned char> wkb, const std::string& file);

  Extent extent() const;
  bool has_polygons() const { return polygons_ > 0; }
  bool has_points() const { return points_ > 0; }
  /// Converts all positions.
  void convert(const Conversion& conversion, const std::string& file);
  /// Well-known text of each row's polygons.
  data::TextColumn wkt() const;

  std::vector<double> x{};  ///< of points
  std::vector<double> y{};

 private:
  std::vector<std::unique_ptr<OGRGeometry>> geometries_{};  ///< null where missing
  std::size_t polygons_ = 0;
  std::size_t points_ = 0;
};

}  // namespace silvafit::source
