// SPDX-License-Identifier: MIT
#include "gdal/qgis_style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>
#include <vector>

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

}  // namespace

std::string qgis_style(const Layer& layer) {
  if (layer.style == LayerStyle::kNone) return {};
  const bool is_trees = layer.style == LayerStyle::kTreesBySpecies;
  return fmt::format(
      "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n<qgis version=\"3.22\" "
      "styleCategories=\"Symbology\">{}</qgis>\n",
      is_trees ? tree_renderer(layer.table) : outline_renderer());
}

}  // namespace silvafit::source
