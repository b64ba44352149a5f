// SPDX-License-Identifier: MIT
#include "silvafit/source/open_table.hpp"

#include <cpl_conv.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ogr_geometry.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gdal/arrow_columns.hpp"
#include "gdal/conversion.hpp"
#include "gdal/dataset.hpp"
#include "gdal/functions.hpp"
#include "gdal/session.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/table.hpp"
#include "workbook/sheet_text.hpp"

namespace silvafit::source {
namespace {

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

/// The name of the column of row ids, if users created it, such as the primary key `tree`.
std::string row_id_of(OGRLayer& layer) {
  const std::string name = layer.GetFIDColumn();
  static constexpr std::array<std::string_view, 3> kMadeByGdal{"fid", "ogc_fid", "rowid"};
  const bool is_made = std::ranges::any_of(
      kMadeByGdal, [&](std::string_view made) { return are_equal_words(name, made); });
  return is_made ? std::string() : name;
}

/// The dates of a column, row by row.
data::TextColumn dates_of(OGRLayer& layer, const std::string& name) {
  const int field = layer.GetLayerDefn()->GetFieldIndex(name.c_str());
  data::TextColumn dates;
  const KeptMessages messages;
  layer.ResetReading();
  for (const auto& feature : layer) {
    int year = 0;
    int month = 0;
    int day = 0;
    int unused = 0;
    const bool is_known = feature->GetFieldAsDateTime(
                              field, &year, &month, &day, &unused, &unused, &unused, &unused) != 0;
    is_known ? dates.append(fmt::format("{:04}-{:02}-{:02}", year, month, day))
             : dates.append_missing();
  }
  if (messages.has_errors()) {
    throw InputError("the dates cannot be read; the file may be damaged", {.column = name});
  }
  return dates;
}

/// Whether a column of numbers, or of texts that are numbers, has given values within 1 mm.
bool has_values(const data::Table& table,
                const std::string& column,
                const std::vector<double>& values) {
  constexpr double kMillimeter = 1e-3;
  for (std::size_t row = 0; row < values.size(); ++row) {
    double own = data::kMissing;
    if (table.is_numeric(column)) {
      own = table.numbers(column)[row];
    } else if (!data::parse_number(table.text(column)[row], own)) {
      return false;
    }
    if (std::abs(own - values[row]) > kMillimeter) return false;
  }
  return true;
}

/// Reads one layer; an object, because its functions share much state.
class LayerReader {
 public:
  LayerReader(const Dataset& dataset, OGRLayer& layer, std::optional<CoordinateSystem> target)
      : dataset_(dataset), layer_(layer), target_(std::move(target)), file_(dataset.place()) {}

  OpenedTable read(GeometryUse use) {
    use == GeometryUse::kAreas ? read_areas() : read_positions();
    result_.table = data::LayerTable{std::make_shared<data::Table>(std::move(table_))};
    return std::move(result_);
  }

 private:
  void read_positions();
  void read_areas();
  LayerColumns read_columns_with(const GeometrySink& sink);
  void require_bounded(std::size_t rows, std::size_t columns) const;
  Conversion conversion(const Extent& extent) const;
  void take_conversion(const Conversion& conversion);
  void set(LayerColumn column);
  void set_position(const std::string& name, std::vector<double> values);
  void note(std::string text) { result_.notes.push_back(std::move(text)); }

  const Dataset& dataset_;
  OGRLayer& layer_;
  std::optional<CoordinateSystem> target_;
  std::string file_;
  data::Table table_{};
  OpenedTable result_{};
};

/// Tests each batch, so that a damaged or malicious file is refused before it fills the memory.
void LayerReader::require_bounded(std::size_t rows, std::size_t columns) const {
  dataset_.require_sound(rows + 1);
  if (rows <= dataset_.most_values() / std::max<std::size_t>(columns, 1)) return;
  throw InputError(
      fmt::format("more than {} rows of {} columns are too many for a file of this size; does a "
                  "view or query repeat its rows?",
                  rows,
                  columns),
      {.file = file_});
}

LayerColumns LayerReader::read_columns_with(const GeometrySink& sink) {
  const auto check = [this](std::size_t rows, std::size_t columns) {
    require_bounded(rows, columns);
  };
  LayerColumns columns = read_columns(layer_, row_id_of(layer_), sink, check, file_);
  if (columns.columns.empty() && columns.rows == 0) {
    dataset_.require_sound();
    throw InputError("contains no rows", {.file = file_});
  }
  if (!columns.unread.empty()) {
    note(fmt::format("columns of lists or binary values are not read: {}",
                     fmt::join(columns.unread, ", ")));
  }
  table_ = data::Table(columns.rows);
  table_.set_origin(file_, {});
  for (LayerColumn& column : columns.columns) set(std::move(column));
  for (const std::string& name : columns.early_dates) table_.set(name, dates_of(layer_, name));
  return columns;
}

void LayerReader::set(LayerColumn column) {
  std::visit([&](auto& values) { table_.set(column.name, std::move(values)); }, column.values);
}

/// Adds a column of positions; a column of that name with other values gets another name.
void LayerReader::set_position(const std::string& name, std::vector<double> values) {
  const std::vector<std::string> names = table_.names();
  for (const std::string& own : names) {
    if (!are_equal_words(own, name)) continue;
    if (own == name && has_values(table_, own, values)) continue;
    const std::string kept = own + "_column";
    table_.is_numeric(own)
        ? table_.set(kept, {table_.numbers(own).begin(), table_.numbers(own).end()})
        : table_.set(kept, data::TextColumn(table_.text(own)));
    note(
        fmt::format("the layer has a column {0}, which differs from the positions of its points; "
                    "the points are used, and the column is called {1}",
                    own,
                    kept));
  }
  table_.set(name, std::move(values));
}

Conversion LayerReader::conversion(const Extent& extent) const {
  const bool may_be_assumed = dataset_.kind().drivers.starts_with("GeoJSON");
  return {layer_.GetSpatialRef(), extent, target_, file_, may_be_assumed};
}

void LayerReader::take_conversion(const Conversion& conversion) {
  result_.coordinates = conversion.result();
  for (const std::string& text : conversion.notes()) note(text);
}

void LayerReader::read_positions() {
  PointCollector points;
  read_columns_with([&points](std::span<const unsigned char> wkb) { points.add(wkb); });
  const auto other = points.first_other();
  if (points.has_points() && other) {
    throw InputError(
        fmt::format("the geometry is {}, but others are points; keep only points in the layer, or "
                    "select them with `sql`",
                    points.other_kind()),
        {.file = file_, .line = *other});
  }
  if (other) {
    note(fmt::format("the geometry of the rows is {}, which is not used; x and y come from points",
                     points.other_kind()));
    return;
  }
  if (!points.has_points()) return;
  const Conversion to_meters = conversion(points.extent());
  to_meters.apply(points.x, points.y);
  take_conversion(to_meters);
  set_position("x", std::move(points.x));
  set_position("y", std::move(points.y));
  if (points.has_elevations() && !table_.has("z")) table_.set("z", std::move(points.z));
}

void LayerReader::read_areas() {
  AreaCollector areas;
  read_columns_with([&](std::span<const unsigned char> wkb) { areas.add(wkb, file_); });
  if (!areas.has_polygons() && !areas.has_points()) {
    throw InputError("the layer has no geometry; choose a layer of polygons", {.file = file_});
  }
  const Conversion to_meters = conversion(areas.extent());
  areas.convert(to_meters, file_);
  take_conversion(to_meters);
  if (areas.has_polygons() && areas.has_points()) {
    throw InputError(
        "has polygons and points; windows are either polygons, or circles around "
        "points",
        {.file = file_});
  }
  if (areas.has_polygons()) {
    table_.set("wkt", areas.wkt());
  } else {
    table_.set("x", std::move(areas.x));
    table_.set("y", std::move(areas.y));
  }
}

/// A workbook of Excel 97 is read as text, like those that are read without GDAL.
OpenedTable read_sheet(const Dataset& workbook, OGRLayer& layer) {
  SheetBudget budget = sheet_budget(workbook.most_values());
  SheetText sheet(workbook.place(), budget);
  for (const auto& feature : layer) {
    for (int i = 0; i < feature->GetFieldCount(); ++i) {
      if (feature->IsFieldSetAndNotNull(i) == 0) continue;
      sheet.add(static_cast<std::size_t>(feature->GetFID()),
                static_cast<std::size_t>(i),
                feature->GetFieldAsString(i),
                CellKind::kText);
    }
  }
  workbook.require_sound();
  return {.table = sheet.text(), .notes = sheet.notes()};
}

}  // namespace

OpenedTable open_with_gdal(const std::string& name,
                           const TableChoice& choice,
                           GeometryUse use,
                           const std::optional<CoordinateSystem>& target) {
  Dataset dataset(name, choice);
  OGRLayer& layer = dataset.choose(choice, use);
  if (dataset.kind().is_workbook && choice.sql.empty()) return read_sheet(dataset, layer);
  return LayerReader(dataset, layer, target).read(use);
}

}  // namespace silvafit::source
