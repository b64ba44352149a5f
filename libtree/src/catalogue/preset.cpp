// SPDX-License-Identifier: MIT
#include <utility>

#include "catalogue/leafy_shoots_entry.hpp"
#include "catalogue/preset_head.hpp"

namespace silvafit::tree {
namespace {

std::vector<AngleLayer> layers_of(const data::JsonReader& entry) {
  std::vector<AngleLayer> layers;
  for (const auto& [from, low, high] : rows_of<3>(entry)) {
    const bool ascends = layers.empty() ? from == 0.0 : from > layers.back().from && from < 1.0;
    if (!ascends || !(low > 0.0 && low < high && high <= 90.0)) {
      entry.fail(
          "must be [from, low, high] with increasing 'from', starting at 0, and angles in (0, 90]");
    }
    layers.push_back({from, low, high});
  }
  if (layers.empty()) entry.fail("must have at least one layer");
  return layers;
}

Fork fork_of(const data::JsonReader& entry) {
  Fork fork;
  read_numbers(entry,
               {{"limbs", &fork.limbs, 1, 6},
                {"from", &fork.from, 0.0, 0.9},
                {"low_deg", &fork.low_deg, 1.0, 89.0},
                {"thickness", &fork.thickness, 0.1, 1.0}},
               {"to", "high_deg"});
  fork.to = entry.at("to").number_between(fork.from, 0.95);
  fork.high_deg = entry.at("high_deg").number_between(fork.low_deg, 90.0);
  return fork;
}

Branching branching_of(const data::JsonReader& entry) {
  Branching branching{.per_whorl = 1};
  std::vector<PresetNumber> numbers{{"spacing_m", &branching.spacing_m, 0.01, 10.0},
                                    {"tip_density", &branching.tip_density, 1.0, 3.0},
                                    {"least", &branching.least, 1, 1000},
                                    {"azimuth_sd_deg", &branching.azimuth_sd_deg, 0.0, 90.0},
                                    {"sag", &branching.sag, -0.5, 0.5},
                                    {"crookedness", &branching.crookedness, 0.0, 0.3},
                                    {"thickness", &branching.thickness, 0.001, 0.4},
                                    {"thickest", &branching.thickest, 0.01, 1.0},
                                    {"stem_bend", &branching.stem_bend, 0.0, 0.5},
                                    {"segments", &branching.segments, 1, 12}};
  if (entry.at("arrangement").one_of({"whorls", "spiral"}) == 0) {
    numbers.push_back({"per_whorl", &branching.per_whorl, 1, 12});
  } else {
    branching.arrangement = Arrangement::kSpiral;
    numbers.push_back({"divergence_deg", &branching.divergence_deg, 0.0, 360.0});
  }
  read_numbers(entry,
               numbers,
               {"arrangement", "whorl_spread", "most", "angle_layers", "yearly_whorls", "fork"});
  branching.most = whole_number(entry.at("most"), branching.least, 1000);
  branching.layers = layers_of(entry.at("angle_layers"));
  if (entry.has("whorl_spread")) {
    branching.whorl_spread = entry.at("whorl_spread").number_between(0.0, 1.0);
  }
  if (const auto yearly = entry.find("yearly_whorls")) {
    const int low = whole_number(yearly->at("low"), 1, 20);
    branching.yearly = {low, whole_number(yearly->at("high"), low, 20)};
  }
  if (entry.has("fork")) branching.fork = fork_of(entry.at("fork"));
  return branching;
}

Twigs twigs_of(const data::JsonReader& entry) {
  Twigs twigs;
  read_numbers(entry,
               {{"spacing_m", &twigs.spacing_m, 0.01, 10.0},
                {"least", &twigs.least, 0, 100},
                {"angle_low_deg", &twigs.angle_low_deg, 1.0, 120.0},
                {"from", &twigs.from, 0.0, 0.95},
                {"relative_length", &twigs.relative_length, 0.01, 1.5},
                {"tip_length", &twigs.tip_length, 0.01, 1.0},
                {"spread_deg", &twigs.spread_deg, 0.0, 90.0},
                {"lift", &twigs.lift, -2.0, 2.0},
                {"segments", &twigs.segments, 1, 12}},
               {"arrangement", "most", "angle_high_deg", "has_wood"});
  twigs.arrangement = entry.at("arrangement").one_of({"pairs", "spiral"}) == 0
                          ? TwigArrangement::kPairs
                          : TwigArrangement::kSpiral;
  twigs.most = whole_number(entry.at("most"), twigs.least, 100);
  twigs.angle_high_deg =
      entry.at("angle_high_deg").number_between(twigs.angle_low_deg + 1.0, 130.0);
  twigs.has_wood = entry.at("has_wood").boolean();
  return twigs;
}

Foliage foliage_of(const data::JsonReader& entry) {
  Foliage foliage;
  std::vector<PresetNumber> numbers{{"color_variation", &foliage.color_variation, 0.0, 0.5}};
  int leaves_per_tuft = 0;
  double leaf_aspect = 0.0;
  if (entry.at("kind").one_of({"needles", "leaves"}) == 0) {
    numbers.insert(numbers.end(),
                   {{"fullness", &foliage.fullness, 0.05, 1.0},
                    {"lift", &foliage.lift, 0.0, 2.0},
                    {"droop", &foliage.droop, 0.0, 2.0}});
  } else {
    foliage.kind = FoliageKind::kLeaves;
    numbers.insert(numbers.end(),
                   {{"tufts_per_shoot", &foliage.tufts_per_shoot, 0, 20},
                    {"leaves_per_tuft", &leaves_per_tuft, 2, 60},
                    {"leaf_length_m", &foliage.leaf_length_m, 0.01, 2.0},
                    {"leaf_aspect", &leaf_aspect, 0.05, 2.0}});
  }
  read_numbers(entry, numbers, {"kind", "inner_color", "outer_color"});
  if (foliage.kind == FoliageKind::kLeaves) foliage.tuft = Tuft::of(leaves_per_tuft, leaf_aspect);
  foliage.inner = color_of(entry.at("inner_color"));
  foliage.outer = color_of(entry.at("outer_color"));
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(foliage.outer[i] > 0.0 && foliage.inner[i] <= foliage.outer[i])) {
      entry.at("outer_color").fail("must be above 0 and not darker than inner_color");
    }
  }
  return foliage;
}

}  // namespace

std::unique_ptr<SegmentBuilder> SegmentBuilder::load(const std::filesystem::path& models,
                                                     const std::filesystem::path& file) {
  const data::JsonReader entry = open_entry(file, "silvafit-preset/1");
  Preset preset;
  read_head(models, entry, preset);
  preset.branching = branching_of(entry.at("branching"));
  preset.twigs = twigs_of(entry.at("twigs"));
  if (entry.has("shoots")) preset.shoots = twigs_of(entry.at("shoots"));
  preset.foliage = foliage_of(entry.at("foliage"));
  for (std::size_t i = 0; i < preset.leaf.size(); ++i) {
    preset.leaf[i] = 0.5 * (preset.foliage.inner[i] + preset.foliage.outer[i]);
  }
  preset.leafy_shoots = leafy_shoots_of(models, entry.at("leafy_shoots"));
  if (entry.has("branch_count")) {
    preset.branch_count =
        BranchCount::load(models / "branch_count" / (entry.at("branch_count").text() + ".json"));
  }
  return std::make_unique<SegmentBuilder>(std::move(preset));
}

}  // namespace silvafit::tree
