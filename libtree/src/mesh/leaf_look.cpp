// SPDX-License-Identifier: MIT
#include "mesh/leaf_look.hpp"

#include <cmath>

#include "catalogue/preset_head.hpp"

namespace silvafit::tree {
namespace {

LeafForm form_of(const JsonEntry& entry) {
  const auto form = entry.get<std::string>("form");
  if (form == "five-polygons") return LeafForm::kFivePolygons;
  if (form == "needle-fan") return LeafForm::kNeedleFan;
  throw InputError("must be five-polygons or needle-fan", entry.place_of("form"));
}

std::vector<std::array<double, 2>> outline_of(const JsonEntry& entry) {
  auto outline = entry.get<std::vector<std::array<double, 2>>>("outline");
  std::array<double, 2> before{1.0, -1.0};
  for (const auto& [across, along] : outline) {
    // Seen from the petiole, each point is to the left of the previous one, also with lobes.
    const bool is_left = along * before[0] > before[1] * across;
    if (!(across > 0.0 && across <= 1.0 && std::abs(along) < 1.0 && is_left)) {
      throw InputError(
          "must be [across, along] with across in (0, 1] and along in (-1, 1), in angular order "
          "around the end of the petiole, from the base to the tip",
          entry.place_of("outline"));
    }
    before = {across, along};
  }
  constexpr std::size_t kLeast = 3;
  if (outline.size() < kLeast) {
    throw InputError("must have at least three points", entry.place_of("outline"));
  }
  return outline;
}

}  // namespace

LeafLook leaf_look_of(const JsonEntry& entry) {
  entry.allow_only({"form", "aspect", "color", "color_variation", "outline"});
  LeafLook look;
  look.form = form_of(entry);
  look.aspect = entry.number("aspect", 0.05, 2.0);
  look.color = color_of(entry, "color");
  look.color_variation = entry.number("color_variation", 0.0, 0.5);
  if (entry.has("outline")) look.outline = outline_of(entry);
  return look;
}

}  // namespace silvafit::tree
