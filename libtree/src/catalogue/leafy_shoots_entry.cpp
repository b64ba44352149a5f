// SPDX-License-Identifier: MIT
#include "catalogue/leafy_shoots_entry.hpp"

#include "catalogue/preset_head.hpp"

namespace silvafit::tree {
namespace {

ShootKind shoot_kind_of(const data::JsonReader& entry) {
  std::vector<std::string_view> names;
  for (const auto& [name, kind] : shoot_kinds()) names.emplace_back(name);
  return shoot_kinds()[entry.one_of(names)].second;
}

}  // namespace

LeafyShoots leafy_shoots_of(const data::JsonReader& entry) {
  LeafyShoots shoots{.picture = shoot_kind_of(entry.at("picture"))};
  read_numbers(entry,
               {{"length_m", &shoots.length_m, 0.05, 3.0},
                {"leaf_area_index", &shoots.leaf_area_index, 0.1, 20.0},
                {"angle_deg", &shoots.angle_deg, 0.0, 120.0},
                {"lift", &shoots.lift, -2.0, 2.0},
                {"cross_deg", &shoots.cross_deg, 10.0, 90.0}},
               {"picture", "whole_twigs"});
  shoots.is_whole_twig = entry.has("whole_twigs") && entry.at("whole_twigs").boolean();
  return shoots;
}

BarkKind bark_kind_of(const data::JsonReader& entry) {
  const auto bark = entry.find("bark");
  return bark && bark->one_of({"smooth", "furrowed"}) == 1 ? BarkKind::kFurrowed
                                                           : BarkKind::kSmooth;
}

}  // namespace silvafit::tree
