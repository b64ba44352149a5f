// SPDX-License-Identifier: MIT
// What columns of inventories are usually called, in several languages, and their units.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace silvafit::stand {

/// How well the name of a column fits one of ours; smaller is better.
enum class NameFit { kSpelling, kUsual, kVague };

/// A name of ours that a column's header may mean.
struct MeantName {
  std::string_view name{};  ///< of ours: plot, dbh, status ...
  NameFit fit = NameFit::kSpelling;
};

/// What the header of a column means, whatever its capitals, accents, blanks, underscores and unit;
/// none if it is no usual name.
std::optional<MeantName> meant_name(std::string_view header);

/// A unit of length.
struct LengthUnit {
  std::string_view name{};  ///< mm, cm, dm, m, in or ft
  double meters = 1.0;
};

/// The unit of length in the header of a column, such as `DBH (cm)`, `h [m]`, `DBH_mm`, `BHD in cm`
/// or `d/mm`; none if it names none.
std::optional<LengthUnit> unit_in_header(std::string_view header);

/// The unit of length that a text is, in words or as its sign.
std::optional<LengthUnit> unit_of_length(std::string_view text);

}  // namespace silvafit::stand
