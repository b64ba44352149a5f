// SPDX-License-Identifier: MIT
// Headers of columns: their names and units.
#include "trees/usual_names.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>
#include <vector>

#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/stand/tree_columns.hpp"
#include "trees/folded_text.hpp"

namespace silvafit::stand {
namespace {

struct UnitWords {
  LengthUnit unit{};
  std::string_view words{};  ///< in lower case and without accents
};
constexpr std::array<UnitWords, 7> kUnits{
    {{{"mm", 0.001},
      "mm millimeter millimeters millimetre millimetres milimetro milimetros millimetri 毫米"},
     {{"cm", 0.01},
      "cm centimeter centimeters centimetre centimetres zentimeter centimetro centimetros "
      "centimetri 厘米 公分"},
     {{"dm", 0.1}, "dm decimeter decimeters decimetre decimetres dezimeter decimetro decimetros"},
     {{"m", 1.0}, "m meter meters metre metres metro metros metri 米 公尺"},
     {{"in", 0.0254},
      "in inch inches zoll pouce pouces pulgada pulgadas polegada polegadas \" '' ″ ”"},
     {{"ft", 0.3048}, "ft foot feet fuss pied pieds ' ′ ’"},
     {{"yd", 0.9144}, "yd yard yards"}}};

bool is_separator(char c) {
  return c == ' ' || c == '_' || c == '.' || c == '/' || c == ',' || c == '-' || c == '(' ||
         c == '[' || c == ')' || c == ']' || c == ':' || c == ';' || c == '`';
}

/// A word of a header, between separators.
struct HeaderWord {
  std::size_t begin = 0;
  std::size_t end = 0;
  bool is_in_brackets = false;
};

std::vector<HeaderWord> words_in(std::string_view text) {
  std::vector<HeaderWord> words;
  bool is_open = false;
  for (std::size_t i = 0; i < text.size();) {
    if (is_separator(text[i])) {
      is_open = text[i] == '(' || text[i] == '[' || (is_open && text[i] != ')' && text[i] != ']');
      ++i;
      continue;
    }
    const std::size_t begin = i;
    while (i < text.size() && !is_separator(text[i])) ++i;
    words.push_back({begin, i, is_open});
  }
  return words;
}

std::string trimmed_of_separators(std::string_view text) {
  while (!text.empty() && is_separator(text.back())) text.remove_suffix(1);
  while (!text.empty() && is_separator(text.front())) text.remove_prefix(1);
  return std::string(text);
}

/// Whether a text ends with the height at which diameters are measured, as in `DBH (1.3 m)` and
/// `at 4.5 ft`.
bool ends_with_height(std::string_view text) {
  constexpr double kHighest = 10.0;
  text = data::trimmed(text);
  const std::size_t blank = text.find_last_of(" _([");
  const std::string_view word = text.substr(blank == std::string_view::npos ? 0 : blank + 1);
  double height = 0.0;
  return data::parse_number(word, height) && height < kHighest;
}

/// A number from the words for parts: a tenth; none for other words.
std::optional<double> part_named(std::string_view word) {
  if (has_word("tenth tenths 10th 10ths zehntel dixieme dixiemes decimo decimos", word)) return 0.1;
  if (has_word("hundredth hundredths 100th 100ths hundertstel centieme centiemes", word)) {
    return 0.01;
  }
  return std::nullopt;
}

/// The factor of a unit in brackets, as in `(0.1 in)`, `(1/10 in)`, `(mm/10)`, `(10ths of inch)`
/// and `(x10 cm)`; 1 without one, none if the number is not understood.
/// \param before, after  the text of the brackets around the unit
std::optional<double> factor_of_unit(std::string_view before, std::string_view after) {
  const auto is_product = [](std::string_view& text, bool at_front) {
    text = data::trimmed(text);
    for (const std::string_view sign : {"x", "*", "×"}) {
      const bool is_there = at_front ? text.starts_with(sign) : text.ends_with(sign);
      if (!is_there) continue;
      at_front ? text.remove_prefix(sign.size()) : text.remove_suffix(sign.size());
      text = data::trimmed(text);
      return true;
    }
    return false;
  };
  const auto number_in = [](std::string_view text) -> std::optional<double> {
    double number = 0.0;
    const bool is_number = data::parse_number(text, number) ||
                           data::parse_number(data::with_decimal_point(text), number);
    return is_number && number > 0.0 ? std::optional(number) : std::nullopt;
  };
  const auto quotient_in = [&](std::string_view text) -> std::optional<double> {
    const std::size_t slash = std::min(text.find('/'), text.size());
    const auto number = number_in(text.substr(0, slash));
    if (slash == text.size() || !number) return number;
    const auto divisor = number_in(text.substr(slash + 1));
    return divisor ? std::optional(*number / *divisor) : std::nullopt;
  };
  after = data::trimmed(after);
  if (after.starts_with('/')) return quotient_in("1" + std::string(after));
  if (is_product(after, true)) return number_in(after);
  is_product(before, false);
  is_product(before, true);
  if (before.ends_with(" of")) before = data::trimmed(before.substr(0, before.size() - 3));
  if (const auto part = part_named(before)) return part;
  if (before.find_first_of("0123456789") == std::string_view::npos) return 1.0;
  return quotient_in(before);
}

/// Units that no measure has.
bool is_other_unit(std::string_view text, bool is_in_brackets) {
  constexpr std::string_view kOthers = "% ° deg degree degrees grad m3 m³ years";
  // Outside of brackets g is the basal area, and rad a radius.
  const bool is_name = !is_in_brackets && has_word("g rad", text);
  return has_word(kOthers, text) || square_meters(text) || (degrees_of(text) && !is_name);
}

/// The word of a header that is its unit: one in brackets, else the last word, else a word that can
/// be nothing else. The first word is the name.
std::optional<HeaderWord> unit_word(std::string_view text) {
  constexpr std::size_t kLong = 5;
  const std::vector<HeaderWord> words = words_in(text);
  std::optional<HeaderWord> last;
  std::optional<HeaderWord> clear;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const HeaderWord& word = words[i];
    const std::string_view own = text.substr(word.begin, word.end - word.begin);
    const bool is_last = i + 1 == words.size();
    const std::optional<LengthUnit> unit = unit_of_length(own);
    if (!unit && !is_other_unit(own, word.is_in_brackets)) continue;
    const bool can_be_height = unit && (unit->name == "m" || unit->name == "ft");
    if (can_be_height && ends_with_height(text.substr(0, word.begin))) continue;
    // "BHD in cm"
    const bool ends_bracket = is_last || !words[i + 1].is_in_brackets;
    if (own == "in" && !is_last && !(word.is_in_brackets && ends_bracket)) continue;
    if (word.is_in_brackets) return word;
    if (is_last) last = word;
    const bool is_clear =
        unit && (own.size() >= kLong || own == "mm" || own == "cm" || own == "dm");
    if (is_clear && !clear) clear = word;
  }
  return last ? last : clear;
}

/// What a header may have behind its unit without meaning another measure: a year, the bark that
/// diameters usually include, and breast height.
bool is_usual_remark(std::string_view text) {
  constexpr std::string_view kRemarks =
      "ob overbark outsidebark withbark mitrinde mr concorteza comcasca surecorce atbh "
      "atbreastheight breastheight bh at13 at13m 13m at45ft 45ft at137m 137m dbh";
  const std::string letters = folded_letters(text);
  const bool is_year =
      letters.size() == 4 && letters.find_first_not_of("0123456789") == std::string::npos;
  return is_year || has_word(kRemarks, letters);
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
  if (has_word("km2 km²", unit)) return 1e6;
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

bool is_expansion_name(std::string_view header) {
  constexpr std::string_view kNames =
      "tph sph spha expf expfactor expansion expansionfactor expfact treefactor treeexpf "
      "treeexpansion factorexpansion factordeexpansion fatordeexpansao facteurdextension nhat";
  constexpr std::string_view kTrees =
      "n no num number tree trees stem stems arb arbre arbres arbol arboles arvore arvores tige "
      "tiges baum baume stamm stamme stk ind individuals individuos";
  const std::string letters = folded_letters(header);
  if (has_word(kNames, letters) || has_word(kPerAcreNames, letters)) return true;
  for (const std::string_view end :
       {"perhectare", "perha", "porha", "parha", "proha", "ha", "peracre", "perac", "acre", "ac"}) {
    if (!letters.ends_with(end)) continue;
    if (has_word(kTrees, letters.substr(0, letters.size() - end.size()))) return true;
  }
  return false;
}

HeaderParts header_parts(std::string_view header) {
  std::string text = folded(header);
  // R replaces signs by dots, so that "DBH (cm)" becomes "DBH..cm.".
  while (!text.empty() && is_separator(text.back())) text.pop_back();
  // `DBH"` has no blank before the unit.
  for (const std::string_view mark : {"''", "\"", "″", "”"}) {
    if (!text.ends_with(mark)) continue;
    text.insert(text.size() - mark.size(), " ");
    break;
  }
  HeaderParts parts{.name = text};
  const std::optional<HeaderWord> word = unit_word(text);
  if (!word) return parts;
  const std::string unit = text.substr(word->begin, word->end - word->begin);
  parts.unit = unit_of_length(unit);
  if (!parts.unit) parts.other_unit = unit;
  parts.name = trimmed_of_separators(std::string_view(text).substr(0, word->begin));
  if (parts.name.ends_with(" in")) parts.name.resize(parts.name.size() - 3);
  std::size_t end = word->end;
  if (word->is_in_brackets) {
    const std::size_t open = text.find_last_of("([", word->begin) + 1;
    end = std::min(text.find_first_of(")]", end), text.size());
    const auto factor = factor_of_unit(text.substr(open, word->begin - open),
                                       text.substr(word->end, end - word->end));
    if (parts.unit && factor) parts.unit->meters *= *factor;
    parts.name = trimmed_of_separators(std::string_view(text).substr(0, open));
  }
  const std::string rest = trimmed_of_separators(std::string_view(text).substr(end));
  if (!rest.empty() && !is_usual_remark(rest)) parts.name += " " + rest;
  return parts;
}

std::optional<LengthUnit> unit_of_length(std::string_view text) {
  const std::string word = folded(text);
  const auto unit = std::ranges::find_if(
      kUnits, [&word](const UnitWords& known) { return has_word(known.words, word); });
  return word.empty() || unit == kUnits.end() ? std::nullopt : std::optional(unit->unit);
}

std::optional<LengthUnit> unit_in_header(std::string_view header) {
  return header_parts(header).unit;
}

std::optional<double> degrees_of(std::string_view unit) {
  if (has_word("gon gons neugrad grade grades gr g grads gradian gradians", unit)) return 0.9;
  if (has_word("mil mils", unit)) return 360.0 / 6400.0;
  if (has_word("rad radian radians", unit)) return 180.0 / std::numbers::pi;
  return std::nullopt;
}

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
