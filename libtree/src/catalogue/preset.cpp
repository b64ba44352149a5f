// SPDX-License-Identifier: MIT
#include "silvafit/tree/preset.hpp"

#include <algorithm>

#include "catalogue/leafy_shoots_entry.hpp"
#include "catalogue/preset_head.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"

namespace silvafit::tree {
namespace {

namespace fs = std::filesystem;

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

YearlyWhorls yearly_whorls_of(const data::JsonReader& entry) {
  YearlyWhorls yearly;
  yearly.low = whole_number(entry.at("low"), 1, 20);
  yearly.high = whole_number(entry.at("high"), yearly.low, 20);
  return yearly;
}

Fork fork_of(const data::JsonReader& entry) {
  Fork fork;
  fork.limbs = whole_number(entry.at("limbs"), 1, 6);
  fork.from = entry.at("from").number_between(0.0, 0.9);
  fork.to = entry.at("to").number_between(fork.from, 0.95);
  fork.low_deg = entry.at("low_deg").number_between(1.0, 89.0);
  fork.high_deg = entry.at("high_deg").number_between(fork.low_deg, 90.0);
  fork.thickness = entry.at("thickness").number_between(0.1, 1.0);
  return fork;
}

Branching branching_of(const data::JsonReader& entry) {
  Branching branching;
  if (entry.at("arrangement").one_of({"whorls", "spiral"}) == 0) {
    branching.arrangement = Arrangement::kWhorls;
    branching.per_whorl = whole_number(entry.at("per_whorl"), 1, 12);
    if (entry.has("whorl_spread"))
      branching.whorl_spread = entry.at("whorl_spread").number_between(0.0, 1.0);
  } else {
    branching.arrangement = Arrangement::kSpiral;
    branching.per_whorl = 1;
    branching.divergence_deg = entry.at("divergence_deg").number_between(0.0, 360.0);
  }
  branching.spacing_m = entry.at("spacing_m").number_between(0.01, 10.0);
  branching.tip_density = entry.at("tip_density").number_between(1.0, 3.0);
  branching.least = whole_number(entry.at("least"), 1, 1000);
  branching.most = whole_number(entry.at("most"), branching.least, 1000);
  branching.azimuth_sd_deg = entry.at("azimuth_sd_deg").number_between(0.0, 90.0);
  branching.sag = entry.at("sag").number_between(-0.5, 0.5);
  branching.crookedness = entry.at("crookedness").number_between(0.0, 0.3);
  branching.thickness = entry.at("thickness").number_between(0.001, 0.4);
  branching.thickest = entry.at("thickest").number_between(0.01, 1.0);
  branching.stem_bend = entry.at("stem_bend").number_between(0.0, 0.5);
  branching.segments = whole_number(entry.at("segments"), 1, 12);
  branching.layers = layers_of(entry.at("angle_layers"));
  if (entry.has("yearly_whorls")) branching.yearly = yearly_whorls_of(entry.at("yearly_whorls"));
  if (entry.has("fork")) branching.fork = fork_of(entry.at("fork"));
  return branching;
}

Twigs twigs_of(const data::JsonReader& entry) {
  Twigs twigs;
  twigs.arrangement = entry.at("arrangement").one_of({"pairs", "spiral"}) == 0
                          ? TwigArrangement::kPairs
                          : TwigArrangement::kSpiral;
  twigs.spacing_m = entry.at("spacing_m").number_between(0.01, 10.0);
  twigs.least = whole_number(entry.at("least"), 0, 100);
  twigs.most = whole_number(entry.at("most"), twigs.least, 100);
  twigs.angle_low_deg = entry.at("angle_low_deg").number_between(1.0, 120.0);
  twigs.angle_high_deg =
      entry.at("angle_high_deg").number_between(twigs.angle_low_deg + 1.0, 130.0);
  twigs.from = entry.at("from").number_between(0.0, 0.95);
  twigs.relative_length = entry.at("relative_length").number_between(0.01, 1.5);
  twigs.tip_length = entry.at("tip_length").number_between(0.01, 1.0);
  twigs.spread_deg = entry.at("spread_deg").number_between(0.0, 90.0);
  twigs.lift = entry.at("lift").number_between(-2.0, 2.0);
  twigs.has_wood = entry.at("has_wood").boolean();
  twigs.segments = whole_number(entry.at("segments"), 1, 12);
  return twigs;
}

Foliage foliage_of(const data::JsonReader& entry) {
  Foliage foliage;
  if (entry.at("kind").one_of({"needles", "leaves"}) == 0) {
    foliage.kind = FoliageKind::kNeedles;
    foliage.fullness = entry.at("fullness").number_between(0.05, 1.0);
    foliage.lift = entry.at("lift").number_between(0.0, 2.0);
    foliage.droop = entry.at("droop").number_between(0.0, 2.0);
  } else {
    foliage.kind = FoliageKind::kLeaves;
    foliage.tufts_per_shoot = whole_number(entry.at("tufts_per_shoot"), 0, 20);
    foliage.leaves_per_tuft = whole_number(entry.at("leaves_per_tuft"), 2, 60);
    foliage.leaf_length_m = entry.at("leaf_length_m").number_between(0.01, 2.0);
    foliage.leaf_aspect = entry.at("leaf_aspect").number_between(0.05, 2.0);
    foliage.tuft = Tuft::of(foliage.leaves_per_tuft, foliage.leaf_aspect);
  }
  foliage.inner = color_of(entry.at("inner_color"));
  foliage.outer = color_of(entry.at("outer_color"));
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(foliage.outer[i] > 0.0 && foliage.inner[i] <= foliage.outer[i])) {
      entry.at("outer_color").fail("must be above 0 and not darker than inner_color");
    }
  }
  foliage.color_variation = entry.at("color_variation").number_between(0.0, 0.5);
  return foliage;
}

Preset preset_of(const fs::path& models, const fs::path& file) {
  const data::JsonReader entry = open_entry(file, "silvafit-preset/1");
  const PresetHead head = preset_head_of(models, entry);
  Preset preset;
  preset.name = head.name;
  preset.title = head.title;
  preset.species = head.species;
  preset.crown_index = head.crown_index;
  preset.relative_hc = head.relative_hc;
  preset.taper = head.taper;
  preset.branching = branching_of(entry.at("branching"));
  preset.twigs = twigs_of(entry.at("twigs"));
  if (entry.has("shoots")) preset.shoots = twigs_of(entry.at("shoots"));
  preset.foliage = foliage_of(entry.at("foliage"));
  preset.leafy_shoots = leafy_shoots_of(models, entry.at("leafy_shoots"));
  preset.bark = bark_of(models, entry);
  if (entry.has("branch_count")) {
    preset.branch_count =
        BranchCount::load(models / "branch_count" / (entry.at("branch_count").text() + ".json"));
  }
  return preset;
}

}  // namespace

PresetCatalogue PresetCatalogue::load(const fs::path& models) {
  const fs::path folder = models / "presets";
  if (kind_of(folder) != PathKind::kFolder) {
    throw InputError("no species presets in this folder", {.file = folder.string()});
  }
  PresetCatalogue catalogue;
  for (const auto& file : files_in_folder(folder, ".json")) {
    catalogue.presets_.push_back(preset_of(models, file));
  }
  std::sort(catalogue.presets_.begin(),
            catalogue.presets_.end(),
            [](const Preset& a, const Preset& b) { return a.name < b.name; });
  return catalogue;
}

const Preset& PresetCatalogue::named(std::string_view name) const {
  std::string names;
  for (const Preset& preset : presets_) {
    if (preset.name == name) return preset;
    names += (names.empty() ? "" : ", ") + preset.name;
  }
  throw UsageError("unknown preset '" + std::string(name) + "'; available: " + names);
}

}  // namespace silvafit::tree
