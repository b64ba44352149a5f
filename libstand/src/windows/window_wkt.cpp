// SPDX-License-Identifier: MIT
// Windows in well-known text (OGC 06-103r4), read by Boost.Geometry.
#include <fmt/format.h>

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/multi_polygon.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <cctype>
#include <string>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "windows/window_files.hpp"

namespace silvafit::stand {
namespace {

namespace bg = boost::geometry;
using BoostPoint = bg::model::d2::point_xy<double>;
using BoostPolygon = bg::model::polygon<BoostPoint>;
using BoostRegion = bg::model::multi_polygon<BoostPolygon>;

/// The word before the coordinates, in capitals.
std::string kind_of(std::string_view text) {
  std::string kind;
  for (const unsigned char c : text) {
    if (std::isalpha(c) == 0) break;
    kind += static_cast<char>(std::toupper(c));
  }
  return kind;
}

/// Without the prefix `SRID=32633;` of PostGIS.
std::string_view without_reference_system(std::string_view text) {
  if (kind_of(text) != "SRID") return text;
  const std::size_t end = text.find(';');
  return end == std::string_view::npos ? text : data::trimmed(text.substr(end + 1));
}

std::vector<Point> corners_of(const BoostPolygon::ring_type& ring) {
  std::vector<Point> corners;
  for (const BoostPoint& point : ring) corners.push_back({point.x(), point.y()});
  return corners;
}

Polygon polygon_of(const BoostPolygon& source) {
  Polygon polygon{.outer = corners_of(source.outer())};
  for (const auto& hole : source.inners()) polygon.holes.push_back(corners_of(hole));
  return polygon;
}

/// A geometry of a file, and the line on which it begins.
struct Entry {
  std::string text{};
  std::size_t line = 0;
};

/// Geometries begin with a word at the start of a line; they may run over several.
std::vector<Entry> entries_of(const std::string& text) {
  std::vector<Entry> entries;
  std::size_t line = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view content = data::trimmed(std::string_view(text).substr(begin, end - begin));
    if (content.ends_with('\r')) content = data::trimmed(content.substr(0, content.size() - 1));
    ++line;
    begin = end + 1;
    if (content.empty()) continue;
    if (entries.empty() || std::isalpha(static_cast<unsigned char>(content.front())) != 0) {
      entries.push_back({.text = std::string(content), .line = line});
    } else {
      entries.back().text += ' ';
      entries.back().text += content;
    }
  }
  return entries;
}

}  // namespace

std::vector<Polygon> polygons_of_wkt(std::string_view text) {
  const std::string geometry(without_reference_system(data::trimmed(text)));
  const std::string kind = kind_of(geometry);
  BoostRegion region;
  try {
    if (kind == "POLYGON") {
      region.resize(1);
      bg::read_wkt(geometry, region.front());
    } else if (kind == "MULTIPOLYGON") {
      bg::read_wkt(geometry, region);
    } else {
      throw GeometryError(fmt::format("expected a POLYGON or MULTIPOLYGON{}",
                                      kind.empty() ? "" : fmt::format(", not a {}", kind)));
    }
  } catch (const bg::read_wkt_exception&) {
    throw GeometryError(
        fmt::format("not a {} with two coordinates per vertex: {:.40}...", kind, geometry));
  }
  std::vector<Polygon> polygons;
  for (const BoostPolygon& polygon : region) polygons.push_back(polygon_of(polygon));
  return polygons;
}

std::vector<NamedWindow> read_wkt_windows(const std::filesystem::path& path) {
  WindowCollector collector;
  for (const Entry& entry : entries_of(text_of(path))) {
    try {
      collector.add(std::nullopt, polygons_of_wkt(entry.text));
    } catch (const GeometryError& error) {
      throw InputError(error.message(), {.file = path.string(), .line = entry.line});
    }
  }
  return collector.windows(path.string());
}

}  // namespace silvafit::stand
