// SPDX-License-Identifier: MIT
// Headers of columns: their names and units.
#include "trees/usual_names.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/stand/tree_columns.hpp"
#include "trees/folded_text.hpp"

namespace silvafit::stand {
namespace {

constexpr std::array<LengthUnit, 6> kUnits{
    {{"mm", 0.001}, {"cm", 0.01}, {"dm", 0.1}, {"m", 1.0}, {"in", 0.0254}, {"ft", 0.3048}}};

struct UnitWord {
  std::string_view word{};
  std::string_view unit{};
};
constexpr std::array<UnitWord, 16> kUnitWords{{{"inch", "in"},
                                               {"inches", "in"},
                                               {"zoll", "in"},
                                               {"\"", "in"},
                                               {"feet", "ft"},
                                               {"foot", "ft"},
                                               {"meter", "m"},
                                               {"meters", "m"},
                                               {"metre", "m"},
                                               {"metres", "m"},
                                               {"米", "m"},
                                               {"厘米", "cm"},
                                               {"公分", "cm"},
                                               {"毫米", "mm"},
                                               {"millimeter", "mm"},
                                               {"centimeter", "cm"}}};

bool is_separator(char c) {
  return c == ' ' || c == '_' || c == '.' || c == '/' || c == ',' || c == '-' || c == '(' ||
         c == '[' || c == ')' || c == ']' || c == ':' || c == ';' || c == '`';
}

/// Where a Latin word at the end of a text begins.
std::size_t last_word(std::string_view text) {
  std::size_t begin = text.size();
  while (begin > 0 && !is_separator(text[begin - 1])) --begin;
  return begin;
}

/// Whether a text ends with a number, as in `DBH (1.3 m)`: a height instead of a unit.
bool ends_with_height(std::string_view text) {
  const std::size_t blank = text.find_last_of(" _([");
  const std::string_view word = text.substr(blank == std::string_view::npos ? 0 : blank + 1);
  double ignored = 0.0;
  return data::parse_number(word, ignored);
}

/// Units that no measure has.
bool is_other_unit(std::string_view text) {
  constexpr std::string_view kOthers = "% ° deg degree degrees grad gon gons m3 m³ years";
  return has_word(kOthers, text) || square_meters(text).has_value();
}

/// The name without a remark in brackets at its end: `Höhe (gemessen)`.
std::string without_remark(const std::string& name) {
  const std::size_t open = name.find_first_of("([");
  return open == std::string::npos || open == 0 ? name : name.substr(0, open);
}

std::optional<MeantName> look_up(const std::string& key) {
  if (key.empty()) return std::nullopt;
  for (const TreeColumn& column : tree_columns()) {
    if (key == folded_letters(column.name)) return MeantName{column.name, NameFit::kSpelling, ""};
  }
  for (const TreeColumn& column : tree_columns()) {
    if (has_word(column.usual, key)) return MeantName{column.name, NameFit::kUsual, ""};
  }
  for (const TreeColumn& column : tree_columns()) {
    if (has_word(column.vague, key)) return MeantName{column.name, NameFit::kVague, ""};
  }
  for (const TreeColumn& column : tree_columns()) {
    if (!has_word(column.converted, key)) continue;
    return MeantName{column.name, NameFit::kConverted, column.conversion};
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> square_meters(std::string_view unit) {
  if (has_word("m2 m² qm sqm", unit)) return 1.0;
  if (unit == "ha") return 1e4;
  if (has_word("ac acre acres", unit)) return kSquareMetersPerAcre;
  if (has_word("ft2 ft² sqft", unit)) return 0.3048 * 0.3048;
  return std::nullopt;
}

bool is_per_acre(std::string_view header) {
  const std::string letters = folded_letters(header);
  if (has_word(kPerAcreNames, letters)) return true;
  for (const std::string_view end : {"peracre", "/acre", "/ac"}) {
    std::string text = end.front() == '/' ? folded(header) : letters;
    while (!text.empty() && is_separator(text.back())) text.pop_back();
    if (text.ends_with(end)) return true;
  }
  return false;
}

HeaderParts header_parts(std::string_view header) {
  std::string text = folded(header);
  // R replaces signs by dots, so that "DBH (cm)" becomes "DBH..cm.".
  while (!text.empty() && is_separator(text.back())) text.pop_back();
  const std::size_t begin = last_word(text);
  const std::string word = text.substr(begin);
  HeaderParts parts{.name = text};
  if (begin == 0) return parts;
  parts.unit = unit_of_length(word);
  if (!parts.unit && is_other_unit(word)) parts.other_unit = word;
  if (!parts.unit && parts.other_unit.empty()) return parts;
  text.resize(begin);
  while (!text.empty() && is_separator(text.back())) text.pop_back();
  if (text.ends_with(" in")) text.resize(text.size() - 3);
  if (parts.unit && parts.unit->name == "m" && ends_with_height(text)) parts.unit.reset();
  parts.name = text;
  return parts;
}

std::optional<LengthUnit> unit_of_length(std::string_view text) {
  std::string name = folded(text);
  const auto word = std::ranges::find(kUnitWords, name, &UnitWord::word);
  if (word != kUnitWords.end()) name = word->unit;
  const auto unit = std::ranges::find(kUnits, name, &LengthUnit::name);
  return unit == kUnits.end() ? std::nullopt : std::optional(*unit);
}

std::optional<LengthUnit> unit_in_header(std::string_view header) {
  return header_parts(header).unit;
}

bool is_in_gon(std::string_view header) { return is_gon(header_parts(header).other_unit); }

bool is_gon(std::string_view unit) { return unit == "gon" || unit == "gons"; }

std::optional<MeantName> meant_name(std::string_view header) {
  const HeaderParts parts = header_parts(header);
  std::optional<MeantName> meant = look_up(folded_letters(parts.name));
  if (!meant) meant = look_up(folded_letters(without_remark(parts.name)));
  if (!meant) return meant;
  const bool is_angle = meant->name == "azimuth";
  const bool is_length = !is_angle && !tree_column(meant->name)->unit.empty();
  if ((parts.unit && !is_length) || (!parts.other_unit.empty() && !is_angle)) return std::nullopt;
  return meant;
}

}  // namespace silvafit::stand
