// SPDX-License-Identifier: MIT
// Reading windows from common file formats.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/stand/window.hpp"

namespace silvafit::stand {

/// Collects the windows of a file by plot.
class WindowCollector {
 public:
  /// Polygons of one plot are combined.
  /// \throws GeometryError if one is not valid, or the plot has a circle
  void add(const std::optional<std::string>& plot, const std::vector<Polygon>& polygons);
  /// \throws GeometryError if the plot already has a window
  void add_circle(const std::optional<std::string>& plot, Point center, double radius_m);

  /// \throws InputError if there is none
  std::vector<NamedWindow> windows(const std::string& file) const;

 private:
  struct Owner {
    std::optional<std::string> plot{};
    std::vector<Polygon> polygons{};
    std::optional<Window> circle{};
  };
  Owner& owner(const std::optional<std::string>& plot);

  std::vector<Owner> owners_{};
  std::map<std::optional<std::string>, std::size_t> number_of_{};
};

/// The text of a file without its byte order mark.
std::string text_of(const std::filesystem::path& path);

/// Polygons of a POLYGON or MULTIPOLYGON in well-known text.
/// \throws GeometryError if the text is not such a polygon, or not valid
std::vector<Polygon> polygons_of_wkt(std::string_view text);

std::vector<NamedWindow> read_geojson_windows(const std::filesystem::path& path);
std::vector<NamedWindow> read_wkt_windows(const std::filesystem::path& path);
std::vector<NamedWindow> read_csv_windows(const std::filesystem::path& path);

}  // namespace silvafit::stand
