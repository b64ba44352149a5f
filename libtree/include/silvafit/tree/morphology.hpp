// SPDX-License-Identifier: MIT
// What is measured on a tree, and what a tree model needs on top of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace silvafit::tree {

/// A place in the inventory's coordinates: x east, y north, z up [m].
struct Position {
  double x_m = 0.0;
  double y_m = 0.0;
  double z_m = 0.0;
};

/// Crown radii in the four directions, from the stem's axis [m].
struct CrownRadii {
  double east_m = 0.0;
  double west_m = 0.0;
  double south_m = 0.0;
  double north_m = 0.0;

  /// Crown width: the mean of the two diameters east-west and south-north [m].
  double width_m() const { return 0.5 * (east_m + west_m + south_m + north_m); }
};

/// What may be measured on a bamboo culm besides; other trees have none of it.
struct CulmForm {
  std::optional<double> bend_deg{};          ///< between the culm's directions at base and tip
  std::optional<double> bend_azimuth_deg{};  ///< towards which the tip leans, from north over east
  std::optional<double> internodes{};        ///< number from the ground to the tip
  std::optional<double> branch_angle_deg{};  ///< mean elevation of branches above the horizontal
};

/// Something that was not measured, or not used as given, and by which rule it was filled in.
struct Note {
  std::string about{};  ///< "hc", "radii", "preset", "branch_count", ...
  std::string text{};
};

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
};

/// Checks that a tree with these numbers can exist.
/// \throws DomainError with plot and tree if one is missing, not finite or out of range
void validate(const Morphology& morphology);

/// The measurements with nothing left open: what the geometry is built from.
struct TreeShape {
  double dbh_cm = 0.0;
  double h_m = 0.0;
  double hcb_m = 0.0;
  double hc_m = 0.0;
  CrownRadii radii{};
  std::optional<double> age_years{};
  CulmForm culm{};
  std::vector<Note> notes{};  ///< which of these were not measured
};

/// Fills in what was not measured: the height of the widest crown at a share of the crown's length,
/// and four equal radii from the crown width.
/// \param relative_hc  (hc - hcb) / (h - hcb) where hc was not measured; in [0, 1]
/// \param source       name of the preset that says so, for the note
/// \throws DomainError as validate()
TreeShape complete(const Morphology& morphology, double relative_hc, const std::string& source);

}  // namespace silvafit::tree
