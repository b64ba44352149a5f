// SPDX-License-Identifier: MIT
// Bamboo: culms with nodes, branches in pairs, images of leaves.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "bamboo/cloud_model.hpp"
#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/smooth_mesh.hpp"

namespace silvafit::tree {

/// The culm: straight up to breast height and the crown base, bent above.
struct CulmStyle {
  double bend_deg = 3.0;  ///< between the directions at base and tip, if not measured
  double bend_sd_deg = 1.5;
  double sun_azimuth_deg = 180.0;  ///< direction in which culms lean, from north over east
  double sun_azimuth_sd_deg = 60.0;
  /// How far the upper culm bows before its tip nods to the other side, by the crown's length. None
  /// if the bend was measured; less in a narrow crown.
  double nod = 0.03;
  double internode_m = 0.26;  ///< mean length, if the number of internodes was not measured
  int internodes_least = 8;
  int internodes_most = 90;
  double internodes_sd = 0.05;  ///< of the number, relative to it
  double internode_base = 0.2;  ///< length of the first, relative to the longest
  double internode_top = 0.3;   ///< of the last
  double longest_at = 0.45;     ///< position of the longest, relative to the number of internodes
  double internode_length_sd = 0.03;
  double ridge_height = 0.05;  ///< of a node's ridge, relative to the culm's radius
  double ridge_m = 0.025;      ///< from its middle to its end
};

/// First-order branches: two at each node of the crown, nodes alternating between two sides.
struct CulmBranching {
  NormalCloud angle{};            ///< elevation above the horizontal at the base [deg]
  std::size_t values = 14;        ///< of the cloud model from which branches draw
  double angle_sd_deg = 1.5;      ///< of a culm's expectation, if not measured
  double mu = 4.0;                ///< of the logistic map that gives the azimuths
  double pair_spread_deg = 40.0;  ///< between the two branches of a node
  double second_length = 0.72;    ///< of the second branch, relative to the first
  double length_low = 0.82;       ///< of the first: proportions of the distance to the crown curve
  double length_high = 1.0;
  double bend_deg = 34.0;  ///< downward, between base and tip
  double bend_sd_deg = 8.0;
  double tip_bend_deg = 34.0;  ///< of those at the culm's tip, which hang to the side it nods to
  double thickness = 0.009;    ///< diameter at the base by length
  double thickest = 0.35;      ///< diameter at the base relative to the culm's
  int segments = 5;
};

/// Second-order branches, on both sides of the first-order branches.
struct CulmTwigs {
  double spacing_m = 0.16;
  int least = 3;
  int most = 8;
  double from = 0.3;  ///< proportion of the branch below which there are none
  double angle_deg = 46.0;
  double angle_sd_deg = 7.0;
  double relative_length = 0.4;  ///< of the first one, relative to the branch
  double tip_length = 0.45;      ///< of the last one, relative to the first
  double droop = 0.08;           ///< bow at mid-length
};

/// Amount of light on a leaf: weights, which sum to 1, of four values in [0, 1].
struct LeafLight {
  double outer = 0.4;   ///< distance from the axis relative to the crown's radius
  double height = 0.2;  ///< height relative to the crown's
  double sun = 0.25;    ///< position towards the sunny side
  double order = 0.15;  ///< 1 on second-order branches, 0 on those of the first order
  double sd = 0.07;     ///< of a random term
};

/// Images of a spray of leaves: dark ones in the shade and bright ones in the sun.
struct CulmLeaves {
  int per_twig = 3;
  double length_m = 0.26;  ///< of an image, in a crown of crown_radius_m
  double crown_radius_m = 1.2;
  double aspect = 0.85;
  double droop = 0.35;  ///< how far it hangs below the twig's direction
  LeafForm form = LeafForm::kCrossedCards;
  LeafLight light{};
  int picture_size = 64;  ///< of each image in the texture [pixels], a power of two
  /// By color weight, the darkest first.
  std::vector<std::shared_ptr<const Texture>> pictures{};
  /// Without images: leaves of a spray, width by length, and length relative to the
  /// spray's.
  int leaves_per_spray = 5;
  double leaf_aspect = 0.13;
  double leaf_length = 0.42;
};

/// All parameters of the appearance of a bamboo.
struct BambooPreset : PresetHead {
  CulmStyle culm{};
  CulmBranching branches{};
  CulmTwigs twigs{};
  CulmLeaves leaves{};
};

/// Grows bamboo.
///
/// The culm is a closed tube with a ridge at each node except at breast height; it bends above
/// breast height and the crown base, as far as it stays in the crown. Branches draw their elevation
/// from a cloud model and their azimuth from a logistic map. A branch starts at the crown base, and
/// four end at the crown's widest points, measured from the culm's axis at its base. Measured
/// values of a culm (TreeShape::culm) replace those of the preset. One tree keeps its nodes and
/// branches when its crown is measured again.
///
/// With MeshOptions::textured a spray of leaves is a card, or two crossed ones, with the image of
/// its grade; without, each of its leaves is drawn as polygons.
///
/// Source: Liu et al. 2022, visual modeling of Phyllostachys pubescens; see docs/tree-builders.md.
class BambooBuilder : public Builder {
 public:
  /// \param models  folder with taper/ and bark/
  /// \throws InputError naming the file and the field if it cannot be used
  static std::unique_ptr<BambooBuilder> load(const std::filesystem::path& models,
                                             const std::filesystem::path& file);

  explicit BambooBuilder(BambooPreset preset);

  const BambooPreset& preset() const override { return preset_; }

  Skeleton grow_skeleton(const TreeShape& shape,
                         const Crown& crown,
                         Random& random,
                         const MeshOptions& mesh = {}) const override;
  Mesh build_mesh(const Skeleton& skeleton,
                  const Crown& crown,
                  Random& random,
                  const MeshOptions& options) const override;

 private:
  BambooPreset preset_;
  SmoothStyle pictures_{};  ///< looks of cards
  SmoothStyle single_leaves_{};
};

/// Heights of the nodes above the ground, without the tip: internodes are short at the base,
/// longest in the middle, short at the top.
/// \param internodes  number, at least 1
std::vector<double> node_heights_m(const CulmStyle& style,
                                   double h_m,
                                   int internodes,
                                   Random& random);

/// The relative amount of light on a leaf, in [0, 1].
/// \param order  of its branch
double leaf_light(const LeafLight& light,
                  const Crown& crown,
                  double sun_azimuth_deg,
                  Point at,
                  std::uint32_t order);

}  // namespace silvafit::tree
