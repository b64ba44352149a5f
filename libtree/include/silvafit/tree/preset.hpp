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
  double thickness = 0.014;  ///< base diameter as a share of the length
  std::vector<AngleLayer> layers{};
};

/// Second-order branches, alternating on both sides of a first-order one.
struct Twigs {
  double spacing_m = 0.25;
  int least = 4;
  int most = 14;
  double angle_low_deg = 50.0;  ///< between twig and branch
  double angle_high_deg = 100.0;
  double from = 0.2;             ///< share of the branch's length that stays bare
  double relative_length = 0.4;  ///< of the longest twig, as a share of the branch's length
  double spread_deg = 15.0;      ///< how far twigs leave the plane of the spray
  bool has_wood = false;         ///< twigs thick enough to be drawn as wood
};

enum class FoliageKind { kNeedles, kLeaves };

/// Foliage hangs on twigs and on the ends of branches.
struct Foliage {
  FoliageKind kind = FoliageKind::kNeedles;
  double width = 0.4;       ///< needle spray: width as a share of the twig's length
  double droop = 0.8;       ///< needle spray: how far its edges hang, as a share of half its width
  int leaves_per_twig = 6;  ///< leaf sprays
  double leaf_length_m = 0.35;  ///< of a spray of leaves in a crown 5 m wide
  double leaf_aspect = 0.6;     ///< width by length
  Color inner{};                ///< color in the shade near the stem
  Color outer{};                ///< color at the crown's surface
  double color_variation = 0.1;
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
  Twigs twigs{};
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
