// SPDX-License-Identifier: MIT
// Foliage as pictures of leafy shoots on crossed cards.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string_view>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/tree/texture_library.hpp"

namespace silvafit::tree {

/// Linear RGB color, each 0 .. 1.
using Color = std::array<double, 3>;

enum class Season { kSummer, kAutumn, kWinter, kSpring };
constexpr std::array<std::string_view, 4> words_of(Season /*season*/) {
  return {"summer", "autumn", "winter", "spring"};
}

/// Shoots along the branches of a tree: two crossed cards each.
struct LeafyShoots {
  std::shared_ptr<const ShootPicture> picture{};
  /// Length of the pictured shoot, at which its leaves have their true size [m].
  double length_m = 0.6;
  /// Area of the leaves (one side) by the area of the crown's projection. It gives the number of
  /// shoots, unless this would be too many.
  double leaf_area_index = 5.0;
  double angle_deg = 40.0;  ///< between a shoot and its branch
  double lift = 0.3;        ///< how far shoots turn up (or down, if negative), relative to outward
  double cross_deg = 90.0;  ///< between the two cards; the first one faces up
  /// How far from the wood shoots fill the outer part of the crown, in lengths of a shoot; 0: they
  /// are along the twigs.
  double reach = 0.0;
  /// Depth of the grooves between the boughs of a crown that shoots fill, by the crown's radius.
  double groove = 0.0;
  /// A shoot is a whole twig, from its base to its tip, as a pinna of a fern. The twigs then give
  /// the number and the lengths of the shoots.
  bool is_whole_twig = false;
  bool is_deciduous = false;      ///< without leaves in winter
  std::optional<Color> autumn{};  ///< color of the leaves; else as in summer
  std::optional<Color> spring{};

  bool has_leaves(Season season) const { return !(is_deciduous && season == Season::kWinter); }
  const Color& color(Season season, const Color& summer) const {
    if (season == Season::kAutumn && autumn) return *autumn;
    return season == Season::kSpring && spring ? *spring : summer;
  }
};

}  // namespace silvafit::tree
