// SPDX-License-Identifier: MIT
#include "silvafit/source/write_layers.hpp"

#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "gdal/functions.hpp"
#include "gdal/session.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/io_error.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"
#include "source_kind.hpp"
#include "workbook/xml.hpp"

namespace silvafit::source {
namespace {

// Okabe and Ito (2008): colors that color-blind readers distinguish.
constexpr std::array<std::string_view, 8> kColors{"0,158,115",
                                                  "230,159,0",
                                                  "86,180,233",
                                                  "213,94,0",
                                                  "0,114,178",
                                                  "204,121,167",
                                                  "240,228,66",
                                                  "0,0,0"};
constexpr std::string_view kOtherColor = "150,150,150";

std::string option(std::string_view name, std::string_view value) {
  return fmt::format("<Option type=\"QString\" name=\"{}\" value=\"{}\"/>", name, xml_text(value));
}

/// The symbol of a tree: a circle, whose diameter in mm grows with dbh.
std::string tree_symbol(std::size_t number, std::string_view color, bool has_dbh) {
  std::string size;
  if (has_dbh) {
    size = "<data_defined_properties><Option type=\"Map\">" + option("name", "") +
           "<Option type=\"Map\" name=\"properties\"><Option type=\"Map\" name=\"size\">"
           "<Option type=\"bool\" name=\"active\" value=\"true\"/>" +
           option("expression", "coalesce(scale_linear(\"dbh\", 0, 100, 0.8, 6), 1.5)") +
           "<Option type=\"int\" name=\"type\" value=\"3\"/></Option></Option>" +
           option("type", "collection") + "</Option></data_defined_properties>";
  }
  return fmt::format(
      "<symbol type=\"marker\" name=\"{}\" alpha=\"0.85\" clip_to_extent=\"1\">"
      "<layer class=\"SimpleMarker\" enabled=\"1\" pass=\"0\" locked=\"0\"><Option "
      "type=\"Map\">{}{}{}{}{}</Option>{}</layer></symbol>",
      number,
      option("name", "circle"),
      option("color", fmt::format("{},255", color)),
      option("outline_color", "60,60,60,255"),
      option("outline_width", "0.1"),
      option("size", "2"),
      size);
}

/// Species by number of trees, the most frequent first.
std::vector<std::string> frequent_species(const data::Table& table) {
  if (!table.has("species")) return {};
  const data::TextColumn species = table.labels("species");
  std::map<std::string, std::size_t> counts;
  for (std::size_t i = 0; i < species.size(); ++i) {
    if (!species.is_missing(i)) ++counts[std::string(species[i])];
  }
  std::vector<std::pair<std::string, std::size_t>> sorted(counts.begin(), counts.end());
  std::ranges::stable_sort(
      sorted, [](const auto& left, const auto& right) { return left.second > right.second; });
  if (sorted.size() > kColors.size()) sorted.resize(kColors.size());
  std::vector<std::string> names;
  for (const auto& [name, count] : sorted) names.push_back(name);
  return names;
}

std::string tree_renderer(const data::Table& table) {
  const std::vector<std::string> species = frequent_species(table);
  const bool has_dbh = table.has("dbh") && table.is_numeric("dbh");
  if (species.empty()) {
    return "<renderer-v2 type=\"singleSymbol\" forceraster=\"0\" symbollevels=\"0\"><symbols>" +
           tree_symbol(0, kColors[0], has_dbh) + "</symbols></renderer-v2>";
  }
  std::string categories;
  std::string symbols;
  for (std::size_t i = 0; i < species.size(); ++i) {
    const std::string name = xml_text(species[i]);
    categories += fmt::format(
        "<category symbol=\"{}\" label=\"{}\" value=\"{}\" type=\"string\" render=\"true\"/>",
        i,
        name,
        name);
    symbols += tree_symbol(i, kColors[i], has_dbh);
  }
  categories += fmt::format(
      "<category symbol=\"{}\" label=\"other\" value=\"\" type=\"string\" render=\"true\"/>",
      species.size());
  symbols += tree_symbol(species.size(), kOtherColor, has_dbh);
  return fmt::format(
      "<renderer-v2 type=\"categorizedSymbol\" attr=\"species\" forceraster=\"0\" "
      "symbollevels=\"0\"><categories>{}</categories><symbols>{}</symbols></renderer-v2>",
      categories,
      symbols);
}

std::string outline_renderer() {
  return fmt::format(
      "<renderer-v2 type=\"singleSymbol\" forceraster=\"0\" symbollevels=\"0\"><symbols>"
      "<symbol type=\"fill\" name=\"0\" alpha=\"1\" clip_to_extent=\"1\"><layer "
      "class=\"SimpleFill\" enabled=\"1\" pass=\"0\" locked=\"0\"><Option "
      "type=\"Map\">{}{}{}{}</Option></layer></symbol></symbols></renderer-v2>",
      option("style", "no"),
      option("color", "0,0,0,0"),
      option("outline_color", "40,40,40,255"),
      option("outline_width", "0.4"));
}

/// A style in QGIS's XML (QML); empty for LayerStyle::kNone.
std::string qgis_style(const Layer& layer) {
  if (layer.style == LayerStyle::kNone) return {};
  const bool is_trees = layer.style == LayerStyle::kTreesBySpecies;
  return fmt::format(
      "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n<qgis version=\"3.22\" "
      "styleCategories=\"Symbology\">{}</qgis>\n",
      is_trees ? tree_renderer(layer.table) : outline_renderer());
}

// Files of the same content have the same bytes.
constexpr const char* kNoDate = "2000-01-01T00:00:00.000Z";

const char* driver_of(const std::string& ending) {
  return ending == "gpkg" ? "GPKG" : "FlatGeobuf";
}

/// A name that no other field of the layer has; databases ignore case.
std::string free_name(const std::string& name, std::set<std::string>& taken) {
  for (int number = 1;; ++number) {
    std::string candidate = number == 1 ? name : fmt::format("{}_{}", name, number);
    if (taken.insert(in_lower_case(candidate)).second) return candidate;
  }
}

bool are_whole(std::span<const double> values) {
  constexpr double kLargest = 9007199254740992.0;
  return std::ranges::all_of(values, [](double value) {
    return std::isnan(value) || (value == std::floor(value) && std::abs(value) < kLargest);
  });
}

/// Writes one file; an object, because its functions share much state.
class Writer {
 public:
  Writer(std::filesystem::path target, const std::filesystem::path& draft)
      : target_(std::move(target)),
        ending_(ending_of(target_.string())),
        date_("OGR_CURRENT_DATE", kNoDate) {
    GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName(driver_of(ending_));
    if (driver != nullptr) {
      dataset_.reset(driver->Create(draft.string().c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    }
    if (!dataset_) fail();
  }

  void add(const Layer& layer, const OGRSpatialReference* system, double meters_per_unit);
  void add_styles(const std::vector<Layer>& layers);
  void finish();

 private:
  struct Field {
    std::string column{};
    int index = 0;
    bool is_whole = false;
  };

  [[noreturn]] void fail() const {
    throw IoError("cannot be written; is the disk full?", {.file = target_.string()});
  }
  void require(bool is_done) const {
    if (!is_done) fail();
  }
  std::vector<Field> add_fields(OGRLayer& target, const Layer& layer) const;
  void fill(OGRFeature& feature,
            const data::Table& table,
            const std::vector<Field>& fields,
            std::size_t row) const;
  static std::unique_ptr<OGRGeometry> geometry_of(const Layer& layer,
                                                  std::size_t row,
                                                  double meters_per_unit);

  std::filesystem::path target_;
  std::string ending_;
  Setting date_;
  KeptMessages messages_{};
  GDALDatasetUniquePtr dataset_{};
};

std::vector<Writer::Field> Writer::add_fields(OGRLayer& target, const Layer& layer) const {
  std::set<std::string> taken{"fid", "geom"};
  std::vector<Field> fields;
  for (const std::string& name : layer.table.names()) {
    if (layer.geometry == LayerGeometry::kAreas && name == "wkt") continue;
    const bool is_numeric = layer.table.is_numeric(name);
    const bool is_whole = is_numeric && are_whole(layer.table.numbers(name));
    const OGRFieldType type = !is_numeric ? OFTString : is_whole ? OFTInteger64 : OFTReal;
    OGRFieldDefn definition(free_name(name, taken).c_str(), type);
    require(target.CreateField(&definition) == OGRERR_NONE);
    fields.push_back({.column = name,
                      .index = target.GetLayerDefn()->GetFieldCount() - 1,
                      .is_whole = is_whole});
  }
  return fields;
}

void Writer::fill(OGRFeature& feature,
                  const data::Table& table,
                  const std::vector<Field>& fields,
                  std::size_t row) const {
  for (const Field& field : fields) {
    if (!table.is_numeric(field.column)) {
      const data::TextColumn& texts = table.text(field.column);
      if (texts.is_missing(row)) continue;
      feature.SetField(field.index, std::string(texts[row]).c_str());
      continue;
    }
    const double value = table.numbers(field.column)[row];
    if (std::isnan(value)) continue;
    field.is_whole ? feature.SetField(field.index, static_cast<GIntBig>(value))
                   : feature.SetField(field.index, value);
  }
}

std::unique_ptr<OGRGeometry> Writer::geometry_of(const Layer& layer,
                                                 std::size_t row,
                                                 double meters_per_unit) {
  if (layer.geometry == LayerGeometry::kNone) return nullptr;
  if (layer.geometry == LayerGeometry::kPoints) {
    const double x = layer.table.numbers("x")[row];
    const double y = layer.table.numbers("y")[row];
    if (std::isnan(x) || std::isnan(y)) return nullptr;
    return std::make_unique<OGRPoint>(x / meters_per_unit, y / meters_per_unit);
  }
  OGRGeometry* made = nullptr;
  const std::string text(layer.table.text("wkt")[row]);
  OGRGeometryFactory::createFromWkt(text.c_str(), nullptr, &made);
  std::unique_ptr<OGRGeometry> geometry(made);
  if (!geometry || meters_per_unit == 1.0) return geometry;
  for (auto* const polygon : *geometry->toMultiPolygon()) {
    for (auto* const ring : *polygon) {
      for (auto& point : *ring) {
        point.setX(point.getX() / meters_per_unit);
        point.setY(point.getY() / meters_per_unit);
      }
    }
  }
  return geometry;
}

void Writer::add(const Layer& layer, const OGRSpatialReference* system, double meters_per_unit) {
  OGRwkbGeometryType type = wkbNone;
  if (layer.geometry == LayerGeometry::kPoints) type = wkbPoint;
  if (layer.geometry == LayerGeometry::kAreas) type = wkbMultiPolygon;
  CPLStringList options;
  if (ending_ == "gpkg") options.SetNameValue("GEOMETRY_NAME", "geom");
  OGRLayer* const target = dataset_->CreateLayer(
      layer.name.c_str(), const_cast<OGRSpatialReference*>(system), type, options.List());
  if (target == nullptr) fail();
  const std::vector<Field> fields = add_fields(*target, layer);
  dataset_->StartTransaction();
  OGRFeature feature(target->GetLayerDefn());
  for (std::size_t row = 0; row < layer.table.rows(); ++row) {
    feature.Reset();
    fill(feature, layer.table, fields, row);
    feature.SetGeometryDirectly(geometry_of(layer, row, meters_per_unit).release());
    require(target->CreateFeature(&feature) == OGRERR_NONE);
  }
  dataset_->CommitTransaction();
}

/// The table that QGIS itself writes when it saves a style in a GeoPackage.
void Writer::add_styles(const std::vector<Layer>& layers) {
  CPLStringList options;
  options.SetNameValue("FID", "id");
  OGRLayer* const styles = dataset_->CreateLayer("layer_styles", nullptr, wkbNone, options.List());
  if (styles == nullptr) fail();
  constexpr std::array<std::pair<const char*, OGRFieldType>, 12> kFields{
      {{"f_table_catalog", OFTString},
       {"f_table_schema", OFTString},
       {"f_table_name", OFTString},
       {"f_geometry_column", OFTString},
       {"styleName", OFTString},
       {"styleQML", OFTString},
       {"styleSLD", OFTString},
       {"useAsDefault", OFTInteger},
       {"description", OFTString},
       {"owner", OFTString},
       {"ui", OFTString},
       {"update_time", OFTDateTime}}};
  for (const auto& [name, field_type] : kFields) {
    OGRFieldDefn field(name, field_type);
    if (field_type == OFTInteger) field.SetSubType(OFSTBoolean);
    require(styles->CreateField(&field) == OGRERR_NONE);
  }
  for (const Layer& layer : layers) {
    const std::string style = qgis_style(layer);
    if (style.empty() || layer.geometry == LayerGeometry::kNone) continue;
    OGRFeature feature(styles->GetLayerDefn());
    for (const char* const name : {"f_table_catalog", "f_table_schema", "owner", "styleSLD"}) {
      feature.SetField(name, "");
    }
    feature.SetField("f_table_name", layer.name.c_str());
    feature.SetField("f_geometry_column", "geom");
    feature.SetField("styleName", "silvafit");
    feature.SetField("styleQML", style.c_str());
    feature.SetField("useAsDefault", 1);
    feature.SetField("description", "Default style, written by silvafit");
    feature.SetField("update_time", kNoDate);
    require(styles->CreateFeature(&feature) == OGRERR_NONE);
  }
}

void Writer::finish() {
  dataset_.reset();
  if (!messages_.errors().empty()) fail();
}

/// The system of the coordinates, with x before y; null if it is not known.
std::unique_ptr<OGRSpatialReference> system_of(const std::optional<CoordinateSystem>& coordinates) {
  if (!coordinates) return nullptr;
  auto system = std::make_unique<OGRSpatialReference>();
  system->SetFromUserInput(coordinates->wkt.c_str());
  system->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return system;
}

}  // namespace

void write_with_gdal(const std::filesystem::path& draft,
                     const std::filesystem::path& file,
                     const std::vector<Layer>& layers,
                     const std::optional<CoordinateSystem>& coordinates) {
  start_gdal();
  const auto system = system_of(coordinates);
  const double meters_per_unit = coordinates ? coordinates->meters_per_unit : 1.0;
  Writer writer(file, draft);
  const bool has_several = ending_of(file.string()) != "fgb";
  for (const Layer& layer : layers) {
    writer.add(layer, system.get(), meters_per_unit);
    if (!has_several) break;
  }
  if (ending_of(file.string()) == "gpkg") writer.add_styles(layers);
  writer.finish();
}

}  // namespace silvafit::source
