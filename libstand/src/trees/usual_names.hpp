// SPDX-License-Identifier: MIT
// Usual names of the columns of inventories, in several languages, and their units.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace silvafit::stand {

/// How well the name of a column matches a standard name; smaller is better.
enum class NameFit { kSpelling, kUsual, kVague, kConverted };

/// A standard name that the header of a column may mean.
struct MeantName {
  std::string_view name{};  ///< plot, dbh, status ...
  NameFit fit = NameFit::kSpelling;
  std::string_view conversion{};  ///< TreeColumn::conversion, of a kConverted name
};

/// The standard name that a header means, independent of case, accents, blanks, underscores and
/// unit; none if it is not a usual name.
std::optional<MeantName> meant_name(std::string_view header);

/// A unit of length.
struct LengthUnit {
  std::string_view name{};  ///< mm, cm, dm, m, in, ft or yd
  double meters = 1.0;
};

/// A header in lower case and without accents, split into its name and its unit.
struct HeaderParts {
  std::string name{};
  std::optional<LengthUnit> unit{};
  std::string other_unit{};  ///< such as ha or degrees
};
HeaderParts header_parts(std::string_view header);

inline constexpr double kSquareMetersPerAcre = 4046.8564224;

/// Names of trees per acre, in folded letters, and their factor to trees per hectare.
inline constexpr std::string_view kPerAcreNames =
    "tpa tpac tpaunadj treesperacre stemsperacre treesac stemsac nac expac expfac peracre";
/// Whether a header is one of them or has such a unit, as in `N per acre` and `EXPF (1/ac)`.
bool is_per_acre(std::string_view header);
inline constexpr double kPerAcre = 1e4 / kSquareMetersPerAcre;
/// Whether a header is a usual name of the trees per hectare or acre that a row stands for.
bool is_expansion_name(std::string_view header);

/// The square meters of a unit of area, such as ha or ac; none if it is not one.
std::optional<double> square_meters(std::string_view unit);

/// The unit of length in the header of a column, such as `DBH (cm)`, `h [m]`, `DBH_mm`, `BHD in cm`
/// or `d/mm`; none if there is no unit.
std::optional<LengthUnit> unit_in_header(std::string_view header);

/// The degrees of a unit of angles other than degrees: gon (400 a circle), mil (6400) or radian.
std::optional<double> degrees_of(std::string_view unit);

/// The unit of length that a text names, in words or as its symbol.
std::optional<LengthUnit> unit_of_length(std::string_view text);

}  // namespace silvafit::stand
