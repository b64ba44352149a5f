// SPDX-License-Identifier: MIT
#include "leaf_look_entry.hpp"

#include "preset_head.hpp"

namespace silvafit::tree {
namespace {

LeafForm form_of(const JsonEntry& entry) {
  const auto name = entry.get<std::string>("form");
  if (name == "five-polygons") return LeafForm::kFivePolygons;
  if (name == "needle-fan") return LeafForm::kNeedleFan;
  throw InputError("must be \"five-polygons\" or \"needle-fan\"", entry.place_of("form"));
}

std::vector<std::array<double, 2>> outline_of(const JsonEntry& entry) {
  constexpr std::size_t kLeast = 3;
  constexpr std::size_t kMost = 64;
  const auto outline = entry.get<std::vector<std::array<double, 2>>>("outline");
  if (outline.size() < kLeast || outline.size() > kMost) {
    throw InputError("must have 3 to 64 points on one side of the leaf", entry.place_of("outline"));
  }
  for (const auto& [across, along] : outline) {
    if (!(across > 0.0 && across <= 1.0 && along >= -1.0 && along <= 1.0)) {
      throw InputError("points are (across, along) with across in (0, 1] and along in [-1, 1]",
                       entry.place_of("outline"));
    }
  }
  return outline;
}

LeafLook look_of(const JsonEntry& entry) {
  entry.allow_only({"form", "aspect", "outline", "color", "color_variation"});
  LeafLook look;
  look.form = form_of(entry);
  look.aspect = entry.number("aspect", 0.01, 4.0);
  if (entry.has("outline")) look.outline = outline_of(entry);
  look.color = color_of(entry, "color");
  look.color_variation = entry.number("color_variation", 0.0, 1.0);
  return look;
}

}  // namespace

std::vector<LeafLook> leaf_looks_of(const JsonEntry& preset) {
  std::vector<LeafLook> looks;
  for (const JsonEntry& entry : preset.children("leaves")) looks.push_back(look_of(entry));
  return looks;
}

}  // namespace silvafit::tree
