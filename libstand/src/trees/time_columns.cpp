// SPDX-License-Identifier: MIT
// Columns of the time of measurement, and of the stem within its tree.
#include <algorithm>

#include "silvafit/base/words.hpp"
#include "silvafit/stand/tree_columns.hpp"
#include "trees/column_sources.hpp"
#include "trees/folded_text.hpp"
#include "trees/known_tables.hpp"

namespace silvafit::stand {
namespace {

/// The first column whose folded letters are one of the words.
std::optional<std::string> column_with_letters(std::string_view words,
                                               const std::vector<std::string>& header) {
  const auto column = std::ranges::find_if(header, [&](const std::string& name) {
    const std::string letters = folded_letters(name);
    return !letters.empty() && has_word(words, letters);
  });
  return column == header.end() ? std::nullopt : std::optional(*column);
}

}  // namespace

std::optional<std::string> usual_time_column(const std::vector<std::string>& header) {
  // A known table documents its times; a column `Date` of it may count days.
  const std::vector<ColumnMapping> known = known_columns(header, false);
  for (const std::string_view name : {"year", "date"}) {
    if (const ColumnMapping* const time = mapping_to(name, known)) return time->source;
  }
  for (const std::string_view name : {"year", "date"}) {
    if (const auto field = field_in_any_case(name, header)) return header[*field];
  }
  // Years, dates and numbers of visits in other tables and languages.
  return column_with_letters(
      "invyr measyear measurementyear inventoryyear surveyyear yearofmeasurement yearmeasured jahr "
      "aufnahmejahr annee anneemesure ano anno anyo rok aar vuosi jaar datum aufnahmedatum fecha "
      "measdate measurementdate inventorydate surveydate exactdate dateofmeasurement censusyear "
      "censusdate census censusid censusno visit visitno visitid visitnumber occasion campaign "
      "campagne "
      "survey surveyno surveynr cycle aufnahme aufnahmenr anomedicao anomedicion mittausvuosi "
      "collectiondate datecollected 年份 年度 调查年份 调查年度 調査年 測定年",
      header);
}

std::optional<std::string> usual_stem_column(const std::vector<std::string>& header) {
  constexpr std::string_view kNames =
      "stem stemid stemno stemnr stemnum stemnumber stemtag fuste trunk trunkid trunkno tallo tige "
      "bole stamm stammnr pien shoot haste tronco brin runko stemletter subtree ramet bifurcacion "
      "teilstamm 幹";
  return column_with_letters(kNames, header);
}

}  // namespace silvafit::stand
