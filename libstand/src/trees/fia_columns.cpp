// SPDX-License-Identifier: MIT
#include "trees/fia_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "silvafit/data/expression.hpp"

namespace silvafit::stand {
namespace {

/// The column of a name of FIA, which some databases write in lower case.
std::optional<std::string> fia_column(std::string_view name,
                                      const std::vector<std::string>& header) {
  const auto is_it = [name](const std::string& column) {
    return std::ranges::equal(column, name, [](unsigned char left, unsigned char right) {
      return std::toupper(left) == right;
    });
  };
  const auto found = std::ranges::find_if(header, is_it);
  return found == header.end() ? std::nullopt : std::optional(*found);
}

/// The columns that exist, joined as the source of a label; empty if the last one does not exist.
std::string joined_source(const std::vector<std::string_view>& names,
                          const std::vector<std::string>& header) {
  std::string source;
  if (!fia_column(names.back(), header)) return source;
  for (const std::string_view name : names) {
    const auto column = fia_column(name, header);
    if (column) source += (source.empty() ? "" : "+") + *column;
  }
  return source;
}

std::string source_of_plot(const std::vector<std::string>& header, bool by_location) {
  const auto visit = fia_column("PLT_CN", header);
  const bool has_location = fia_column("PLOT", header).has_value();
  if (visit && !(by_location && has_location)) return *visit;
  std::vector<std::string_view> names{"STATECD", "UNITCD", "COUNTYCD", "PLOT"};
  if (!by_location) names.insert(names.begin(), "INVYR");
  return joined_source(names, header);
}

/// TREE numbers the trees of a subplot.
std::string source_of_tree(const std::vector<std::string>& header) {
  const auto number = fia_column("CN", header);
  if (number && !fia_column("SUBP", header)) return *number;
  std::string source = joined_source({"SUBP", "TREE"}, header);
  return source.empty() ? number.value_or("") : source;
}

/// A coordinate in m; empty if columns are missing.
/// \param direction  sin for x, cos for y
/// \param microplot  offset of the microplot [ft]
/// \param subplots   offsets of the subplots 2 to 4 [ft]
std::string source_of_position(const std::vector<std::string>& header,
                               std::string_view direction,
                               double microplot,
                               const std::array<double, 3>& subplots) {
  const auto text_of = [&header](std::string_view name) {
    const auto column = fia_column(name, header);
    return column ? data::Expression::variable(*column).text() : std::string();
  };
  const std::string azimuth = text_of("AZIMUTH");
  const std::string distance = text_of("DIST");
  const std::string dbh = text_of("DIA");
  const std::string subplot = text_of("SUBP");
  if (azimuth.empty() || distance.empty() || subplot.empty()) return {};
  std::string text = fmt::format("{}*{}({}*pi/180)", distance, direction, azimuth);
  if (microplot != 0.0) text += fmt::format(" + ifelse({} < 5, {}, 0)", dbh, microplot);
  // Subplots of other numbers belong to older designs, whose places are not in the table.
  text += fmt::format(
      " + ifelse({0} == 1, 0, ifelse({0} == 2, {1:.8g}, ifelse({0} == 3, {2:.8g}, "
      "ifelse({0} == 4, {3:.8g}, 0/0))))",
      subplot,
      subplots[0],
      subplots[1],
      subplots[2]);
  return fmt::format("({})*0.3048", text);
}

}  // namespace

bool is_fia_tree_table(const std::vector<std::string>& header) {
  constexpr std::array<std::string_view, 6> kOthers{
      "STATUSCD", "SPCD", "PLT_CN", "SUBP", "TPA_UNADJ", "DIAHTCD"};
  const auto exists = [&header](std::string_view name) {
    return fia_column(name, header).has_value();
  };
  const bool has_species_and_height = exists("SPCD") && (exists("HT") || exists("ACTUALHT"));
  return exists("DIA") && (has_species_and_height || std::ranges::count_if(kOthers, exists) >= 2);
}

std::vector<ColumnMapping> fia_columns(const std::vector<std::string>& header, bool by_location) {
  std::vector<ColumnMapping> columns;
  if (!is_fia_tree_table(header)) return columns;
  const auto add = [&columns](std::string_view name, std::string source) {
    if (!source.empty())
      columns.push_back({.name = std::string(name), .source = std::move(source)});
  };
  const auto column = [&header](std::string_view name) {
    return fia_column(name, header).value_or("");
  };
  // 120 ft to the north, and to the directions of 120 and 240 degrees.
  constexpr double kFeet = 120.0;
  constexpr double kEast = kFeet * 0.86602540378443865;
  constexpr double kMicroplotFeet = 12.0;
  add("plot", source_of_plot(header, by_location));
  add("tree", source_of_tree(header));
  add("species", column("SPCD"));
  add("x", source_of_position(header, "sin", kMicroplotFeet, {0.0, kEast, -kEast}));
  add("y", source_of_position(header, "cos", 0.0, {kFeet, -kFeet / 2.0, -kFeet / 2.0}));
  add("dbh", column("DIA"));
  add("h", column("HT"));
  add("status", column("STATUSCD"));
  add("year", column("INVYR"));
  const auto factor = fia_column("TPA_UNADJ", header);
  if (factor) add("expansion", data::Expression::variable(*factor).text() + "/0.40468564224");
  return columns;
}

std::string_view fia_unit(std::string_view column) {
  std::string name(column);
  std::ranges::transform(
      name, name.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  constexpr std::array<std::string_view, 3> kFeet{"HT", "ACTUALHT", "DIST"};
  if (name == "DIA") return "in";
  return std::ranges::find(kFeet, name) == kFeet.end() ? "" : "ft";
}

std::optional<std::string> fia_plot_column(const std::vector<std::string>& header) {
  if (auto visit = fia_column("PLT_CN", header)) return visit;
  for (const std::string_view name : {"STATECD", "PLOT", "INVYR"}) {
    if (!fia_column(name, header)) return std::nullopt;
  }
  return fia_column("CN", header);
}

}  // namespace silvafit::stand
