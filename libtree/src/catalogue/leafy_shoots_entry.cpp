// SPDX-License-Identifier: MIT
#include "catalogue/leafy_shoots_entry.hpp"

#include <string>

namespace silvafit::tree {
namespace {

ShootKind shoot_kind_of(const JsonEntry& entry) {
  const auto wanted = entry.get<std::string>("picture");
  std::string names;
  for (const auto& [name, kind] : shoot_kinds()) {
    if (wanted == name) return kind;
    names += std::string(names.empty() ? "" : ", ") + name;
  }
  throw InputError("must be one of " + names, entry.place_of("picture"));
}

}  // namespace

LeafyShoots leafy_shoots_of(const JsonEntry& entry) {
  entry.allow_only(
      {"picture", "length_m", "leaf_area_index", "angle_deg", "lift", "cross_deg", "whole_twigs"});
  LeafyShoots shoots{.picture = shoot_kind_of(entry)};
  shoots.length_m = entry.number("length_m", 0.05, 3.0);
  shoots.leaf_area_index = entry.number("leaf_area_index", 0.1, 20.0);
  shoots.angle_deg = entry.number("angle_deg", 0.0, 120.0);
  shoots.lift = entry.number("lift", -2.0, 2.0);
  shoots.cross_deg = entry.number("cross_deg", 10.0, 90.0);
  shoots.is_whole_twig = entry.has("whole_twigs") && entry.get<bool>("whole_twigs");
  return shoots;
}

BarkKind bark_kind_of(const JsonEntry& entry) {
  const auto kind = entry.has("bark") ? entry.get<std::string>("bark") : std::string("smooth");
  if (kind == "smooth") return BarkKind::kSmooth;
  if (kind == "furrowed") return BarkKind::kFurrowed;
  throw InputError("must be smooth or furrowed", entry.place_of("bark"));
}

}  // namespace silvafit::tree
