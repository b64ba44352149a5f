// SPDX-License-Identifier: MIT
// Species presets: all parameters of a tree's appearance that are not measured.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/tree/branch_count.hpp"
#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/leafy_shoots.hpp"
#include "silvafit/tree/point.hpp"
#include "silvafit/tree/taper.hpp"

namespace silvafit::tree {

/// Angles from the vertical in one layer of the crown: normal, truncated to [low, high]; the mean
/// is the middle and the standard deviation a quarter of the interval.
struct AngleLayer {
  double from = 0.0;  ///< relative crown length, from the crown base, at which the layer begins
  double low_deg = 0.0;
  double high_deg = 0.0;
};

enum class Arrangement { kWhorls, kSpiral };

/// Whorls for known ages: each year's shoot has `low` to `high` of them, spread along it.
struct YearlyWhorls {
  int low = 3;
  int high = 5;
};

/// Limbs among the first-order branches that are nearly as thick as the stem, which divides there.
struct Fork {
  int limbs = 0;
  double from = 0.05;  ///< where they start, relative to the crown length
  double to = 0.25;
  double low_deg = 20.0;  ///< angle from the vertical
  double high_deg = 40.0;
  double thickness = 0.75;  ///< diameter at the base relative to the stem's there
};

/// First-order branches.
struct Branching {
  Arrangement arrangement = Arrangement::kWhorls;
  int per_whorl = 4;
  double spacing_m = 0.3;         ///< between whorls, or between branches of a spiral
  double whorl_spread = 0.0;      ///< height over which a whorl's branches start, by its spacing
  double tip_density = 1.0;       ///< decrease of the spacing towards the tip; 1: constant
  int least = 8;                  ///< branches of the smallest tree
  int most = 96;                  ///< spacing is increased to stay below this number
  double divergence_deg = 137.5;  ///< of a spiral
  double azimuth_sd_deg = 10.0;
  double sag = 0.0;          ///< bow at mid-length relative to the length; < 0 hangs, > 0 arches
  double crookedness = 0.0;  ///< random deviation of a branch from its line, relative to its length
  double thickness = 0.014;  ///< diameter at the base relative to the length
  double thickest = 0.5;     ///< the same, at most this proportion of the stem's diameter
  double stem_bend = 0.0;    ///< deviation of the stem in the crown, relative to its radius
  int segments = 3;          ///< straight pieces of a branch
  std::vector<AngleLayer> layers{};
  std::optional<YearlyWhorls> yearly{};
  Fork fork{};
};

enum class TwigArrangement { kPairs, kSpiral };

/// Second-order or third-order branches along their parent branch.
struct Twigs {
  TwigArrangement arrangement = TwigArrangement::kPairs;  ///< in pairs in a plane, or all round
  double spacing_m = 0.25;                                ///< between pairs, or single twigs
  int least = 4;                                          ///< pairs, or single twigs
  int most = 14;
  double angle_low_deg = 50.0;  ///< between twig and branch
  double angle_high_deg = 100.0;
  double from = 0.2;             ///< proportion of the branch's length without twigs
  double relative_length = 0.4;  ///< of the first twig, relative to the branch's length
  double tip_length = 0.25;      ///< of the last twig, relative to the first one's
  double spread_deg = 15.0;      ///< random deviation from the plane or the spiral
  double lift = 0.0;             ///< how much they turn upwards; 1 as much as outwards
  bool has_wood = false;         ///< thick enough to be drawn as wood
  int segments = 1;              ///< straight pieces of a twig
};

/// Leaves in a golden-angle spiral about the end of a shoot that grows along z and ends at the
/// origin. A leaf has length 1; it is folded along its middle.
///
/// Corners of neighboring leaves that are close to each other are merged: the leaves are less
/// regular, and the tuft has a third of the points.
struct Tuft {
  /// Indices of a leaf's points: base, right, tip, left.
  using Leaf = std::array<std::uint8_t, 4>;

  std::vector<Point> points{};
  std::vector<Leaf> leaves{};

  /// \param leaves  2 to 60
  /// \param aspect  width by length of a leaf, > 0
  static Tuft of(int leaves, double aspect);
};

enum class FoliageKind { kNeedles, kLeaves };

/// Foliage hangs on twigs and on the ends of branches.
struct Foliage {
  FoliageKind kind = FoliageKind::kNeedles;
  double fullness = 0.55;   ///< needles: filled proportion of the gaps between twigs, from 0 to 1
  double lift = 0.35;       ///< needles: height of tips above and below a twig, per its length
  double droop = 0.3;       ///< needles: how far a spray's edges hang, relative to their width
  int tufts_per_shoot = 1;  ///< leaves: tufts along a shoot, besides the one at its tip
  double leaf_length_m = 0.35;  ///< in a crown 5 m wide and 7 m long
  Color inner{};                ///< color in the shade near the stem
  Color outer{};                ///< color at the crown's surface
  double color_variation = 0.1;
  Tuft tuft{};
};

/// The bark of stem, branches and roots.
struct Bark {
  Color color{};                                 ///< without textures
  std::shared_ptr<const BarkPicture> picture{};  ///< with textures
  /// Colors where the bark has these diameters, relative to that at breast height, in increasing
  /// order; in between they change gradually. Empty: `color` everywhere.
  struct Shade {
    double relative_diameter = 0.0;
    Color color{};
  };
  std::vector<Shade> shades{};
};

/// The fields that presets of all builders have.
struct PresetHead {
  std::string name{};
  std::string title{};
  std::vector<std::string> species{};  ///< names, genera and codes that select this preset
  CrownIndex crown_index{};
  double relative_hc = 0.3;
  Taper taper{};
  Bark bark{};
  Color leaf{};  ///< mean color, for drawings without meshes
};

/// A preset of the builder segment. `basis` in its file gives the origin of every number: measured,
/// with the source, or guessed.
struct Preset : PresetHead {
  Branching branching{};
  Twigs twigs{};                  ///< of the second order
  std::optional<Twigs> shoots{};  ///< of the third order
  Foliage foliage{};              ///< without textures
  LeafyShoots leafy_shoots{};     ///< with textures
  std::optional<BranchCount> branch_count{};
};

}  // namespace silvafit::tree
