// SPDX-License-Identifier: MIT
// Measurements of a tree, and the additional values that a tree model needs.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::tree {

/// Height above the ground at which diameters are measured [m].
inline constexpr double kBreastHeight = 1.3;

/// A position in the inventory's coordinates: x east, y north, z up [m].
struct Position {
  double x_m = 0.0;
  double y_m = 0.0;
  double z_m = 0.0;

  bool operator==(const Position&) const = default;
};

/// Crown radii in the four directions, from the stem's axis [m].
struct CrownRadii {
  double east_m = 0.0;
  double west_m = 0.0;
  double south_m = 0.0;
  double north_m = 0.0;

  /// Crown width: the mean of the two diameters east-west and south-north [m].
  double width_m() const { return 0.5 * (east_m + west_m + south_m + north_m); }
  double widest_m() const { return std::max({east_m, west_m, south_m, north_m}); }
  double narrowest_m() const { return std::min({east_m, west_m, south_m, north_m}); }

  bool operator==(const CrownRadii&) const = default;
};

/// Optional measurements of a bamboo culm; other trees have none of them.
struct CulmForm {
  std::optional<double> bend_deg{};          ///< between the culm's directions at base and tip
  std::optional<double> bend_azimuth_deg{};  ///< direction of the tip, from north over east
  std::optional<double> internodes{};        ///< number from the ground to the tip
  std::optional<double> branch_angle_deg{};  ///< mean elevation of branches above the horizontal

  bool operator==(const CulmForm&) const = default;
};

/// A value that was not measured or not used as given, and the rule that replaced it.
struct Note {
  std::string about{};  ///< "hc", "radii", "preset", "branch_count", ...
  std::string text{};
};

/// What is left of a tree.
enum class Remains {
  kAll,    ///< it lives
  kSnag,   ///< dead and standing: wood, by its decay class
  kStump,  ///< it was cut
  kLog,    ///< the stem on the ground
};
constexpr std::array<std::string_view, 4> words_of(Remains /*remains*/) {
  return {"all", "snag", "stump", "log"};
}

/// One tree as measured or predicted.
///
/// Either the four radii or the crown width must be known; the height of the widest crown and the
/// age may be unknown.
struct Morphology {
  std::string plot{};
  std::string tree{};
  std::string species{};
  Position position{};
  double dbh_cm = 0.0;                ///< diameter at 1.3 m; > 0
  double h_m = 0.0;                   ///< tree height; > 1.3
  double hcb_m = 0.0;                 ///< height to crown base; in [0, h)
  std::optional<double> hc_m{};       ///< height of the widest crown; in [hcb, h]
  std::optional<CrownRadii> radii{};  ///< each > 0
  std::optional<double> cw_m{};       ///< crown width, a diameter; > 0; used if radii are unknown
  std::optional<double> age_years{};  ///< in (0, 5000]
  CulmForm culm{};
  Remains remains = Remains::kAll;
  std::string assumed{};                ///< names of h, hcb and cw that were not measured: "h, hcb"
  std::optional<double> decay_class{};  ///< of a snag: 1, 2, 3, 4 or 5 (FIA)

  bool operator==(const Morphology&) const = default;
};

/// Checks that the measurements are possible.
/// \throws DomainError with plot and tree if one is missing, not finite or out of range
void validate(const Morphology& morphology);

/// Checks height and position only, for trees that are drawn as they are.
/// \throws DomainError as validate()
void validate_height(const Morphology& morphology);

/// The complete measurements, from which the geometry is built.
struct TreeShape {
  double dbh_cm = 0.0;
  double h_m = 0.0;
  double hcb_m = 0.0;
  double hc_m = 0.0;
  CrownRadii radii{};
  std::optional<double> age_years{};
  CulmForm culm{};
  std::vector<Note> notes{};  ///< the values that were not measured
};

/// Fills in missing measurements: the height of the widest crown as a proportion of the crown
/// length, and four equal radii from the crown width.
/// \param relative_hc  (hc - hcb) / (h - hcb) if hc was not measured; in [0, 1]
/// \param source       name of the preset with this value, for the note
/// \throws DomainError as validate()
TreeShape complete(const Morphology& morphology, double relative_hc, const std::string& source);

}  // namespace silvafit::tree
