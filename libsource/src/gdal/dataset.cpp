// SPDX-License-Identifier: MIT
#include "gdal/dataset.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>

#include "gdal/workbook_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::source {
namespace {

std::string in_lower_case(std::string text) {
  std::ranges::transform(
      text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// The message of a database or of SQLite within a message of GDAL, in one line.
std::string reason_in(const std::vector<std::string>& errors) {
  if (errors.empty()) return {};
  std::string text = errors.front();
  for (const char* const end : {"\nLINE ", "\nHINT", "\nDETAIL", "\n\tIs the server"}) {
    text = text.substr(0, text.find(end));
  }
  std::ranges::replace(text, '\n', ' ');
  for (const char* const begin : {"ERROR:  ", "failed: ", "): ", "PQconnectdb failed."}) {
    const std::size_t found = text.rfind(begin);
    if (found != std::string::npos) text = text.substr(found + std::string_view(begin).size());
  }
  std::string_view reason = data::trimmed(text);
  while (reason.ends_with('.') || reason.ends_with(' ')) reason.remove_suffix(1);
  return std::string(reason);
}

void require_query(const TableChoice& choice) {
  std::string sql = in_lower_case(std::string(data::trimmed(choice.sql)));
  while (sql.ends_with(';') || sql.ends_with(' ')) sql.pop_back();
  const bool is_query = sql.starts_with("select") || sql.starts_with("with");
  if (!is_query || sql.find(';') != std::string::npos) {
    throw UsageError("must be one query that begins with select or with", {.column = "--sql"});
  }
  const bool names_network =
      sql.find("/vsi") != std::string::npos || sql.find("://") != std::string::npos;
  if (names_network && !choice.allow_network) {
    throw UsageError("names a file of a network; add --allow-network if that is meant",
                     {.column = "--sql"});
  }
}

/// Metadata of the formats and of QGIS.
bool is_hidden(const std::string& name) {
  static constexpr std::array<std::string_view, 6> kHidden{"layer_styles",
                                                           "qgis_projects",
                                                           "spatial_ref_sys",
                                                           "geometry_columns",
                                                           "geography_columns",
                                                           "spatial_ref_sys_aux"};
  return std::ranges::find(kHidden, in_lower_case(name)) != kHidden.end();
}

std::string kind_of_geometry(OGRLayer& layer) {
  switch (wkbFlatten(layer.GetGeomType())) {
    case wkbNone:
      return "no geometry";
    case wkbPoint:
    case wkbMultiPoint:
      return "points";
    case wkbPolygon:
    case wkbMultiPolygon:
    case wkbCurvePolygon:
    case wkbMultiSurface:
      return "polygons";
    case wkbLineString:
    case wkbMultiLineString:
      return "lines";
    default:
      return "geometries";
  }
}

std::string description(OGRLayer& layer, bool is_sheet) {
  const GIntBig rows = layer.GetFeatureCount(FALSE);
  const std::string count = rows < 0 ? "" : fmt::format("{} rows", rows);
  if (is_sheet) return fmt::format("'{}' ({})", layer.GetName(), count);
  return fmt::format(
      "'{}' ({}{}{})", layer.GetName(), kind_of_geometry(layer), count.empty() ? "" : ", ", count);
}

std::string list(const std::vector<OGRLayer*>& layers, bool are_sheets) {
  constexpr std::size_t kMost = 40;
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < std::min(kMost, layers.size()); ++i) {
    texts.push_back(description(*layers[i], are_sheets));
  }
  if (layers.size() > kMost) texts.push_back(fmt::format("{} more", layers.size() - kMost));
  return fmt::format("{}", fmt::join(texts, ", "));
}

const SourceKind& required_kind(const std::string& name) {
  const SourceKind* const kind = kind_of_source(name);
  if (kind != nullptr) return *kind;
  throw UsageError("the ending is that of no known workbook, layer or database",
                   {.file = shown_name(name)});
}

bool is_postgres(const SourceKind& kind) { return kind.drivers == "PostgreSQL"; }

/// The name that is passed to GDAL.
std::string opened_name(const std::string& name, const SourceKind& kind) {
  if (!is_postgres(kind)) return name.find("://") == std::string::npos ? name : "/vsicurl/" + name;
  const bool is_address = name.find("://") != std::string::npos;
  std::string text = "PG:" + name.substr(3);
  // The database refuses all changes, whatever the query contains.
  if (!is_address && text.find("options=") == std::string::npos) {
    text += " options='-c default_transaction_read_only=on'";
  }
  return text;
}

/// Checks of a file without GDAL.
void require_file(const std::string& name, const std::string& shown) {
  switch (silvafit::kind_of(name)) {
    case PathKind::kNothing:
      throw InputError("cannot be read: No such file or directory", {.file = shown});
    case PathKind::kFolder:
      throw InputError("is a folder; a file is needed", {.file = shown});
    case PathKind::kStream:
      throw InputError("is a device or pipe; workbooks and layers are read from files",
                       {.file = shown});
    case PathKind::kFile:
      break;
  }
}

}  // namespace

bool may_have_areas(OGRLayer& layer) {
  const OGRwkbGeometryType type = wkbFlatten(layer.GetGeomType());
  if (type == wkbPoint) return layer.GetLayerDefn()->GetFieldIndex("radius") >= 0;
  return type == wkbUnknown || OGR_GT_IsSubClassOf(type, wkbCurvePolygon) != FALSE ||
         OGR_GT_IsSubClassOf(type, wkbMultiSurface) != FALSE;
}

void Dataset::fail(const std::string& message) const {
  throw InputError(message, {.file = place_});
}

Dataset::Dataset(const std::string& name, const TableChoice& choice)
    : path_(name), kind_(required_kind(name)), place_(shown_name(name)) {
  if (!choice.layer.empty() && !choice.sql.empty()) {
    throw UsageError("a query chooses its layers itself; omit --layer", {.column = "--sql"});
  }
  if (!choice.sql.empty()) require_query(choice);
  const bool is_remote = is_network_name(name);
  if (is_remote && !choice.allow_network) {
    fail("is a file of a network or an archive; save it on this computer, or add --allow-network");
  }
  if (!is_remote && !is_postgres(kind_)) require_file(name, place_);
  start_gdal();
  if (kind_.is_workbook) {
    if (!is_remote) require_readable_workbook(name, kind_, place_);
    // Headers and types are detected as in CSV files; a query needs those that GDAL detects.
    for (const char* const format : {"XLSX", "ODS", "XLS"}) {
      const bool is_query = !choice.sql.empty();
      settings_.emplace_back(fmt::format("OGR_{}_HEADERS", format).c_str(),
                             is_query ? "AUTO" : "DISABLE");
      settings_.emplace_back(fmt::format("OGR_{}_FIELD_TYPES", format).c_str(),
                             is_query ? "AUTO" : "STRING");
    }
  }
  CPLStringList drivers(CSLTokenizeString2(std::string(kind_.drivers).c_str(), ",", 0));
  const KeptMessages messages;
  dataset_.reset(GDALDataset::Open(
      opened_name(name, kind_).c_str(), GDAL_OF_VECTOR | GDAL_OF_VERBOSE_ERROR, drivers.List()));
  if (dataset_) return;
  if (is_postgres(kind_)) {
    fail(
        fmt::format("the database cannot be opened: {}; check host, port, dbname, user and "
                    "password",
                    reason_in(messages.errors())));
  }
  fail(fmt::format(
      "is not {}, or is damaged; open it in the program that made it and save it "
      "again{}",
      kind_.format,
      kind_.drivers == "ESRI Shapefile" ? ", with the files beside it that end in .shx and .dbf"
                                        : ""));
}

Dataset::~Dataset() {
  if (result_ != nullptr) dataset_->ReleaseResultSet(result_);
}

std::vector<OGRLayer*> Dataset::visible_layers() const {
  std::vector<OGRLayer*> layers;
  for (OGRLayer* const layer : dataset_->GetLayers()) {
    // Programs add empty sheets to workbooks.
    const bool is_empty = kind_.is_workbook && layer->GetFeatureCount(TRUE) == 0;
    if (!is_hidden(layer->GetName()) && !is_empty) layers.push_back(layer);
  }
  return layers;
}

OGRLayer& Dataset::only_layer(GeometryUse use) {
  std::vector<OGRLayer*> layers = visible_layers();
  const char* const one = kind_.is_workbook ? "sheet" : "layer";
  if (layers.empty()) fail(fmt::format("contains no {} with rows", one));
  const std::vector<OGRLayer*> all = layers;
  if (use == GeometryUse::kAreas) {
    std::erase_if(layers, [](OGRLayer* layer) { return !may_have_areas(*layer); });
    if (layers.empty()) {
      fail(fmt::format("has no layer of polygons, or of points with a column radius; available: {}",
                       list(all, kind_.is_workbook)));
    }
  }
  if (layers.size() > 1) {
    fail(fmt::format("has several {0}s; choose one with {1} NAME: {2}",
                     one,
                     use == GeometryUse::kAreas ? "--window-layer" : "--layer",
                     list(layers, kind_.is_workbook)));
  }
  if (all.size() > 1) layer_name_ = layers.front()->GetName();
  return *layers.front();
}

OGRLayer& Dataset::run_query(const std::string& sql) {
  KeptMessages messages;
  result_ = dataset_->ExecuteSQL(sql.c_str(), nullptr, kind_.has_own_sql ? nullptr : "SQLITE");
  if (result_ != nullptr && messages.errors().empty()) return *result_;
  const std::string reason = reason_in(messages.errors());
  fail(fmt::format("the query of --sql failed: {}; available: {}",
                   reason.empty() ? "it has no result" : reason,
                   list(visible_layers(), kind_.is_workbook)));
}

OGRLayer& Dataset::choose(const TableChoice& choice, GeometryUse use) {
  OGRLayer* layer = nullptr;
  if (!choice.sql.empty()) {
    layer = &run_query(choice.sql);
    place_ += " (--sql)";
    return *layer;
  }
  if (choice.layer.empty()) {
    layer = &only_layer(use);
  } else {
    layer = dataset_->GetLayerByName(choice.layer.c_str());
    if (layer == nullptr) {
      fail(fmt::format("unknown {} '{}'; available: {}",
                       kind_.is_workbook ? "sheet" : "layer",
                       choice.layer,
                       list(visible_layers(), kind_.is_workbook)));
    }
    layer_name_ = layer->GetName();
  }
  if (kind_.is_workbook) layer_name_ = layer->GetName();
  if (!layer_name_.empty()) {
    place_ += fmt::format(" ({} {})", kind_.is_workbook ? "sheet" : "layer", layer_name_);
  }
  return *layer;
}

}  // namespace silvafit::source
