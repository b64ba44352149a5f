// SPDX-License-Identifier: MIT
#include "silvafit/stand/similar_plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"
#include "trees/folded_text.hpp"

namespace silvafit::stand {
namespace {

bool is_decimal_digit(char c) { return c >= '0' && c <= '9'; }

/// Whole numbers without leading zeros are similar only if they are equal.
bool may_be_similar(std::string_view label) {
  return label.starts_with('0') || !std::ranges::all_of(label, is_decimal_digit);
}

/// A whole number with decimals, as spreadsheets write 1 as 1.0.
bool has_needless_decimals(std::string_view label) {
  const std::size_t point = label.find('.');
  return point != std::string_view::npos && point > 0 && point + 1 < label.size() &&
         std::ranges::all_of(label.substr(0, point), is_decimal_digit) &&
         label.find_first_not_of('0', point + 1) == std::string_view::npos;
}

/// The text with one sign for all dashes, and with blanks between digits only: `A 1` is `A1`.
std::string without_signs(std::string text) {
  for (const std::string_view dash : {"\u2010", "\u2011", "\u2012", "\u2013", "\u2014", "\u2212"}) {
    for (std::size_t at = text.find(dash); at != std::string::npos; at = text.find(dash, at)) {
      text.replace(at, dash.size(), "-");
    }
  }
  std::string kept;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::size_t next = text.find_first_not_of(' ', i);
    const bool is_between_digits = !kept.empty() && is_decimal_digit(kept.back()) &&
                                   next != std::string::npos && is_decimal_digit(text[next]);
    if (text[i] != ' ' || is_between_digits) kept += text[i];
  }
  return kept;
}

/// The label in lower case, without leading zeros and needless decimals of numbers.
std::string similarity_key(const std::string& label) {
  std::string key;
  std::string text = without_signs(folded(label));
  if (has_needless_decimals(text)) text.resize(text.find('.'));
  for (std::size_t i = 0; i < text.size(); ++i) {
    // Not the decimals of 1.05 or 1,05.
    const bool begins_number =
        text[i] == '0' &&
        (i == 0 || (!is_decimal_digit(text[i - 1]) && text[i - 1] != '.' && text[i - 1] != ','));
    const bool has_digit_next = i + 1 < text.size() && is_decimal_digit(text[i + 1]);
    if (begins_number && has_digit_next) {
      i = std::min(text.find_first_not_of('0', i), text.size());
      // 00 is the number 0.
      if (i == text.size() || !is_decimal_digit(text[i])) --i;
    }
    key += text[i];
  }
  return key;
}

bool is_negative(const std::string& label) {
  double value = 0.0;
  return data::parse_number(label, value) && value < 0.0;
}

/// Whether a label is probably a code of missing values. Codes that are words, such as none and nb,
/// may be values.
bool is_likely_code(const std::string& label, const std::vector<std::string>& levels) {
  double value = 0.0;
  if (data::parse_number(label, value)) {
    if (std::isnan(value) || data::is_missing_code(value)) return true;
    return data::is_likely_missing_code(value) && std::ranges::count_if(levels, is_negative) == 1;
  }
  const std::string text = folded(label);
  const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
  const bool is_word = std::ranges::all_of(text, is_letter) && text != "nan" && text != "null";
  return !is_word && data::is_missing_number(label);
}

/// Figures whose names may be anything in other labels.
constexpr std::string_view kShort = "sd std se cv min max var";

}  // namespace

std::string describe_similar_labels(const data::TextColumn& labels, const std::string& of) {
  const std::vector<std::string>& levels = labels.levels();
  for (const std::string& level : levels) {
    if (!is_likely_code(level, levels)) continue;
    return fmt::format(
        "{0} is a label of {1}; if it is a code of missing values, leave these "
        "fields empty, or name it with `missing={0}`",
        level,
        of);
  }
  if (std::ranges::none_of(levels, may_be_similar)) return {};
  std::vector<std::pair<std::string, std::size_t>> keys;
  for (std::size_t code = 0; code < levels.size(); ++code)
    keys.emplace_back(similarity_key(levels[code]), code);
  std::ranges::sort(keys);
  std::vector<std::pair<std::size_t, std::size_t>> similar;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys[i].first == keys[i - 1].first) {
      similar.emplace_back(keys[i - 1].second, keys[i].second);
    }
  }
  if (similar.empty()) return {};
  std::ranges::sort(similar);
  constexpr std::size_t kShown = 3;
  std::string text = of + " labels are compared as text, so these are different: ";
  for (std::size_t i = 0; i < std::min(kShown, similar.size()); ++i) {
    const auto& [first, second] = similar[i];
    text += fmt::format("{}'{}' and '{}'", i > 0 ? ", " : "", levels[first], levels[second]);
  }
  if (similar.size() > kShown) text += fmt::format(" and {} more", similar.size() - kShown);
  return text + fmt::format("; if they are one {}, give it one label in the file", of);
}

bool is_summary_label(std::string_view label, bool is_code) {
  constexpr std::string_view kWords =
      "total totals subtotal grandtotal overall sum sums summe summen gesamt insgesamt "
      "zwischensumme somme totale totaux suma soma mean means average mittel mittelwert "
      "mittelwerte durchschnitt moyenne moy media mediana medianwert promedio median yhteensa "
      "summa keskiarvo "
      "keskihajonta medel "
      "medelvarde gjennomsnitt gjennomsnittlig srednia razem lacznie celkem soucet prumer totaal "
      "gemiddelde jumlah rata ratarata toplam ortalama 合計 合计 総計 总计 小計 小计 平均 平均値 "
      "平均值 总和";
  constexpr std::string_view kFigures =
      "stdev stddev minimum maximum avg variance stabw stdabw standardabweichung ecarttype "
      "desviacion desvio desvpad count nha gha qmd hdom ddom";
  /// In a phrase, these may be names, such as that of a river.
  constexpr std::string_view kNames = "somme soma media rata summa";
  /// What sums and means are of.
  constexpr std::string_view kOf =
      "of the de di da do des le la der per grand area areas plot plots stand tree trees dbh bhd "
      "dap h ht height "
      "hohe altura hauteur ba basal area volume vol n no number num stems parcela parzelle "
      "placette padrao estandar standard deviation type";
  if (label == "Ø" || label == "x̄" || label == "∑" || label == "Σ") return true;
  const std::string letters = folded_letters(label);
  if (letters.empty()) return false;
  if (has_word(kWords, letters)) return true;
  if (is_code) return false;
  if (has_word(kFigures, letters) || has_word(kShort, letters)) return true;
  if (label.ends_with('=')) return true;
  bool has_summary = false;
  const std::string text = folded(label);
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of(" _.:=/-()", begin), text.size());
    const std::string_view word = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    double number = 0.0;
    const bool is_summary =
        (has_word(kWords, word) && !has_word(kNames, word)) || has_word(kFigures, word);
    if (word.empty() || has_word(kOf, word) || data::parse_number(word, number)) continue;
    if (!is_summary) return false;
    has_summary = true;
  }
  return has_summary ||
         has_word("nooftrees numberoftrees ntrees nstems nplots allplots alltrees", letters);
}

bool is_summary_label(std::string_view label,
                      const std::function<bool(std::string_view)>& is_plot) {
  if (is_summary_label(label)) return true;
  for (std::size_t blank = label.find(' '); blank != std::string_view::npos;
       blank = label.find(' ', blank + 1)) {
    const std::string_view begin = data::trimmed(label.substr(0, blank));
    const std::string_view end = data::trimmed(label.substr(blank));
    const bool begins = is_summary_label(begin) && !has_word(kShort, folded_letters(begin));
    if (begins && is_plot(end)) return true;
    if (!is_summary_label(end)) continue;
    const std::size_t word = std::min(begin.find(' '), begin.size());
    const bool has_word_plot =
        has_word("plot parcela parzelle placette stand", folded_letters(begin.substr(0, word)));
    if (is_plot(begin) || (has_word_plot && is_plot(data::trimmed(begin.substr(word)))))
      return true;
  }
  return false;
}

void refuse_unusable_labels(const data::TextColumn& labels,
                            std::string_view name,
                            const std::string& column,
                            const std::string& file) {
  constexpr std::string_view kDigits = "0123456789";
  const auto is_shortened = [&](std::string_view label) {
    const std::size_t e = label.find("E+");
    if (e == std::string_view::npos || e == 0) return false;
    const std::string_view digits = label.substr(0, e);
    const std::size_t mark = std::min(digits.find_first_of(".,"), digits.size());
    const std::size_t decimals = digits.size() - std::min(mark + 1, digits.size());
    double exponent = 0.0;
    return digits.find_first_not_of("0123456789.,") == std::string_view::npos &&
           label.find_first_not_of(kDigits, e + 2) == std::string_view::npos &&
           data::parse_number(label.substr(e + 2), exponent) &&
           exponent > static_cast<double>(decimals);
  };
  const auto is_ditto = [](std::string_view label) {
    return label.find_first_not_of("\"'`,″〃“”„’ ") == std::string_view::npos ||
           has_word("do do. dto. ditto idem id. dº", folded(label));
  };
  const auto ditto = std::ranges::find_if(labels.levels(), is_ditto);
  if (ditto != labels.levels().end() && labels.levels().size() > 1) {
    throw InputError(fmt::format("the {0} '{1}' stands for the one above it: leave these fields "
                                 "empty and use `fill_down={0}`",
                                 name,
                                 *ditto),
                     {.file = file, .column = column});
  }
  const auto found = std::ranges::find_if(labels.levels(), is_shortened);
  if (found == labels.levels().end()) return;
  throw InputError(
      fmt::format("the {} '{}' is a number that a spreadsheet has shortened, so that different "
                  "ones may look the same; export the column as text, or name another one with "
                  "`columns={}=COLUMN`",
                  name,
                  *found,
                  name),
      {.file = file, .column = column});
}

}  // namespace silvafit::stand
