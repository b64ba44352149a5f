// SPDX-License-Identifier: MIT
#include "mesh/leaf_look.hpp"

#include <cmath>

#include "catalogue/preset_head.hpp"

namespace silvafit::tree {
namespace {

std::vector<std::array<double, 2>> outline_of(const data::JsonReader& entry) {
  auto outline = rows_of<2>(entry);
  std::array<double, 2> before{1.0, -1.0};
  for (const auto& [across, along] : outline) {
    // Seen from the petiole, each point is to the left of the previous one, also with lobes.
    const bool is_left = along * before[0] > before[1] * across;
    if (!(across > 0.0 && across <= 1.0 && std::abs(along) < 1.0 && is_left)) {
      entry.fail(
          "must be [across, along] with across in (0, 1] and along in (-1, 1), in angular order "
          "around the end of the petiole, from the base to the tip");
    }
    before = {across, along};
  }
  constexpr std::size_t kLeast = 3;
  if (outline.size() < kLeast) {
    entry.fail("must have at least three points");
  }
  return outline;
}

}  // namespace

LeafLook leaf_look_of(const data::JsonReader& entry) {
  LeafLook look;
  read_numbers(
      entry,
      {{"aspect", &look.aspect, 0.05, 2.0}, {"color_variation", &look.color_variation, 0.0, 0.5}},
      {"form", "color", "outline"});
  look.form = entry.at("form").one_of({"five-polygons", "needle-fan"}) == 0
                  ? LeafForm::kFivePolygons
                  : LeafForm::kNeedleFan;
  look.color = color_of(entry.at("color"));
  if (entry.has("outline")) look.outline = outline_of(entry.at("outline"));
  return look;
}

}  // namespace silvafit::tree
