// SPDX-License-Identifier: MIT
// From the coordinates of a layer to meters.
#pragma once

#include <ogr_spatialref.h>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "silvafit/source/coordinate_system.hpp"

namespace silvafit::source {

/// The rectangle around the coordinates of a layer.
struct Extent {
  double low_x = 0.0;
  double low_y = 0.0;
  double high_x = 0.0;
  double high_y = 0.0;
};

/// A conversion of coordinates to meters.
class Conversion {
 public:
  /// \param source    of the layer; null if it has none
  /// \param extent    of its coordinates
  /// \param target    system to convert to; none: the layer's own, or the UTM zone of the center if
  ///                  that is geographic or distorts lengths by more than 1 %
  /// \param file      for messages
  /// \param may_be_assumed  the format prescribes geographic coordinates if no system is given, but
  ///                        many files contain others
  /// \throws InputError if the coordinates cannot be converted
  Conversion(const OGRSpatialReference* source,
             const Extent& extent,
             const std::optional<CoordinateSystem>& target,
             const std::string& file,
             bool may_be_assumed);

  /// The system of the result; none if it is not known.
  const std::optional<CoordinateSystem>& result() const { return result_; }
  const std::vector<std::string>& notes() const { return notes_; }

  /// Converts positions in place; NaN stays NaN.
  /// \throws InputError if one is outside of the system's area
  void apply(std::span<double> x, std::span<double> y) const;

 private:
  void convert_to(const CoordinateSystem& target);
  void choose_system();
  void project_to_utm(const std::string& reason);
  void keep_system();
  double length_distortion() const;
  void transform(std::span<double> x, std::span<double> y) const;

  std::string file_;
  Extent extent_;
  std::optional<OGRSpatialReference> source_{};
  std::unique_ptr<OGRCoordinateTransformation> transformation_{};
  double meters_per_unit_ = 1.0;
  std::optional<CoordinateSystem> result_{};
  std::vector<std::string> notes_{};
};

}  // namespace silvafit::source
