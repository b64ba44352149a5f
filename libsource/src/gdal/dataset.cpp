// SPDX-License-Identifier: MIT
#include "gdal/dataset.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>

#include "gdal/own_data.hpp"
#include "gdal/stored_types.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::source {
namespace {

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
  std::string sql = in_lower_case(data::trimmed(choice.sql));
  while (sql.ends_with(';') || sql.ends_with(' ')) sql.pop_back();
  const bool is_query = sql.starts_with("select") || sql.starts_with("with");
  if (!is_query || sql.find(';') != std::string::npos) {
    throw UsageError("must be one query that begins with select or with", {.column = "`sql`"});
  }
  const bool names_network =
      sql.find("/vsi") != std::string::npos || sql.find("://") != std::string::npos;
  if (names_network && !choice.allow_network) {
    throw UsageError("names a file of a network; add `allow_network` if that is meant",
                     {.column = "`sql`"});
  }
}

/// Metadata of the formats, of SpatiaLite and of QGIS.
bool is_hidden(const std::string& name) {
  static constexpr std::string_view kHidden =
      "layer_styles qgis_projects geometry_columns geometry_columns_auth "
      "geometry_columns_field_infos geometry_columns_statistics geometry_columns_time "
      "geography_columns geom_cols_ref_sys data_licenses elementarygeometries knn knn2 "
      "spatialindex spatialite_history sql_statements_log raster_coverages "
      "raster_coverages_keyword raster_coverages_ref_sys raster_coverages_srid "
      "vector_coverages vector_coverages_keyword vector_coverages_ref_sys "
      "vector_coverages_srid networks topologies stored_procedures stored_variables "
      "ogr_empty_table wms_getcapabilities wms_getmap wms_settings wms_ref_sys";
  // Groups of tables with similar names.
  static constexpr std::array<std::string_view, 15> kBeginnings{"sqlite_",
                                                                "spatial_ref_sys",
                                                                "vector_layers",
                                                                "views_geometry_columns",
                                                                "virts_geometry_columns",
                                                                "gpkg_",
                                                                "rtree_",
                                                                "idx_",
                                                                "iso_metadata",
                                                                "se_external_graphics",
                                                                "se_fonts",
                                                                "se_raster_style",
                                                                "se_vector_style",
                                                                "se_group_style",
                                                                "rl2map_configurations"};
  const std::string own = in_lower_case(name);
  return has_word(kHidden, own) ||
         std::ranges::any_of(kBeginnings, [&own](std::string_view beginning) {
           return own.starts_with(beginning);
         });
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

/// The bytes of a file; for a shapefile those of its table, too.
std::uintmax_t size_of(const std::filesystem::path& file) {
  std::error_code ignored;
  std::uintmax_t size = 0;
  for (const char* const ending : {".dbf", ".DBF"}) {
    const std::filesystem::path table = std::filesystem::path(file).replace_extension(ending);
    if (table == file) continue;
    const std::uintmax_t own = std::filesystem::file_size(table, ignored);
    if (!ignored) size += own;
  }
  const std::uintmax_t own = std::filesystem::file_size(file, ignored);
  return ignored ? size : size + own;
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

void Dataset::refuse_unreadable() const {
  fail(fmt::format(
      "is not {}, or is damaged; open it in the program that made it and save it "
      "again{}",
      kind_.format,
      kind_.drivers == "ESRI Shapefile" ? ", with the files beside it that end in .shx and .dbf"
                                        : ""));
}

/// Without --allow-network nothing of a file reaches other files or a network.
void Dataset::require_own(const TableChoice& choice) const {
  if (!is_sqlite_file(path_)) return;
  if (!is_sound_database(path_)) refuse_unreadable();
  if (choice.allow_network) return;
  if (!require_own_data(path_, choice, place_)) refuse_unreadable();
}

/// GDAL's connection to a database of SQLite or a GeoPackage; null for other files.
sqlite3* Dataset::database() const {
  return static_cast<sqlite3*>(dataset_->GetInternalHandle("SQLITE_HANDLE"));
}

/// SQLite is interrupted after as many steps as no honest query of a file of this size needs, and
/// makes no value that is larger than the file: a view can request endless work and memory.
void Dataset::limit_work() {
  if (database() == nullptr) return;
  constexpr int kInterval = 1000;
  sqlite3_progress_handler(database(), kInterval, count_step, this);
  constexpr std::uintmax_t kFree = 1000000;
  constexpr std::uintmax_t kMost = std::numeric_limits<int>::max();
  sqlite3_limit(database(),
                SQLITE_LIMIT_LENGTH,
                static_cast<int>(std::clamp<std::uintmax_t>(bytes_, kFree, kMost)));
}

int Dataset::count_step(void* dataset) {
  constexpr std::uintmax_t kFree = 200000;  // 200 million steps, some seconds
  auto* const self = static_cast<Dataset*>(dataset);
  self->is_beyond_limit_ = ++self->steps_ > kFree + self->bytes_ / 5;
  return self->is_beyond_limit_ ? 1 : 0;
}

std::size_t Dataset::most_values() const {
  constexpr std::size_t kFree = 50000000;
  constexpr std::size_t kEachByte = 8;
  if (bytes_ == 0) return std::numeric_limits<std::size_t>::max();
  return kFree + kEachByte * static_cast<std::size_t>(bytes_);
}

void Dataset::require_sound(std::optional<std::size_t> row) const {
  if (has_refused_network()) {
    fail("refers to a file of a network; add `allow_network` if that is meant");
  }
  if (is_beyond_limit_) {
    fail("needs more work than a table of this size should; does a view repeat its rows?");
  }
  if (!messages_.has_errors()) return;
  if (!kind_.is_workbook) fail("cannot be read: " + reason_in(messages_.errors()));
  throw InputError(
      "the sheet cannot be read completely; save the workbook again as .xlsx, or as CSV in UTF-8",
      {.file = place_, .line = row});
}

Dataset::Dataset(const std::string& name, const TableChoice& choice)
    : path_(name), kind_(required_kind(name)), place_(shown_name(name)) {
  if (!choice.layer.empty() && !choice.sql.empty()) {
    throw UsageError("a query chooses its layers itself; omit `layer`", {.column = "`sql`"});
  }
  if (!choice.sql.empty()) require_query(choice);
  const bool is_remote = is_network_name(name);
  if (is_remote && !choice.allow_network) {
    fail("is a file of a network or an archive; save it on this computer, or add `allow_network`");
  }
  if (!is_remote && !is_postgres(kind_)) require_file(name, place_);
  start_gdal();
  set_network(choice.allow_network);
  if (!is_remote && !is_postgres(kind_)) {
    bytes_ = size_of(name);
    require_own(choice);
  }
  if (!choice.allow_network) settings_.emplace_back("OGR_SQLITE_STATIC_VIRTUAL_OGR", "NO");
  if (kind_.is_workbook && choice.sql.empty()) {
    // Headers and types are detected as in CSV files; a query needs those that GDAL detects.
    settings_.emplace_back("OGR_XLS_HEADERS", "DISABLE");
    settings_.emplace_back("OGR_XLS_FIELD_TYPES", "STRING");
  }
  CPLStringList drivers(CSLTokenizeString2(std::string(kind_.drivers).c_str(), ",", 0));
  // Tables without geometry are inventories, too.
  CPLStringList options;
  options.SetNameValue("LIST_ALL_TABLES", "YES");
  dataset_.reset(GDALDataset::Open(
      opened_name(name, kind_).c_str(),
      GDAL_OF_VECTOR | GDAL_OF_VERBOSE_ERROR,
      drivers.List(),
      kind_.drivers.find("GPKG") != std::string_view::npos ? options.List() : nullptr));
  if (dataset_ || has_refused_network()) require_sound();
  if (dataset_) {
    limit_work();
    return;
  }
  if (is_postgres(kind_)) {
    fail(
        fmt::format("the database cannot be opened: {}; check host, port, dbname, user and "
                    "password",
                    reason_in(messages_.errors())));
  }
  refuse_unreadable();
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
                     use == GeometryUse::kAreas ? "`window_layer`" : "`layer`",
                     list(layers, kind_.is_workbook)));
  }
  if (all.size() > 1) layer_name_ = layers.front()->GetName();
  return *layers.front();
}

/// The tables and columns that a query in GDAL's SQLite dialect can name.
std::vector<QueriedLayer> Dataset::queried_layers() const {
  std::vector<QueriedLayer> queried;
  for (OGRLayer* const layer : dataset_->GetLayers()) {
    const OGRFeatureDefn& definition = *layer->GetLayerDefn();
    QueriedLayer own{.name = layer->GetName(), .columns = {"OGR_STYLE"}};
    for (int i = 0; i < definition.GetFieldCount(); ++i) {
      own.columns.emplace_back(definition.GetFieldDefn(i)->GetNameRef());
    }
    for (int i = 0; i < definition.GetGeomFieldCount(); ++i) {
      const std::string name = definition.GetGeomFieldDefn(i)->GetNameRef();
      own.columns.push_back(name.empty() ? "GEOMETRY" : name);
    }
    const std::string id = layer->GetFIDColumn();
    if (!id.empty()) own.columns.push_back(id);
    queried.push_back(std::move(own));
  }
  return queried;
}

OGRLayer& Dataset::run_query(const TableChoice& choice) {
  KeptMessages messages;
  std::string problem;
  if (!kind_.has_own_sql && !choice.allow_network) {
    problem = require_own_layers(choice.sql, queried_layers());
  }
  if (problem.empty()) {
    result_ =
        dataset_->ExecuteSQL(choice.sql.c_str(), nullptr, kind_.has_own_sql ? nullptr : "SQLITE");
    require_sound();
    if (result_ != nullptr && !messages.has_errors()) return *result_;
    problem = reason_in(messages.errors());
  }
  fail(fmt::format("the query of `sql` failed: {}; available: {}",
                   problem.empty() ? "it has no result" : problem,
                   list(visible_layers(), kind_.is_workbook)));
}

OGRLayer& Dataset::choose(const TableChoice& choice, GeometryUse use) {
  OGRLayer* layer = nullptr;
  if (!choice.sql.empty()) {
    layer = &run_query(choice);
    place_ += " (`sql`)";
    if (database() != nullptr) {
      std::string_view query = data::trimmed(choice.sql);
      while (query.ends_with(';')) query = data::trimmed(query.substr(0, query.size() - 1));
      take_stored_types(*database(), fmt::format("({})", query), *layer);
    }
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
  if (database() != nullptr) take_stored_types(*database(), quoted_name(layer->GetName()), *layer);
  if (kind_.is_workbook) layer_name_ = layer->GetName();
  if (!layer_name_.empty()) {
    place_ += fmt::format(" ({} {})", kind_.is_workbook ? "sheet" : "layer", layer_name_);
  }
  return *layer;
}

}  // namespace silvafit::source
