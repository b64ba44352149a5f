// SPDX-License-Identifier: MIT
// Pictures of a crown from the sides and from above.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <memory>
#include <string>

#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// Crowns of similar size and proportions, which share their pictures.
struct CrownClass {
  int width = 0;
  int slenderness = 0;  ///< by length / width

  auto operator<=>(const CrownClass&) const = default;
};

CrownClass class_of(const TreeShape& shape);

/// The tree in the middle of a class. Its crown is the same in all directions, and its widest
/// height is at a row of the picture's grid.
Morphology typical_tree(CrownClass crown, const PresetHead& preset);

/// The pictures, in the order of their cells, row by row: the crown seen against north, west and
/// northwest, and from above.
enum class CrownView { kSouth, kEast, kSoutheast, kAbove };
inline constexpr std::size_t kCrownViews = 4;

/// Texture coordinates are multiples of the atlas' width by this number.
inline constexpr std::size_t kAtlasSteps = 128;
/// The part of a cell with the crown; around it is a transparent border, so that cells do not mix
/// in mipmaps. In steps of the atlas.
inline constexpr std::size_t kCrownSteps = 60;
inline constexpr std::size_t kBorderSteps = 2;

/// Height of the middle above the edge of a crown's roof, the pyramid that has the picture from
/// above.
double roof_rise_m(const TreeShape& shape);

/// Pictures of a typical tree's crown, from its crown base to its top and from its left to its
/// right edge.
struct CrownPictures {
  std::string name{};  ///< of the class, in materials
  std::shared_ptr<const Texture> texture{};
  double relative_hc = 0.3;  ///< of the pictured tree, from the crown base (0) to the top (1)
  Color bark{};              ///< mean of the stem
};

/// The finest mesh of the typical tree from each side.
///
/// The picture is opaque where enough of a pixel is covered. The limit is chosen so that crossed
/// cards, in the mean of all directions, cover the same area as the mesh.
CrownPictures draw_crown(const Builder& builder, CrownClass crown, Season season);

}  // namespace silvafit::tree
