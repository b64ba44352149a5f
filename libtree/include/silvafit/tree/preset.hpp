// SPDX-License-Identifier: MIT
// Species presets: everything about a tree's looks that is not measured.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/tree/branch_count.hpp"
#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/taper.hpp"
#include "silvafit/tree/tuft.hpp"

namespace silvafit::tree {

/// Linear RGB color, each 0 .. 1.
using Color = std::array<double, 3>;

/// Angles from the vertical in one layer of the crown: normal, truncated to [low, high]; the mean
/// is the middle and the standard deviation a quarter of the interval.
struct AngleLayer {
  double from = 0.0;  ///< share of the crown's length, from the crown base, where the layer begins
  double low_deg = 0.0;
  double high_deg = 0.0;
};

enum class Arrangement { kWhorls, kSpiral };

/// Whorls where the age is known: each year's shoot bears `low` to `high` of them, `spacing_m`
/// apart from its base up.
struct YearlyWhorls {
  int low = 3;
  int high = 5;
  double spacing_m = 0.05;
};

/// Limbs among the first-order branches that are nearly as thick as the stem: it divides there.
struct Fork {
  int limbs = 0;
  double from = 0.05;  ///< where they start, shares of the crown's length
  double to = 0.25;
  double low_deg = 20.0;  ///< angle from the vertical
  double high_deg = 40.0;
  double thickness = 0.75;  ///< diameter at the base as a share of the stem's there
};

/// First-order branches.
struct Branching {
  Arrangement arrangement = Arrangement::kWhorls;
  int per_whorl = 4;
  double spacing_m = 0.3;         ///< between whorls, or between branches of a spiral
  double tip_density = 1.0;       ///< how much closer they get towards the tip; 1: evenly spaced
  int least = 8;                  ///< branches of the smallest tree
  int most = 96;                  ///< closer spacing is widened to stay below this number
  double divergence_deg = 137.5;  ///< of a spiral
  double azimuth_sd_deg = 10.0;
  double sag = 0.0;          ///< bow at mid-length as a share of the length; < 0 hangs, > 0 arches
  double crookedness = 0.0;  ///< how far a branch strays from its line, as a share of its length
  double thickness = 0.014;  ///< diameter at the base as a share of the length
  double thickest = 0.5;     ///< the same, at most this share of the stem's diameter
  double stem_bend = 0.0;    ///< how far the stem winds in the crown, as a share of its radius
  int segments = 3;          ///< straight pieces of a branch
  std::vector<AngleLayer> layers{};
  std::optional<YearlyWhorls> yearly{};
  Fork fork{};
};

enum class TwigArrangement { kPairs, kSpiral };

/// Branches of the second order, or of the third, along one of the order before.
struct Twigs {
  TwigArrangement arrangement = TwigArrangement::kPairs;  ///< two by two in a plane, or all round
  double spacing_m = 0.25;                                ///< between pairs, or single twigs
  int least = 4;                                          ///< pairs, or single twigs
  int most = 14;
  double angle_low_deg = 50.0;  ///< between twig and branch
  double angle_high_deg = 100.0;
  double from = 0.2;             ///< share of the branch's length that stays bare
  double relative_length = 0.4;  ///< of the first twig, as a share of the branch's length
  double tip_length = 0.25;      ///< of the last twig, as a share of the first one's
  double spread_deg = 15.0;      ///< how far twigs leave the plane, or their place in the spiral
  double lift = 0.0;             ///< how much they turn upwards; 1 as much as outwards
  bool has_wood = false;         ///< thick enough to be drawn as wood
  int segments = 1;              ///< straight pieces of a twig
};

enum class FoliageKind { kNeedles, kLeaves };

/// Foliage hangs on twigs and on the ends of branches.
struct Foliage {
  FoliageKind kind = FoliageKind::kNeedles;
  double fullness = 0.55;    ///< needles: how far the gaps between twigs are filled, from 0 to 1
  double lift = 0.35;        ///< needles: how far tips stand above and below a twig, per its length
  double droop = 0.3;        ///< needles: how far a spray's edges hang, as a share of their width
  int tufts_per_shoot = 1;   ///< leaves: tufts along a shoot, besides the one at its tip
  int leaves_per_tuft = 16;  ///< in a spiral
  double leaf_length_m = 0.35;  ///< in a crown 5 m wide and 7 m long
  double leaf_aspect = 0.6;     ///< width by length
  Color inner{};                ///< color in the shade near the stem
  Color outer{};                ///< color at the crown's surface
  double color_variation = 0.1;
  Tuft tuft{};  ///< leaves: made of the numbers above
};

/// Everything about a species' looks. Every number has its origin in `basis`: measured, from which
/// source, or guessed.
struct Preset {
  std::string name{};
  std::string title{};
  std::vector<std::string> species{};  ///< names, genera and codes that choose this preset
  CrownIndex crown_index{};
  double relative_hc = 0.3;
  Branching branching{};
  Twigs twigs{};                  ///< of the second order
  std::optional<Twigs> shoots{};  ///< of the third order
  Foliage foliage{};
  Color bark{};
  Taper taper{};
  std::optional<BranchCount> branch_count{};
};

/// The presets of a folder models/, with the equations that they name.
class PresetCatalogue {
 public:
  /// \param models  folder with presets/, taper/ and branch_count/
  /// \throws InputError naming the file and the field if an entry cannot be used
  static PresetCatalogue load(const std::filesystem::path& models);

  /// Presets by name, in alphabetical order.
  const std::vector<Preset>& presets() const { return presets_; }

  /// \throws UsageError with the names there are
  const Preset& named(std::string_view name) const;

  /// The preset for a species: by full name or code, else by genus, regardless of case; null if no
  /// preset lists it.
  const Preset* for_species(std::string_view species) const;

  /// The preset for species that none lists.
  const Preset& fallback() const { return named("generic-broadleaf"); }

 private:
  std::vector<Preset> presets_;
};

}  // namespace silvafit::tree
